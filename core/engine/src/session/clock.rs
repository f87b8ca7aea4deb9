//! Simulated time of a session: a whole number of equal steps.

/// Length and number of the steps of a session.
pub(super) struct Clock {
    /// Length of a step, s.
    pub(super) dt: f64,
    /// Number of steps taken.
    pub(super) steps: u64,
}

impl Clock {
    /// Simulated time since the start, s.
    pub(super) fn time(&self) -> f64 {
        self.steps as f64 * self.dt
    }
}
