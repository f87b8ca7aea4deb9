//! Clocks of a report, and a plausibility check of them.

use std::sync::OnceLock;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Two clocks, s. They are arguments of a report, so that a test can pass broken ones.
#[derive(Clone, Copy)]
pub struct Clock {
    /// Wall-clock time since an arbitrary origin, s.
    pub wall: fn() -> f64,
    /// Processor time of all running threads, s.
    pub cpu: fn() -> f64,
}

impl Default for Clock {
    fn default() -> Self {
        Self { wall: monotonic, cpu: thread_seconds }
    }
}

/// Whether the clock of a report agrees with the system's calendar and the number of threads.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct ClockCheck {
    /// Duration of the report by its own clock, s.
    pub wall_seconds: f64,
    /// Duration of the report by the system's calendar, s.
    pub calendar_seconds: f64,
    /// Processor time of all runs relative to the wall-clock time of their threads.
    pub cpu_share: f64,
    /// Whether both durations agree to 2 % and the ratio is at most 1.1.
    pub passed: bool,
}

/// Time that runs took, summed over runs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BusyTime {
    /// Wall-clock time of each run times its number of threads, s.
    pub(crate) thread_wall: f64,
    /// Processor time of all threads, s.
    pub(crate) cpu: f64,
}

/// A clock check in progress.
pub(crate) struct ClockWatch {
    clock: Clock,
    /// Time of the report's clock at the start, s.
    wall: f64,
    /// Calendar time at the start, s.
    calendar: f64,
}

impl ClockWatch {
    /// Starts a check.
    pub(crate) fn start(clock: Clock) -> Self {
        Self { clock, wall: (clock.wall)(), calendar: calendar() }
    }

    /// Ends the check; `busy` is the time of all runs since the start.
    pub(crate) fn check(&self, busy: BusyTime) -> ClockCheck {
        let (wall_seconds, calendar_seconds) = ((self.clock.wall)() - self.wall, calendar() - self.calendar);
        let cpu_share = if busy.thread_wall > 0.0 { busy.cpu / busy.thread_wall } else { 0.0 };
        // The calendar does not resolve durations below 5 ms.
        let slack = 0.02 * calendar_seconds + 5e-3;
        let passed = (wall_seconds - calendar_seconds).abs() <= slack && (0.0..=1.1).contains(&cpu_share);
        ClockCheck { wall_seconds, calendar_seconds, cpu_share, passed }
    }
}

/// Time of a monotonic clock since its first reading, s.
fn monotonic() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

/// Time since 1970 by the system's calendar, s.
fn calendar() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64())
}

/// Processor time of the running threads of this program, as reported by the system, s.
fn thread_seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let ran = tasks.filter_map(|task| std::fs::read_to_string(task.path().join("schedstat")).ok());
    ran.filter_map(|text| text.split(' ').next()?.parse::<u64>().ok()).sum::<u64>() as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a clock passes the check after a busy loop of 200 ms.
    fn passes(clock: Clock) -> bool {
        let watch = ClockWatch::start(clock);
        let (wall, cpu) = ((clock.wall)(), (clock.cpu)());
        let until = Instant::now() + std::time::Duration::from_millis(200);
        let mut x = 1.0_f64;
        while Instant::now() < until {
            x = std::hint::black_box(x.sqrt() + 1.0);
        }
        watch.check(BusyTime { thread_wall: (clock.wall)() - wall, cpu: (clock.cpu)() - cpu }).passed
    }

    #[test]
    fn a_clock_that_runs_wrong_is_found_out() {
        assert!(!passes(Clock { wall: || 0.5 * monotonic(), ..Clock::default() }), "half as fast");
        assert!(!passes(Clock { wall: || 1.05 * monotonic(), ..Clock::default() }), "5 % too fast");
        assert!(!passes(Clock { wall: || 0.0, ..Clock::default() }), "standing");
        assert!(!passes(Clock { wall: || -monotonic(), ..Clock::default() }), "backwards");
        assert!(!passes(Clock { cpu: || 4e3 * monotonic(), ..Clock::default() }), "more work than threads can do");
    }
}
