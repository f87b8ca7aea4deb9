//! What a solver is given, and how it went.

use crate::algebra::Vec3;
use crate::constraint::Constraint;
use crate::matrix::Matrix;

/// `S A x = S b`, `(I - S) x = (I - S) z`.
pub struct Solve<'a> {
    /// `A`.
    pub matrix: &'a Matrix,
    /// Right side (n x 3).
    pub b: &'a [Vec3],
    /// What is prescribed (n x 3).
    pub z: &'a [Vec3],
    /// `S` (n).
    pub constraints: &'a [Constraint],
    /// m, positions that the solution moves (n x 3), and by how much a unit of it does
    pub motion: (&'a [Vec3], f64),
    /// Whether the matrix is that of the last solve.
    pub again: bool,
    /// Relative to the filtered right side, in the preconditioner's norm.
    pub tolerance: f64,
    /// Iterations at most.
    pub most: usize,
}

/// How a solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Products with the matrix after the first residual.
    pub iterations: usize,
    /// Final residual over the scale of the stopping test; not finite if the system was not.
    pub residual: f64,
    /// Whether the tolerance was met.
    pub converged: bool,
    /// Whether a direction of no or negative curvature was met, or a number that is not finite.
    pub broken: bool,
    /// Whether the matrix was rounded and must not be; then nothing is solved.
    pub too_rough: bool,
    /// Whether it was told to stop before it was done, and `r . P r` as it was then.
    pub stopped: Option<f64>,
}

impl SolveReport {
    /// Fills in how it ended, with `r . P r` and the scale of its stopping test.
    pub(super) fn close(&mut self, d: f64, scale: f64, (enough, floor): (f64, f64)) {
        self.broken |= !d.is_finite();
        // A scale that is not finite, or overflowed, measures nothing; one below the floor is zero.
        self.residual = match scale {
            _ if !scale.is_finite() => f64::NAN,
            _ if d <= floor && scale <= floor => 0.0,
            _ => (d / scale).sqrt(),
        };
        self.converged = d <= enough && d >= 0.0 && !self.broken;
    }
}
