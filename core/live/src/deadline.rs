//! Deadlines of ticks and steps, as arithmetic on times that the caller reads from a clock.

/// Equidistant deadlines of ticks. A late tick does not shift later deadlines.
#[derive(Clone, Debug)]
pub(crate) struct Deadlines {
    start: u64,
    rate: f64,
    /// Number of the next tick.
    next: u64,
    /// Number of missed deadlines: ticks not finished before the next one was due.
    pub(crate) missed: u64,
}

impl Deadlines {
    /// Deadlines at `rate` (Hz) from `start` (ns).
    pub(crate) fn new(start: u64, rate: f64) -> Self {
        Self { start, rate, next: 0, missed: 0 }
    }

    /// Deadline of the next tick, ns.
    pub(crate) fn due(&self) -> u64 {
        self.start + (self.next as f64 * 1e9 / self.rate) as u64
    }

    /// Records the end of a tick at `now` (ns). Each whole period it is late counts as a missed deadline; those ticks are skipped.
    pub(crate) fn finish_tick(&mut self, now: u64) {
        let missed = (now.saturating_sub(self.due()) as f64 * 1e-9 * self.rate) as u64;
        self.missed += missed;
        self.next += missed + 1;
    }
}

/// Synchronises the steps of a simulation with the wall clock.
#[derive(Clone, Debug)]
pub(crate) struct Pacer {
    /// Period of the steps, ns.
    dt: u64,
    /// Deadline of the next step, ns.
    due: u64,
    /// Simulated time that was skipped, ns.
    pub(crate) lost: u64,
}

/// Largest number of overdue steps that are caught up; the time of the others is skipped.
const MAX_CATCH_UP: u64 = 4;

impl Pacer {
    /// Steps of `dt` (s) from `start` (ns).
    pub(crate) fn new(start: u64, dt: f64) -> Self {
        let dt = ((dt * 1e9).round() as u64).max(1);
        Self { dt, due: start + dt, lost: 0 }
    }

    /// Time to wait at `now` until the next step is due, both in ns; `None` if it is due, and then it counts as taken.
    pub(crate) fn poll(&mut self, now: u64) -> Option<u64> {
        if now < self.due {
            return Some(self.due - now);
        }
        let (behind, limit) = (now - self.due, MAX_CATCH_UP * self.dt);
        if behind > limit {
            self.lost += behind - limit;
            self.due += behind - limit;
        }
        self.due += self.dt;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_late_tick_misses_whole_periods_and_later_deadlines_stay() {
        let mut deadlines = Deadlines::new(10 * MS, 1000.0);
        assert_eq!(deadlines.due(), 10 * MS);
        deadlines.finish_tick(10 * MS + 900_000);
        assert_eq!((deadlines.due(), deadlines.missed), (11 * MS, 0));
        deadlines.finish_tick(14 * MS + 200_000);
        assert_eq!((deadlines.due(), deadlines.missed), (15 * MS, 3));
        // Deadlines do not drift, even if the period is not a whole number of ns.
        let mut thirds = Deadlines::new(0, 3000.0);
        for _ in 0..3_000_000 {
            thirds.finish_tick(thirds.due());
        }
        assert_eq!((thirds.due(), thirds.missed), (1_000_000_000_000, 0));
    }

    #[test]
    fn a_late_simulation_catches_up_by_four_steps_and_the_rest_is_lost() {
        let mut pacer = Pacer::new(0, 1e-3);
        assert_eq!(pacer.poll(0), Some(MS));
        assert_eq!(pacer.poll(MS), None);
        assert_eq!(pacer.poll(MS), Some(MS));
        // After a delay of half a second the due step and four more are taken, and the rest is skipped.
        let now = 500 * MS;
        let steps = std::iter::from_fn(|| pacer.poll(now).is_none().then_some(())).count();
        assert_eq!((steps, pacer.lost), (5, 494 * MS));
        assert_eq!(pacer.poll(now), Some(MS));
    }
}
