//! Contact of bodies with each other, and of a sheet with itself.
//!
//! Bodies are stepped one by one. When all have moved, collisions on their ways from the start to the end of the step are found (continuous collision
//! detection) and taken away by impulses with Coulomb friction. Surfaces keep a gap, the thickness, so that resting contact is found before
//! anything touches. Impulses are those of the implicit step with contact: each body answers them with the matrix of its own step ([`dual`]).
//! Detection and solve alternate, for what is pushed may meet something else ([`resolve`]). Collisions that are left after some rounds are taken away by
//! impulses that know masses alone ([`impulses`]), and where these leave any, nodes move as rigid impact zones ([`zones`]).

mod candidates;
mod contact;
mod crossings;
mod dual;
mod equalities;
mod features;
mod impulses;
mod nodes;
mod resolve;
mod stitch_search;
mod surface;
mod ties;
mod tree;
mod warm_start;
mod zones;

use crate::body::{Body, LatticeError};
use candidates::{Candidate, FirstImpacts};
use contact::ContactSet;
use dual::{DualMember, DualSolver};
use impulses::Impulses;
use nodes::CollisionNodes;
use pliant_solver::{Constraint, Vec3};
pub use stitch_search::{SearchBall, StitchCandidate, StitchSearch};
use surface::CollisionSurface;
pub use ties::{TiePoint, TieRow};
use warm_start::WarmStart;

/// How bodies answer impulses.
pub trait Compliance {
    /// Writes the velocity changes (m/s, n x 3) that `impulses` (N s, n x 3) give body number `body`, whose nodes have these constraints, to `changes`, to a
    /// relative tolerance. Returns the iterations of its solver; `None`, with nothing written, for a body that answers with its masses alone.
    fn respond(
        &mut self,
        body: usize,
        constraints: &[Constraint],
        impulses: &[Vec3],
        tolerance: f64,
        changes: &mut [Vec3],
    ) -> Option<usize>;

    /// Whether the step is cancelled: the solve then ends with what it has, and the step with impulses by masses alone.
    fn is_cancelled(&self) -> bool;
}

/// How a body meets others.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CollisionSettings {
    /// Whether it meets other bodies.
    pub meets: bool,
    /// Whether it meets itself.
    pub meets_itself: bool,
    /// Static and kinetic coefficient of friction; of two bodies the smaller ones count.
    pub friction: [f64; 2],
}

/// Gap that surfaces keep, in edges of the finer of the two.
pub const THICKNESS: f64 = 0.02;
/// Least distance within a step, in gaps.
const LEAST: f64 = 0.1;
/// Distance from which on a contact is looked at, in gaps.
const NEAR: f64 = 2.0;
/// Distance within which features are listed, in gaps; what an impulse moves by the rest is found anew.
const LISTED: f64 = 3.0;
/// Time in which surfaces that are nearer than their gap part, s. It is long beside a step, so that parting does next to no work.
const RECOVERY_TIME: f64 = 0.1;

/// A body in the present step.
#[derive(Clone, Copy, Debug)]
struct Member {
    /// Index of the body.
    body: u32,
    /// Number of its first node and of its first vertex among those of all members.
    node: u32,
    vertex: u32,
    /// Whether nothing moves it.
    stands: bool,
}

/// Two members that may meet, or one twice.
#[derive(Clone, Copy, Debug)]
struct Pair {
    members: [usize; 2],
    /// Gap that they keep, m.
    thickness: f64,
    friction: [f64; 2],
}

/// What contact did to the bodies in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CollisionReport {
    /// Pairs of features whose ways come near each other.
    pub candidates: usize,
    /// Contacts of the last implicit solve.
    pub contacts: usize,
    /// Number of solves of the implicit step with contacts.
    pub solves: usize,
    /// Iterations of all implicit solves.
    pub iterations: usize,
    /// Iterations of the linear solvers of bodies in them.
    pub solver_iterations: usize,
    /// Whether all implicit solves met their tolerances.
    pub has_converged: bool,
    /// Whether an impulse changed a velocity.
    pub has_pushed: bool,
    /// Rounds of impulses by masses alone.
    pub rounds: usize,
    /// Number of impact zones.
    pub zones: usize,
    /// Collisions that are left.
    pub left: usize,
}

impl Default for CollisionReport {
    fn default() -> Self {
        Self {
            candidates: 0,
            contacts: 0,
            solves: 0,
            iterations: 0,
            solver_iterations: 0,
            has_converged: true,
            has_pushed: false,
            rounds: 0,
            zones: 0,
            left: 0,
        }
    }
}

/// Contact of bodies with each other.
#[derive(Default)]
pub struct BodyCollisions {
    surfaces: Vec<CollisionSurface>,
    members: Vec<Member>,
    pairs: Vec<Pair>,
    /// Ties of points of members.
    ties: Vec<TieRow>,
    /// Nodes that carry a tie, with weights (buffer).
    carriers: Vec<(u32, f64)>,
    nodes: CollisionNodes,
    /// Positions of all vertices at the start and at the end of the step, m, and velocities at its end, m/s.
    from: Vec<Vec3>,
    to: Vec<Vec3>,
    speed: Vec<Vec3>,
    /// `to` when candidates were listed, m.
    listed: Vec<Vec3>,
    candidates: Vec<Candidate>,
    /// Sums of impulses on the nodes, N s (n x 3).
    sums: Vec<Vec3>,
    /// Contacts of the implicit solve.
    set: ContactSet,
    dual: DualSolver,
    /// Buffers of the implicit solve: its bodies, and the impacts it begins with.
    dual_members: Vec<DualMember>,
    first_impacts: FirstImpacts,
    warm_start: WarmStart,
    /// Positions of the nodes at the end of the step without contact, m (n x 3).
    free_x: Vec<Vec3>,
    /// Velocities of the nodes at the end of the step without contact, m/s (n x 3).
    free_v: Vec<Vec3>,
    impulses: Impulses,
    stack: Vec<[u32; 2]>,
    /// Impulse on each body in the step, N s.
    totals: Vec<Vec3>,
    /// Positions of the nodes of each body at the start of the step, m; empty for one that is near no other.
    starts: Vec<Vec<Vec3>>,
}

impl BodyCollisions {
    /// Contact of this many bodies.
    pub fn new(bodies: usize) -> Self {
        Self {
            surfaces: (0..bodies).map(|_| CollisionSurface::outdated()).collect(),
            totals: vec![Vec3::zeros(); bodies],
            starts: vec![Vec::new(); bodies],
            ..Self::default()
        }
    }

    /// Number of edges that go through triangles between the surfaces of two bodies, or of one, as they are now.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn crossings(&mut self, [i, j]: [usize; 2], bodies: &mut [Body]) -> Result<usize, LatticeError> {
        let mut positions = [Vec::new(), Vec::new()];
        for (index, x) in [i, j].into_iter().zip(&mut positions) {
            self.prepare(index, &mut bodies[index])?;
            self.surfaces[index].positions(&bodies[index].system.nodes.x, x);
            self.surfaces[index].refit(x, x);
        }
        let [x, y] = &positions;
        let surfaces = [&self.surfaces[i], &self.surfaces[j]];
        Ok(crossings::count_crossings(surfaces, [x, y], i == j, &mut self.stack))
    }

    /// Marks the surface of a body as outdated, after a change of its nodes or triangles.
    pub fn invalidate(&mut self, body: usize) {
        self.surfaces.iter_mut().skip(body).take(1).for_each(|surface| surface.is_outdated = true);
        self.warm_start.clear();
        self.dual.forget();
    }

    /// Impulse of other bodies on a body in the last step, N s.
    pub fn impulse(&self, body: usize) -> Vec3 {
        self.totals.get(body).copied().unwrap_or_default()
    }

    /// Records where a body is before a step.
    pub fn record_start(&mut self, index: usize, body: &Body) {
        self.starts[index].clone_from(&body.system.nodes.x);
    }

    /// Forgets the start of the step and the impulses of the last one.
    pub fn begin(&mut self) {
        self.starts.iter_mut().for_each(Vec::clear);
        self.totals.fill(Vec3::zeros());
        self.members.clear();
        self.pairs.clear();
        self.ties.clear();
        self.nodes.clear();
    }

    /// Makes the surface of a body anew if its nodes or triangles have changed.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn prepare(&mut self, index: usize, body: &mut Body) -> Result<(), LatticeError> {
        if self.surfaces[index].is_outdated {
            self.surfaces[index] = CollisionSurface::new(body)?;
        }
        Ok(())
    }

    /// Adds the body `index` to those that may meet in the step of `dt` (s) that has just been taken. `held` are nodes that tools or obstacles hold; nothing moves a body
    /// that `stands`. Its step had the forces `predicted` (N, n x 3; empty for none) in it, which those of contact replace.
    pub fn add_member(
        &mut self,
        index: usize,
        body: &Body,
        dt: f64,
        stands: bool,
        held: impl Iterator<Item = (u32, Constraint)>,
        predicted: &[Vec3],
    ) {
        let from = &body.system.nodes;
        let vertex =
            self.members.last().map_or(0, |last| last.vertex + self.surfaces[last.body as usize].vertices() as u32);
        let node = self.nodes.len();
        self.members.push(Member { body: index as u32, node: node as u32, vertex, stands });
        let all = &mut self.nodes;
        all.x.extend_from_slice(&from.x);
        all.v.extend_from_slice(&from.v);
        if self.starts[index].len() == from.len() {
            all.start.extend_from_slice(&self.starts[index]);
        } else {
            all.start.extend(from.x.iter().zip(&from.v).map(|(x, v)| x - dt * v));
        }
        let inverse = |i: usize| match from.constraint[i] {
            _ if stands => 0.0,
            Constraint::Fixed => 0.0,
            Constraint::Free | Constraint::Plane(_) | Constraint::Line(_) => 1.0 / from.mass[i],
        };
        all.inverse_mass.extend((0..from.len()).map(inverse));
        let matrix = body.system.matrix.as_ref().filter(|matrix| matrix.rows() == from.len());
        all.scale.extend((0..from.len()).map(|i| match (matrix, inverse(i)) {
            (Some(matrix), inverse) if inverse > 0.0 => {
                let block = matrix.diagonal(i);
                3.0 / (block[0] + block[4] + block[8])
            }
            (_, inverse) => inverse,
        }));
        all.constraint.extend_from_slice(&from.constraint);
        all.predicted.extend(predicted.iter().map(|force| dt * force));
        all.predicted.resize(node + from.len(), Vec3::zeros());
        for (held, constraint) in held {
            let i = node + held as usize;
            if constraint == Constraint::Fixed {
                all.inverse_mass[i] = 0.0;
            } else if all.constraint[i].is_free() {
                all.constraint[i] = constraint;
            }
        }
    }

    /// Lets two members meet, or one itself.
    pub fn add_pair(&mut self, members: [usize; 2], friction: [f64; 2]) {
        let edge = |member: usize| self.surfaces[self.members[member].body as usize].edge;
        let thickness = THICKNESS * edge(members[0]).min(edge(members[1]));
        self.pairs.push(Pair { members, thickness, friction });
    }

    /// Writes the state at the end of the step back to a body, by its place among the members.
    pub fn write_back(&self, member: usize, body: &mut Body) {
        let first = self.members[member].node as usize;
        let nodes = &mut body.system.nodes;
        let count = nodes.len();
        nodes.x.copy_from_slice(&self.nodes.x[first..first + count]);
        nodes.v.copy_from_slice(&self.nodes.v[first..first + count]);
    }

    /// Forces of the contacts of the step of `dt` (s) on the nodes of a body, by its place among the members, to `forces` (N, n x 3).
    pub fn forces(&mut self, member: usize, dt: f64, forces: &mut Vec<Vec3>) {
        if member == 0 {
            self.sums.clear();
            self.sums.resize(self.nodes.len(), Vec3::zeros());
            self.set.add_impulses(&mut self.sums);
        }
        let first = self.members[member].node as usize;
        let end = self.members.get(member + 1).map_or(self.nodes.len(), |next| next.node as usize);
        forces.clear();
        forces.extend(self.sums[first..end].iter().map(|impulse| impulse / dt));
    }

    /// Memory of the collision surfaces, nodes and contacts, bytes.
    pub fn bytes(&self) -> usize {
        let surfaces = self.surfaces.iter().map(CollisionSurface::bytes).sum::<usize>();
        let contacts = self.set.bytes() + self.impulses.set.bytes() + self.dual.bytes();
        surfaces
            + contacts
            + self.nodes.len() * 256
            + self.from.len() * 96
            + self.candidates.len() * size_of::<Candidate>()
    }
}
