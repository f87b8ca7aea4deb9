//! When the next tick and the next step are due. Plain arithmetic on a clock somebody else reads.

/// Ticks at equal distances from a start, whatever became of those before.
#[derive(Clone, Debug)]
pub struct Deadlines {
    start: u64,
    rate: f64,
    next: u64,
    /// Ticks that were not done before the next was due.
    pub missed: u64,
}

impl Deadlines {
    /// `rate` (Hz) from `start` (ns) on.
    pub fn new(start: u64, rate: f64) -> Self {
        Self { start, rate, next: 0, missed: 0 }
    }

    /// ns, when the next tick is due
    pub fn due(&self) -> u64 {
        self.start + (self.next as f64 * 1e9 / self.rate) as u64
    }

    /// A tick was done at `now` (ns). Each whole period it went over is a missed deadline; those ticks are not made up for.
    pub fn done(&mut self, now: u64) {
        let over = (now.saturating_sub(self.due()) as f64 * 1e-9 * self.rate) as u64;
        self.missed += over;
        self.next += over + 1;
    }
}

/// Steps of a simulation after the wall clock.
#[derive(Clone, Debug)]
pub struct Pacer {
    dt: u64,
    due: u64,
    /// ns, that the simulation is behind the clock for good
    pub lost: u64,
}

/// Steps that are made up for at most; the time of the others is lost.
const CATCH_UP: u64 = 4;

impl Pacer {
    /// Steps of `dt` (s) from `start` (ns) on.
    pub fn new(start: u64, dt: f64) -> Self {
        let dt = ((dt * 1e9).round() as u64).max(1);
        Self { dt, due: start + dt, lost: 0 }
    }

    /// ns to wait at `now` until the next step is due; `None`: it is, and was taken.
    pub fn wait(&mut self, now: u64) -> Option<u64> {
        if now < self.due {
            return Some(self.due - now);
        }
        let (behind, most) = (now - self.due, CATCH_UP * self.dt);
        if behind > most {
            self.lost += behind - most;
            self.due += behind - most;
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
    fn a_late_tick_misses_whole_periods_and_the_grid_stays() {
        let mut deadlines = Deadlines::new(10 * MS, 1000.0);
        assert_eq!(deadlines.due(), 10 * MS);
        deadlines.done(10 * MS + 900_000);
        assert_eq!((deadlines.due(), deadlines.missed), (11 * MS, 0));
        deadlines.done(14 * MS + 200_000);
        assert_eq!((deadlines.due(), deadlines.missed), (15 * MS, 3));
        // No drift, also at a rate whose period is no whole number of ns.
        let mut thirds = Deadlines::new(0, 3000.0);
        for _ in 0..3_000_000 {
            thirds.done(thirds.due());
        }
        assert_eq!((thirds.due(), thirds.missed), (1_000_000_000_000, 0));
    }

    #[test]
    fn what_is_behind_is_made_up_for_by_four_steps_and_the_rest_is_counted() {
        let mut pacer = Pacer::new(0, 1e-3);
        assert_eq!(pacer.wait(0), Some(MS));
        assert_eq!(pacer.wait(MS), None);
        assert_eq!(pacer.wait(MS), Some(MS));
        // Half a second gone: the step that is due and four more, the rest is lost.
        let now = 500 * MS;
        let steps = std::iter::from_fn(|| pacer.wait(now).is_none().then_some(())).count();
        assert_eq!((steps, pacer.lost), (5, 494 * MS));
        assert_eq!(pacer.wait(now), Some(MS));
    }
}
