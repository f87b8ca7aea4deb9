//! Choice between one thread and all threads for a body's steps, by trials.
//!
//! Threads synchronise many times in a step. The cost depends on their processors: without a shared cache a small step takes longer with two threads
//! than with one, and the system may migrate them at any time. Results are bit-identical either way, so both are tried.

/// Number of steps of a trial, of which the fastest counts.
const TRIAL_STEPS: u32 = 3;
/// Smallest and largest number of steps between trials: the smallest after a change; every trial without a change doubles it.
const TRIAL_INTERVAL: [u32; 2] = [64, 2048];
/// Smallest fraction of the time that the alternative must save.
const MIN_GAIN: f64 = 0.1;

/// The present choice for a body, and recent times of its steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThreadChoice {
    /// Whether one thread is the present choice.
    alone: bool,
    /// Number of steps since the last trial, and between trials.
    steps: u32,
    between: u32,
    /// Time of the fastest step before a trial with the present choice, and during the trial, s.
    least: [f64; 2],
}

impl Default for ThreadChoice {
    fn default() -> Self {
        Self { alone: false, steps: 0, between: TRIAL_INTERVAL[0], least: [f64::INFINITY; 2] }
    }
}

impl ThreadChoice {
    /// Whether the next step uses one thread.
    pub(super) fn is_alone(&self) -> bool {
        self.alone != self.is_trial()
    }

    fn is_trial(&self) -> bool {
        self.steps >= self.between
    }

    /// Records the duration of a step, s.
    pub(super) fn took(&mut self, seconds: f64) {
        if self.steps + TRIAL_STEPS >= self.between {
            let least = &mut self.least[usize::from(self.is_trial())];
            *least = least.min(seconds);
        }
        self.steps += 1;
        if self.steps < self.between + TRIAL_STEPS {
            return;
        }
        let changes = self.least[1] < (1.0 - MIN_GAIN) * self.least[0];
        let between = if changes { TRIAL_INTERVAL[0] } else { TRIAL_INTERVAL[1].min(2 * self.between) };
        *self = Self { alone: self.alone != changes, between, ..Self::default() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simulates steps with these durations for all threads and for one thread, with some slower outliers. Returns the number of steps with one thread.
    fn go(choice: &mut ThreadChoice, steps: usize, [all, one]: [f64; 2]) -> usize {
        let mut alone = 0;
        for step in 0..steps {
            alone += usize::from(choice.is_alone());
            let slow = if step % 3 == 0 { 2.0 } else { 1.0 };
            choice.took(slow * if choice.is_alone() { one } else { all });
        }
        alone
    }

    #[test]
    fn the_faster_choice_is_kept_and_the_other_is_tried() {
        let mut choice = ThreadChoice::default();
        // Threads help, or hardly matter: one thread is tried for three steps after 64, 128, 256 ... steps.
        assert_eq!(go(&mut choice, 1100, [0.27e-3, 0.34e-3]), 4 * 3);
        assert_eq!(go(&mut choice, 1000, [0.34e-3, 0.32e-3]), 3);
        // Threads migrate to processors without a shared cache, and back.
        let alone = go(&mut choice, 8000, [0.47e-3, 0.34e-3]);
        assert!(choice.alone && alone > 6000 && alone < 7990, "{alone}");
        let alone = go(&mut choice, 8000, [0.27e-3, 0.34e-3]);
        assert!(!choice.alone && alone < 2100, "{alone}");
    }
}
