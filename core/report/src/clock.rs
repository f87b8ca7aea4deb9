//! What time is, and whether it can be believed.

use std::sync::OnceLock;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

/// Two clocks, s. A report takes them as arguments, so that a test can hand it broken ones.
#[derive(Clone, Copy)]
pub struct Clock {
    /// Since any moment.
    pub wall: fn() -> f64,
    /// Of all threads that live.
    pub cpu: fn() -> f64,
}

impl Default for Clock {
    fn default() -> Self {
        Self { wall: monotonic, cpu: threads }
    }
}

/// Whether the clock ran as the system's calendar did while the report was made.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct ClockCheck {
    /// s, by the clock of the report
    pub wall_seconds: f64,
    /// s, by the calendar
    pub calendar_seconds: f64,
    /// Share of CPU seconds in wall seconds of all runs, over the threads that could work.
    pub cpu_share: f64,
    /// Within 2 %, and no more CPU seconds than threads could have used, with 10 % to spare.
    pub passed: bool,
}

/// Begins a check.
pub(super) struct Watch {
    clock: Clock,
    began: (f64, f64, f64),
}

impl Watch {
    pub(super) fn start(clock: Clock) -> Self {
        Self { clock, began: ((clock.wall)(), calendar(), (clock.cpu)()) }
    }

    /// `ran` are the wall and CPU seconds of all runs, each counted with the threads it had.
    pub(super) fn check(&self, ran: (f64, f64)) -> ClockCheck {
        let (wall_seconds, calendar_seconds) = ((self.clock.wall)() - self.began.0, calendar() - self.began.1);
        let cpu_share = if ran.0 > 0.0 { ran.1 / ran.0 } else { 0.0 };
        // What is shorter than this the calendar cannot judge.
        let slack = 0.02 * calendar_seconds + 5e-3;
        let passed = (wall_seconds - calendar_seconds).abs() <= slack && (0.0..=1.1).contains(&cpu_share);
        ClockCheck { wall_seconds, calendar_seconds, cpu_share, passed }
    }
}

fn monotonic() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_secs_f64()
}

fn calendar() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64())
}

/// s that the threads of this program have run for, as far as the system tells.
fn threads() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let ran = tasks.filter_map(|task| std::fs::read_to_string(task.path().join("schedstat")).ok());
    ran.filter_map(|text| text.split(' ').next()?.parse::<u64>().ok()).sum::<u64>() as f64 * 1e-9
}

#[cfg(test)]
mod tests {
    use super::*;

    fn passes(clock: Clock) -> bool {
        let watch = Watch::start(clock);
        let (wall, cpu) = ((clock.wall)(), (clock.cpu)());
        let until = Instant::now() + std::time::Duration::from_millis(200);
        let mut x = 1.0_f64;
        while Instant::now() < until {
            x = std::hint::black_box(x.sqrt() + 1.0);
        }
        watch.check(((clock.wall)() - wall, (clock.cpu)() - cpu)).passed
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
