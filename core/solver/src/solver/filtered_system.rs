//! The filtered linear system of a step, and the report of its solution.

use crate::algebra::Vec3;
use crate::constraint::Constraint;
use crate::matrix::Matrix;

/// The system `S A x = S b`, `(I - S) x = (I - S) z` (Baraff and Witkin 1998): S filters out the constrained directions of each node, z
/// prescribes x in them.
pub struct FilteredSystem<'a> {
    /// `A`, symmetric, positive definite on the free directions.
    pub matrix: &'a Matrix,
    /// Right side (n x 3).
    pub b: &'a [Vec3],
    /// Prescribed part of x (n x 3); zero where nothing is prescribed.
    pub z: &'a [Vec3],
    /// `S`, one constraint for each node (n).
    pub constraints: &'a [Constraint],
    /// Positions that the solution changes, m (n x 3). A residual that would change none by its last digit counts as zero.
    pub positions: &'a [Vec3],
    /// By how much a unit of x changes positions: seconds for velocities, 1 for displacements.
    pub displacement_per_unit: f64,
    /// Whether the matrix is that of the last solve; then only constraints and right side have changed.
    pub same_matrix: bool,
    /// Tolerance, relative to the filtered right side, in the norm of the preconditioner.
    pub tolerance: f64,
    /// Largest number of iterations of a solve.
    pub max_iterations: usize,
}

/// Report of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Products with the matrix after the first residual.
    pub iterations: usize,
    /// Final residual over the scale of the stopping test; not finite if the system was not.
    pub residual: f64,
    /// Whether the tolerance was met.
    pub converged: bool,
    /// Whether a direction of zero or negative curvature, or a number that is not finite, was met.
    pub broken: bool,
    /// Whether the matrix is stored in single precision and its rounding is too large for the tolerance; then nothing is solved.
    pub needs_f64: bool,
    /// `r . P r` when the solve was stopped early; `None` if it was not stopped.
    pub stopped_at: Option<f64>,
}

/// The stopping test of a solve, on `r . P r`.
#[derive(Clone, Copy, Debug)]
pub(super) struct StoppingTest {
    /// `r . P r` of the right side.
    pub scale: f64,
    /// The solve has converged at this value.
    pub target: f64,
    /// Values below this come from rounding alone.
    pub floor: f64,
}

impl StoppingTest {
    /// The test for a relative tolerance.
    pub(super) fn new(tolerance: f64, scale: f64, floor: f64) -> Self {
        Self { scale, target: (tolerance * tolerance * scale).max(floor), floor }
    }
}

impl SolveReport {
    /// Fills in how the solve ended, from its last `d = r . P r`.
    pub(super) fn close(&mut self, d: f64, test: StoppingTest) {
        let StoppingTest { scale, target, floor } = test;
        self.broken |= !d.is_finite();
        // A scale that is not finite, or overflowed, measures nothing; one below the floor is zero.
        self.residual = match scale {
            _ if !scale.is_finite() => f64::NAN,
            _ if d <= floor && scale <= floor => 0.0,
            _ => (d / scale).sqrt(),
        };
        self.converged = d <= target && d >= 0.0 && !self.broken;
    }
}
