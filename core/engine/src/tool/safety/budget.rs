//! What a device's motors bear for long: their heat goes with the square of the force.

use pliant_solver::Vec3;

/// Mean square of the force over about ten seconds, and what it leaves.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    peak: f64,
    continuous: f64,
    /// N^2
    mean_square: f64,
}

/// s, over which the mean goes
const WINDOW: f64 = 10.0;
/// Share of the rating from which on less than the peak is allowed, so that nothing is cut off at once.
const TAPER: f64 = 0.9;

impl Budget {
    /// Of motors that are cold; both limits in N.
    pub fn new(peak: f64, continuous: f64) -> Self {
        Self { peak, continuous: continuous.min(peak), mean_square: 0.0 }
    }

    /// What may be given now: the peak, and less from 0.9 of the continuous rating on, so that the mean ends at it, N.
    pub fn allowed(&self) -> f64 {
        let used = self.mean_square.sqrt() / self.continuous;
        let over = ((used - TAPER) / (1.0 - TAPER)).clamp(0.0, 1.0);
        self.peak + over * (self.continuous - self.peak)
    }

    /// Takes a force (N) given for `dt` (s) into the mean.
    pub fn spend(&mut self, force: Vec3, dt: f64) {
        let share = (dt / WINDOW).min(1.0);
        self.mean_square += share * (force.norm_squared() - self.mean_square);
    }
}
