//! When the next tick and the next step are due: plain arithmetic on times that the caller reads from a clock.

/// Deadlines of ticks at equal distances from a start. A late tick does not move those after it.
#[derive(Clone, Debug)]
pub(crate) struct Deadlines {
    start: u64,
    rate: f64,
    /// Number of the next tick.
    next: u64,
    /// Number of ticks that were not finished before the next was due.
    pub(crate) missed: u64,
}

impl Deadlines {
    /// Ticks at `rate` (Hz) from `start` (ns) on.
    pub(crate) fn new(start: u64, rate: f64) -> Self {
        Self { start, rate, next: 0, missed: 0 }
    }

    /// ns, time at which the next tick is due
    pub(crate) fn due(&self) -> u64 {
        self.start + (self.next as f64 * 1e9 / self.rate) as u64
    }

    /// The tick was finished at `now` (ns). Each whole period it is late is a missed deadline; those ticks are skipped.
    pub(crate) fn finish_tick(&mut self, now: u64) {
        let missed = (now.saturating_sub(self.due()) as f64 * 1e-9 * self.rate) as u64;
        self.missed += missed;
        self.next += missed + 1;
    }
}

/// Paces the steps of a simulation after the wall clock.
#[derive(Clone, Debug)]
pub(crate) struct Pacer {
    /// ns
    dt: u64,
    /// ns, time at which the next step is due
    due: u64,
    /// ns, time the simulation fell behind the clock and does not catch up
    pub(crate) lost: u64,
}

/// Largest number of overdue steps that are taken at once; the time of the others is lost.
const MAX_CATCH_UP: u64 = 4;

impl Pacer {
    /// Steps of `dt` (s) from `start` (ns) on.
    pub(crate) fn new(start: u64, dt: f64) -> Self {
        let dt = ((dt * 1e9).round() as u64).max(1);
        Self { dt, due: start + dt, lost: 0 }
    }

    /// Time (ns) to wait at `now` (ns) until the next step is due. `None` if it is due: it then counts as taken.
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
        // No drift, also at a rate whose period is no whole number of ns.
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
        // Half a second gone: the step that is due and four more, the rest is lost.
        let now = 500 * MS;
        let steps = std::iter::from_fn(|| pacer.poll(now).is_none().then_some(())).count();
        assert_eq!((steps, pacer.lost), (5, 494 * MS));
        assert_eq!(pacer.poll(now), Some(MS));
    }
}
