//! Thermal budget of a device's motors: their heat is proportional to the square of the force.

use pliant_solver::Vec3;

/// Moving mean square of the force over about ten seconds, and the largest force it allows next.
#[derive(Clone, Copy, Debug)]
pub struct Budget {
    /// Peak force, N.
    peak: f64,
    /// Continuous rating, N; at most `peak`.
    continuous: f64,
    /// Exponential moving average of the squared force, N^2.
    mean_square: f64,
}

/// Time constant of the moving average, s.
const WINDOW: f64 = 10.0;
/// Fraction of the continuous rating above which the limit falls linearly from the peak to the rating, so it never jumps.
const TAPER: f64 = 0.9;

impl Budget {
    /// The budget of cold motors, with the peak force and the continuous rating in N.
    pub fn new(peak: f64, continuous: f64) -> Self {
        Self { peak, continuous: continuous.min(peak), mean_square: 0.0 }
    }

    /// Largest force allowed now, N: the peak while the root mean square is below 0.9 of the continuous rating, then falling to the rating.
    pub fn allowed(&self) -> f64 {
        let used = self.mean_square.sqrt() / self.continuous;
        let over = ((used - TAPER) / (1.0 - TAPER)).clamp(0.0, 1.0);
        self.peak + over * (self.continuous - self.peak)
    }

    /// Goes on from the heat of another budget; `factor` is a force of this one over the same force of that one.
    pub fn resume(&mut self, before: &Self, factor: f64) {
        self.mean_square = factor * factor * before.mean_square;
    }

    /// Adds a force (N) applied for `dt` (s) to the moving average.
    pub fn record(&mut self, force: Vec3, dt: f64) {
        let weight = (dt / WINDOW).min(1.0);
        self.mean_square += weight * (force.norm_squared() - self.mean_square);
    }
}
