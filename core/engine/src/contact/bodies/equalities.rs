//! Ties of points alone: without contacts the dual problem is the linear system J A^-1 J^T l = b - J v, which the conjugate gradient method solves, with the
//! diagonal of J A^-1 J^T as preconditioner. Rows that say the same twice, as where two ties hold one node to another, leave it singular and consistent.

use super::contact::ContactSet;
use super::dual::{DualBodies, DualReport, DualSolver, missing};
use pliant_solver::Vec3;

/// Most iterations of a solve.
const MAX_ITERATIONS: usize = 300;
/// Times that the residual is computed anew, as the bodies answer only to a tolerance.
const MAX_RESTARTS: usize = 3;

/// Vectors of the conjugate gradient method: one entry for each tie.
#[derive(Default)]
pub(super) struct TieVectors {
    /// Velocity that each tie is short of, m/s.
    residual: Vec<Vec3>,
    /// The search direction, N s.
    direction: Vec<Vec3>,
    /// The solution, N s.
    impulse: Vec<Vec3>,
    /// Reciprocals of the diagonal, kg.
    inverse_scale: Vec<f64>,
}

impl TieVectors {
    /// Sum of the squares of the residuals, each over its scale: the norm that belongs to the preconditioner.
    fn energy(&self) -> f64 {
        self.residual.iter().zip(&self.inverse_scale).map(|(r, s)| s * r.norm_squared()).sum()
    }

    /// The largest residual, m/s.
    fn largest(&self) -> f64 {
        self.residual.iter().fold(0.0, |most, r| most.max(r.norm()))
    }

    /// Memory of the buffers of the solver, bytes.
    pub fn bytes(&self) -> usize {
        self.residual.capacity() * 80
    }
}

impl DualSolver {
    /// Solves for the impulses of ties, starting from those that they have, to a difference of velocities of `tolerance` (m/s). The answer to those has been computed.
    pub(super) fn solve_ties(
        &mut self,
        set: &mut ContactSet,
        bodies: &mut DualBodies<'_>,
        tolerance: f64,
        report: &mut DualReport,
    ) {
        let mut cg = std::mem::take(&mut self.ties);
        cg.impulse.clear();
        cg.impulse.extend(set.contacts.iter().map(|tie| Vec3::from(tie.impulse)));
        cg.inverse_scale.clear();
        cg.inverse_scale.extend(set.contacts.iter().map(|tie| 1.0 / tie.scale));
        for _ in 0..MAX_RESTARTS {
            cg.residual.clear();
            cg.residual.extend(set.contacts.iter().enumerate().map(|(c, tie)| missing(tie, self.velocity(c))));
            report.converged = cg.largest() <= tolerance;
            if report.converged || bodies.compliance.is_cancelled() || report.iterations >= MAX_ITERATIONS {
                break;
            }
            self.iterate(set, &mut cg, bodies, tolerance, report);
            for (tie, impulse) in set.contacts.iter_mut().zip(&cg.impulse) {
                tie.impulse = (*impulse).into();
            }
            self.respond(set, bodies, report);
            let left = set.contacts.iter().enumerate().map(|(c, tie)| missing(tie, self.velocity(c)).norm());
            report.converged = left.fold(0.0, f64::max) <= tolerance;
        }
        self.ties = cg;
    }

    /// Iterations from the residual in `cg`, which they reduce.
    fn iterate(
        &mut self,
        set: &mut ContactSet,
        cg: &mut TieVectors,
        bodies: &mut DualBodies<'_>,
        tolerance: f64,
        report: &mut DualReport,
    ) {
        cg.direction.clear();
        cg.direction.extend(cg.residual.iter().zip(&cg.inverse_scale).map(|(r, s)| *s * r));
        let mut energy = cg.energy();
        while report.iterations < MAX_ITERATIONS && !bodies.compliance.is_cancelled() {
            report.iterations += 1;
            for (tie, direction) in set.contacts.iter_mut().zip(&cg.direction) {
                tie.impulse = (*direction).into();
            }
            for field in [&mut self.impulses, &mut self.changes] {
                field.clear();
                field.resize(bodies.nodes.len(), Vec3::zeros());
            }
            set.add_impulses(&mut self.impulses);
            self.respond_to_impulses(set, bodies, report);
            let answer = |c: usize| Vec3::from(self.now[c]);
            let curvature: f64 = cg.direction.iter().enumerate().map(|(c, d)| d.dot(&answer(c))).sum();
            if !(curvature > 0.0 && curvature.is_finite()) {
                return;
            }
            let step = energy / curvature;
            for c in 0..cg.direction.len() {
                cg.impulse[c] += step * cg.direction[c];
                cg.residual[c] -= step * answer(c);
            }
            // Half of the tolerance, as the residual that is computed anew differs.
            if cg.largest() <= 0.5 * tolerance {
                return;
            }
            let next = cg.energy();
            let ratio = next / energy;
            energy = next;
            for ((direction, residual), scale) in cg.direction.iter_mut().zip(&cg.residual).zip(&cg.inverse_scale) {
                *direction = *scale * residual + ratio * *direction;
            }
        }
    }
}
