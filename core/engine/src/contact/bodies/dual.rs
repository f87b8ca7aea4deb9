//! Contact impulses that know how each body yields: the dual problem of the constrained implicit step.
//!
//! Impulses p = J^T l on the nodes change the velocities at the end of the step by A^-1 p, A being the matrix of each body's own step ([`Compliance`]).
//! Sought are normal impulses l_n >= 0 for which contacts part at least as fast as their bound, u_n >= b, with l_n (u_n - b) = 0, and tangential ones
//! that oppose sliding within Coulomb's cone. That is the step of backward Euler with these contact forces, so linear elastic bodies gain no energy:
//! the work of contact is l . u <= 0 (Duriez et al. 2006; Otaduy, Tamstorf, Steinemann and Gross 2009).
//!
//! The iteration is the accelerated projected gradient method with restarts and a step length by backtracking (Nesterov 1983;
//! O'Donoghue and Candes 2015; Mazhar, Heyn, Negrut and Tasora 2015), in variables scaled by the diagonal of J A^-1 J^T. The radius of the friction disc is that of
//! the newest normal impulse, so sliding contacts do not part as those of the associated cone do.
//!
//! Ties of two points are rows of the same problem, with u = b for all three components and impulses of any sign; where there is nothing else it is a linear
//! system ([`super::equalities`]).

use super::contact::{Contact, ContactSet, ImpulseLaw};
use super::equalities::TieVectors;
use super::nodes::CollisionNodes;
use super::{Compliance, RECOVERY_TIME};
use pliant_solver::Vec3;
use std::ops::Range;

/// Most iterations of a solve.
const MAX_ITERATIONS: usize = 300;
/// Approach that is left at the end, as a fraction of the fastest one without contact.
const TOLERANCE: f64 = 0.01;
/// Displacement in a step by an approach that is left, as a fraction of the gap that surfaces keep: detection stops features at a tenth of the gap.
const TOLERANCE_OF_GAP: f64 = 0.25;
/// Separating velocity of unilateral contacts that is left at the end, averaged by their impulses, as a fraction of the fastest approach without contact.
const TOLERANCE_OF_WORK: f64 = 1e-3;
/// Difference of tied points from their target velocity that is left at the end, as a fraction of the largest one at the beginning.
const TOLERANCE_OF_TIES: f64 = 1e-3;
/// Depth by which surfaces at rest are nearer than their gap, as a fraction of it.
const TOLERANCE_AT_REST: f64 = 0.1;
/// Relative tolerance of the solve for each body.
const RESPONSE_TOLERANCE: f64 = 1e-5;
/// Growth of the step length from one iteration to the next.
const GROWTH: f64 = 1.05;
/// Margin of a step length below the largest that the last step allows.
const MARGIN: f64 = 0.9;

/// Largest number of times that backtracking shortens the step of an iteration.
const MAX_SHRINKS: usize = 30;
/// Part of the static friction from which on it is fully used.
const FULL: f64 = 0.999;

/// A body in the solve: its number, its nodes among those of all, and whether impulses move it.
pub(super) struct DualMember {
    pub body: usize,
    pub nodes: Range<usize>,
    pub is_moved: bool,
}

/// The bodies of a solve, with what answers impulses on them.
pub(super) struct DualBodies<'a> {
    /// Nodes of all members.
    pub nodes: &'a CollisionNodes,
    /// The bodies, each with its nodes.
    pub members: &'a [DualMember],
    /// Computes their velocity changes by impulses.
    pub compliance: &'a mut dyn Compliance,
}

/// What a solve took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DualReport {
    /// Iterations of the gradient method.
    pub iterations: usize,
    /// Iterations of the linear solvers of bodies.
    pub solver_iterations: usize,
    /// Whether the tolerances were met.
    pub converged: bool,
}

/// The solver of the dual problem with its buffers.
#[derive(Default)]
pub(super) struct DualSolver {
    /// Impulses on the nodes, N s (n x 3).
    pub(super) impulses: Vec<Vec3>,
    /// Velocity changes of the nodes by `impulses`, m/s (n x 3).
    pub changes: Vec<Vec3>,
    /// Velocities of the contacts without impulses, m/s (c x 3). The next three fields are changes of these by the impulses of the last, the present and the
    /// extrapolated iterate.
    free: Vec<[f64; 3]>,
    last: Vec<[f64; 3]>,
    pub(super) now: Vec<[f64; 3]>,
    ahead: Vec<[f64; 3]>,
    /// Impulses of the last and of the extrapolated iterate, N s (c x 3); the present ones are in the contacts.
    last_impulse: Vec<[f64; 3]>,
    ahead_impulse: Vec<[f64; 3]>,
    /// Step length of the last iteration; 0 before the first.
    length: f64,
    /// Buffers of the solve of ties alone.
    pub(super) ties: TieVectors,
}

/// Tolerances of a solve, m/s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tolerances {
    /// Largest approaching velocity that counts as none.
    approach: f64,
    /// Largest separating velocity of unilateral contacts, averaged by their impulses.
    parting: f64,
    /// Largest difference of a tie's velocity from its target.
    pub tie: f64,
}

impl DualSolver {
    /// Solves for the impulses of the contacts, starting from those that they have; `free` are velocities of the nodes without contact, m/s (n x 3). Leaves
    /// the velocity changes in `changes`.
    pub fn solve(&mut self, set: &mut ContactSet, free: &[Vec3], bodies: &mut DualBodies<'_>, dt: f64) -> DualReport {
        let mut report = DualReport::default();
        self.free.clear();
        self.free.extend(set.contacts.iter().map(|contact| set.velocities(contact, free)));
        let tolerances = self.tolerances(set, dt);
        for contact in &mut set.contacts {
            contact.slides = false;
        }
        self.respond(set, bodies, &mut report);
        let is_firm_tie = |contact: &Contact| contact.law == ImpulseLaw::Tie { max_impulse: f64::INFINITY };
        if !set.is_empty() && set.contacts.iter().all(is_firm_tie) {
            self.solve_ties(set, bodies, tolerances.tie, &mut report);
            return report;
        }
        self.ahead.clone_from(&self.now);
        self.ahead_impulse.clear();
        self.ahead_impulse.extend(set.contacts.iter().map(|contact| contact.impulse));
        if self.length == 0.0 {
            self.length = 1.0;
        }
        let mut theta = 1.0_f64;
        while report.iterations < MAX_ITERATIONS && !bodies.compliance.is_cancelled() {
            report.iterations += 1;
            self.last_impulse.clear();
            self.last_impulse.extend(set.contacts.iter().map(|contact| contact.impulse));
            std::mem::swap(&mut self.last, &mut self.now);
            self.descend(set, bodies, &mut report);
            if self.has_converged(set, tolerances) {
                if !self.let_slide(set, tolerances.approach) {
                    report.converged = true;
                    break;
                }
                theta = 1.0;
            }
            let rises = set.contacts.iter().enumerate().map(|(c, contact)| {
                let gradient = self.gradient(contact.bounds, c);
                (0..3).map(|k| gradient[k] * (contact.impulse[k] - self.last_impulse[c][k])).sum::<f64>()
            });
            let beta = if rises.sum::<f64>() > 0.0 {
                theta = 1.0;
                0.0
            } else {
                let squared = theta * theta;
                let next = 0.5 * ((squared * squared + 4.0 * squared).sqrt() - squared);
                let beta = theta * (1.0 - theta) / (squared + next);
                theta = next;
                beta
            };
            for (c, contact) in set.contacts.iter().enumerate() {
                for k in 0..3 {
                    self.ahead_impulse[c][k] =
                        contact.impulse[k] + beta * (contact.impulse[k] - self.last_impulse[c][k]);
                    self.ahead[c][k] = self.now[c][k] + beta * (self.now[c][k] - self.last[c][k]);
                }
            }
            self.length *= GROWTH;
        }
        report
    }

    /// Tolerances relative to the velocities without impulses.
    fn tolerances(&self, set: &ContactSet, dt: f64) -> Tolerances {
        let (mut fastest, mut widest) = (0.0_f64, 0.0_f64);
        for (contact, u) in set.contacts.iter().zip(&self.free) {
            match contact.law {
                ImpulseLaw::Unilateral => fastest = fastest.max(contact.bounds[0] - u[0]),
                ImpulseLaw::Tie { .. } => widest = widest.max(missing(contact, *u).norm()),
            }
        }
        let thinnest = set.contacts.iter().map(|contact| contact.data.thickness).fold(f64::INFINITY, f64::min);
        let rest = self.rest_tolerance(set);
        let most = TOLERANCE_OF_GAP * thinnest / dt;
        Tolerances {
            approach: (TOLERANCE * fastest).max(rest).min(most),
            parting: (TOLERANCE_OF_WORK * fastest).max(rest),
            tie: (TOLERANCE_OF_TIES * widest).max(TOLERANCE_OF_TIES * rest).min(most),
        }
    }

    /// Approaching velocity below which a contact counts as resting, m/s: that at which surfaces separate when their distance is less than their gap by
    /// [`TOLERANCE_AT_REST`]. It does not depend on the speed of contacts; 0 without a finite gap.
    fn rest_tolerance(&self, set: &ContactSet) -> f64 {
        let thinnest = set.contacts.iter().map(|contact| contact.data.thickness).fold(f64::INFINITY, f64::min);
        if thinnest.is_finite() { TOLERANCE_AT_REST * thinnest / RECOVERY_TIME } else { 0.0 }
    }

    /// Gradient of the dual energy at the extrapolated iterate, m/s.
    fn gradient(&self, bounds: [f64; 3], c: usize) -> [f64; 3] {
        let (free, by) = (self.free[c], self.ahead[c]);
        [0, 1, 2].map(|k: usize| free[k] + by[k] - bounds[k])
    }

    /// A projected step from the extrapolated iterate, shortened until the quadratic bound of its length holds.
    fn descend(&mut self, set: &mut ContactSet, bodies: &mut DualBodies<'_>, report: &mut DualReport) {
        for _ in 0..MAX_SHRINKS {
            for (c, contact) in set.contacts.iter_mut().enumerate() {
                let (gradient, ahead) = (self.gradient(contact.bounds, c), self.ahead_impulse[c]);
                let wanted = [0, 1, 2].map(|k: usize| ahead[k] - self.length / contact.scale * gradient[k]);
                contact.impulse = contact.project(wanted);
            }
            self.respond(set, bodies, report);
            let (mut curvature, mut squared) = (0.0, 0.0);
            for (c, contact) in set.contacts.iter().enumerate() {
                for k in 0..3 {
                    let by = contact.impulse[k] - self.ahead_impulse[c][k];
                    curvature += by * (self.now[c][k] - self.ahead[c][k]);
                    squared += contact.scale * by * by;
                }
            }
            let is_short = curvature * self.length <= squared * (1.0 + 1e-6);
            if is_short || !curvature.is_finite() {
                return;
            }
            self.length = MARGIN * squared / curvature;
        }
    }

    /// Computes the velocity changes of nodes and of contacts by the present impulses, less those that the nodes have had in the steps of their bodies.
    pub(super) fn respond(&mut self, set: &ContactSet, bodies: &mut DualBodies<'_>, report: &mut DualReport) {
        for field in [&mut self.impulses, &mut self.changes] {
            field.clear();
            field.resize(bodies.nodes.len(), Vec3::zeros());
        }
        set.add_impulses(&mut self.impulses);
        self.impulses.iter_mut().zip(&bodies.nodes.predicted).for_each(|(p, predicted)| *p -= predicted);
        self.respond_to_impulses(set, bodies, report);
    }

    /// Computes the velocity changes of nodes and of contacts by the impulses in `self.impulses`; `changes` must be zero.
    pub(super) fn respond_to_impulses(
        &mut self,
        set: &ContactSet,
        bodies: &mut DualBodies<'_>,
        report: &mut DualReport,
    ) {
        let nodes = bodies.nodes;
        for DualMember { body, nodes: range, is_moved } in bodies.members {
            let impulses = &self.impulses[range.clone()];
            if !is_moved || impulses.iter().all(|p| *p == Vec3::zeros()) {
                continue;
            }
            let constraints = &nodes.constraint[range.clone()];
            let changes = &mut self.changes[range.clone()];
            match bodies.compliance.respond(*body, constraints, impulses, RESPONSE_TOLERANCE, changes) {
                Some(iterations) => report.solver_iterations += iterations,
                None => {
                    for ((change, impulse), i) in changes.iter_mut().zip(impulses).zip(range.clone()) {
                        *change = nodes.response(i, *impulse);
                    }
                }
            }
        }
        self.now.clear();
        self.now.extend(set.contacts.iter().map(|contact| set.velocities(contact, &self.changes)));
    }

    /// Whether all tolerances are met: no contact approaches faster, unilateral contacts separate no faster on average, and each tie has its target velocity
    /// or its largest impulse towards it.
    fn has_converged(&self, set: &ContactSet, tolerances: Tolerances) -> bool {
        let (mut approach, mut work, mut allowed, mut untied) = (0.0_f64, 0.0, 0.0, 0.0_f64);
        for (c, contact) in set.contacts.iter().enumerate() {
            let u = self.velocity(c);
            if let ImpulseLaw::Tie { max_impulse } = contact.law {
                let (missing, impulse) = (missing(contact, u), Vec3::from(contact.impulse));
                let is_full = impulse.norm() >= FULL * max_impulse && impulse != Vec3::zeros();
                let pull = if is_full { missing.dot(&impulse).max(0.0) / impulse.norm_squared() } else { 0.0 };
                untied = untied.max((missing - pull * impulse).norm());
                continue;
            }
            let parts = u[0] - contact.bounds[0];
            approach = approach.max(-parts);
            work += contact.impulse[0] * parts.max(0.0);
            allowed += contact.impulse[0] * tolerances.parting;
            // Friction that has not come to rest, or does not oppose the sliding.
            let along = contact.impulse[1] * u[1] + contact.impulse[2] * u[2];
            let radius = contact.data.friction[usize::from(contact.slides)] * contact.impulse[0];
            work += radius * length([u[1], u[2]]) + along;
        }
        approach <= tolerances.approach && work <= allowed && untied <= tolerances.tie
    }

    /// Velocities of a contact with the present impulses, m/s.
    pub(super) fn velocity(&self, c: usize) -> [f64; 3] {
        [0, 1, 2].map(|k: usize| self.free[c][k] + self.now[c][k])
    }

    /// Marks contacts as sliding that use their whole static friction and still move. Returns whether there are any new ones.
    fn let_slide(&self, set: &mut ContactSet, tolerance: f64) -> bool {
        let mut any = false;
        for (c, contact) in set
            .contacts
            .iter_mut()
            .enumerate()
            .filter(|(_, contact)| !contact.slides && contact.law == ImpulseLaw::Unilateral)
        {
            let [kept, sliding] = contact.data.friction.map(|f| f * contact.impulse[0]);
            let [_, s, t] = self.velocity(c);
            let slide = length([s, t]);
            let is_full = length([contact.impulse[1], contact.impulse[2]]) >= FULL * kept;
            contact.slides = sliding < kept && is_full && slide > tolerance;
            any |= contact.slides;
        }
        any
    }

    /// Resets the step length, so that a restored session takes the same steps as the saved one.
    pub fn forget(&mut self) {
        self.length = 0.0;
    }

    /// Memory of the buffers of the solver, bytes.
    pub fn bytes(&self) -> usize {
        self.impulses.capacity() * 48 + self.free.capacity() * 6 * 24 + self.ties.bytes()
    }
}

/// Target velocity of a tie minus its velocities `u`, m/s.
pub(super) fn missing(contact: &Contact, u: [f64; 3]) -> Vec3 {
    Vec3::from(contact.bounds) - Vec3::from(u)
}

/// Length of a vector along the surface.
fn length([a, b]: [f64; 2]) -> f64 {
    (a * a + b * b).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::contact::{ContactData, FeatureKey};
    use super::super::features::{Kind, gap};
    use super::*;
    use pliant_solver::Constraint;

    /// Bodies that answer with their masses, until the step is cancelled.
    struct Masses {
        is_cancelled: bool,
    }

    impl Compliance for Masses {
        fn respond(&mut self, _: usize, _: &[Constraint], _: &[Vec3], _: f64, _: &mut [Vec3]) -> Option<usize> {
            None
        }

        fn is_cancelled(&self) -> bool {
            self.is_cancelled
        }
    }

    /// A node of 1 kg that falls at 1 m/s onto a triangle of three nodes of 1 kg each: together they go on at a quarter of that where it meets the middle.
    #[test]
    fn a_node_that_falls_on_a_triangle_goes_on_with_it_and_a_cancelled_solve_ends() {
        let x = [
            Vec3::new(0.0, 0.0, 1e-3),
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(-0.5, 0.75, 0.0),
            Vec3::new(-0.5, -0.75, 0.0),
        ];
        let nodes = CollisionNodes {
            start: x.to_vec(),
            x: x.to_vec(),
            v: vec![Vec3::new(0.0, 0.0, -1.0), Vec3::zeros(), Vec3::zeros(), Vec3::zeros()],
            inverse_mass: vec![1.0; 4],
            scale: vec![1.0; 4],
            predicted: vec![Vec3::zeros(); 4],
            constraint: vec![Constraint::Free; 4],
        };
        let carriers: [[(u32, f64); 1]; 4] = std::array::from_fn(|i| [(i as u32, 1.0)]);
        let data = ContactData {
            bound: 0.0,
            friction: [0.0; 2],
            thickness: 1e-3,
            bodies: [0, 1],
            key: FeatureKey::VertexTriangle([(0, 0); 4]),
        };
        let members =
            [DualMember { body: 0, nodes: 0..1, is_moved: true }, DualMember { body: 1, nodes: 1..4, is_moved: true }];
        for is_cancelled in [false, true] {
            let mut set = ContactSet::default();
            set.add(&gap(Kind::VertexTriangle, &x), |i| (0, &carriers[i][..]), &nodes, data);
            let mut dual = DualSolver::default();
            let mut bodies = DualBodies { nodes: &nodes, members: &members, compliance: &mut Masses { is_cancelled } };
            let report = dual.solve(&mut set, &nodes.v, &mut bodies, 1e-3);
            assert_eq!(report.converged, !is_cancelled);
            if is_cancelled {
                assert_eq!(report.iterations, 0);
                continue;
            }
            let ends: Vec<f64> = nodes.v.iter().zip(&dual.changes).map(|(v, by)| v[2] + by[2]).collect();
            // Impulse p on the node and p/3 on each corner: -1 + p = -p/3.
            assert!((ends[0] + 0.25).abs() < 0.02, "{ends:?}");
            assert!((ends.iter().sum::<f64>() + 1.0).abs() < 1e-12, "momentum: {ends:?}");
        }
    }
}
