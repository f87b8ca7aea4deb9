//! The filtered linear system of a step, and the report of its solution.

use crate::algebra::Vec3;
use crate::constraint::Constraint;
use crate::interrupts::Interrupts;
use crate::matrix::Matrix;

/// The system `S A x = S b`, `(I - S) x = (I - S) z` (Baraff and Witkin 1998). S projects each node onto its free directions; z prescribes x in
/// the constrained ones.
pub struct FilteredSystem<'a> {
    /// `A`, symmetric, positive definite on the free directions.
    pub matrix: &'a Matrix,
    /// Right-hand side (n x 3).
    pub b: &'a [Vec3],
    /// Prescribed values of x (n x 3); zero at free nodes.
    pub z: &'a [Vec3],
    /// `S`, one constraint for each node (n).
    pub constraints: &'a [Constraint],
    /// Positions that the solution changes, m (n x 3). A residual whose correction is below the last digit of every position counts as zero.
    pub positions: &'a [Vec3],
    /// Change of positions (m) per unit of x: the effective step size in s for velocities, 1 for displacements.
    pub displacement_per_unit: f64,
    /// Whether the matrix is that of the last solve, so that only constraints and right-hand side have changed.
    pub same_matrix: bool,
    /// Tolerance, relative to the filtered right-hand side, in the norm of the preconditioner.
    pub tolerance: f64,
    /// Largest number of iterations of a solve.
    pub max_iterations: usize,
    /// What ends the solve before its tolerance is met; the solution then means nothing. `None` for nothing.
    pub interrupts: Option<&'a Interrupts>,
}

impl FilteredSystem<'_> {
    /// Whether the solve is to end at once.
    pub(super) fn is_interrupted(&self) -> bool {
        self.interrupts.is_some_and(Interrupts::is_interrupted)
    }
}

/// Report of a solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Products with the matrix after the first residual.
    pub iterations: usize,
    /// Final residual relative to the right-hand side, in the norm of the preconditioner; NaN if the right-hand side is not finite.
    pub residual: f64,
    /// Whether the tolerance was met.
    pub converged: bool,
    /// Whether a direction had zero or negative curvature, or a number was not finite.
    pub broken: bool,
    /// Whether the matrix is stored in single precision and its rounding is too large for the tolerance; nothing has been solved then.
    pub needs_f64: bool,
    /// `r . P r` when the solve was stopped early; `None` if it was not stopped.
    pub stopped_at: Option<f64>,
}

/// The stopping test of a solve, on `r . P r`.
#[derive(Clone, Copy, Debug)]
pub(super) struct StoppingTest {
    /// `r . P r` of the filtered right-hand side.
    pub scale: f64,
    /// Value of `r . P r` at which the solve has converged.
    pub target: f64,
    /// Value of `r . P r` that comes from rounding alone.
    pub floor: f64,
}

impl StoppingTest {
    /// The test for a relative tolerance.
    pub(super) fn new(tolerance: f64, scale: f64, floor: f64) -> Self {
        Self { scale, target: (tolerance * tolerance * scale).max(floor), floor }
    }
}

impl SolveReport {
    /// Sets the residual and the outcome from the final `d = r . P r`.
    pub(super) fn close(&mut self, d: f64, test: StoppingTest) {
        let StoppingTest { scale, target, floor } = test;
        self.broken |= !d.is_finite();
        // Nothing can be compared with a scale that is not finite; one below the floor counts as zero.
        self.residual = match scale {
            _ if !scale.is_finite() => f64::NAN,
            _ if d <= floor && scale <= floor => 0.0,
            _ => (d / scale).sqrt(),
        };
        self.converged = d <= target && d >= 0.0 && !self.broken;
    }
}
