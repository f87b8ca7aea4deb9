//! Whether a body's steps are done sooner by all threads or by one.
//!
//! Threads tell each other many times in a step what is done. How long that takes depends on where the system has put them: on
//! processors that share no cache a small step takes longer with two than with one, and the system may move them at any time. Bytes
//! are the same either way, so both are tried.

/// Steps of a trial, of which the quickest counts.
const TRIAL: u32 = 3;
/// Steps from one trial to the next: after a change, and at most, for each trial that changes nothing doubles them.
const BETWEEN: [u32; 2] = [64, 2048];
/// Share of the time that the other way has to save.
const WORTH: f64 = 0.1;

/// How a body's steps are done, and what they took of late.
#[derive(Clone, Copy, Debug)]
pub(super) struct ThreadChoice {
    /// Whether one thread is usual.
    alone: bool,
    /// Steps since the last trial ended, and from then to the next.
    steps: u32,
    between: u32,
    /// s, the quickest of the last usual ones before a trial, and of the trial
    least: [f64; 2],
}

impl Default for ThreadChoice {
    fn default() -> Self {
        Self { alone: false, steps: 0, between: BETWEEN[0], least: [f64::INFINITY; 2] }
    }
}

impl ThreadChoice {
    /// Whether one thread does the next step.
    pub(super) fn is_alone(&self) -> bool {
        self.alone != self.is_trial()
    }

    fn is_trial(&self) -> bool {
        self.steps >= self.between
    }

    /// Tells how long it took, s.
    pub(super) fn took(&mut self, seconds: f64) {
        if self.steps + TRIAL >= self.between {
            let least = &mut self.least[usize::from(self.is_trial())];
            *least = least.min(seconds);
        }
        self.steps += 1;
        if self.steps < self.between + TRIAL {
            return;
        }
        let changes = self.least[1] < (1.0 - WORTH) * self.least[0];
        let between = if changes { BETWEEN[0] } else { BETWEEN[1].min(2 * self.between) };
        *self = Self { alone: self.alone != changes, between, ..Self::default() };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Goes on for so many steps that take so long with all threads and with one, but for some that take long for other reasons. Gives
    /// how many were alone.
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
    fn the_quicker_way_is_taken_and_the_other_tried_now_and_then() {
        let mut choice = ThreadChoice::default();
        // Threads help, or as good as: one is tried three times after 64, 128, 256 ... steps.
        assert_eq!(go(&mut choice, 1100, [0.27e-3, 0.34e-3]), 4 * 3);
        assert_eq!(go(&mut choice, 1000, [0.34e-3, 0.32e-3]), 3);
        // They are moved apart, and together again.
        let alone = go(&mut choice, 8000, [0.47e-3, 0.34e-3]);
        assert!(choice.alone && alone > 6000 && alone < 7990, "{alone}");
        let alone = go(&mut choice, 8000, [0.27e-3, 0.34e-3]);
        assert!(!choice.alone && alone < 2100, "{alone}");
    }
}
