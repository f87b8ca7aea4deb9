//! Time integration: one step of one body.
//!
//! Implicit schemes share one form. The unknown is a velocity v; the position it leads to is `X + g v`, and Newton's method on
//! `M (v - V) = g f(X + g v, v)` takes a step `A dv = M (V - v) + g f` with `A = M + g C + g^2 K`. Backward Euler has
//! X = x, V = v, g = dt; BDF2 (Gear 1971) the same with two states behind it; implicit midpoint solves for the velocity
//! halfway. One Newton step, linearised where the body is, is what a hand can wait for (Baraff and Witkin 1998).

use super::pcg::{Pcg, Preconditioner, Solve};
use super::peek::doubt;
use super::pool::{NODES, Pool};
use super::right_side::{RightSide, Start};
use super::settle::HoldsNothing;
use super::springs::NodeSprings;
use super::system::{Nodes, System};
use super::{Constraint, Factors, Matrix, StandIn, V3, axpy, dot, without_dust};
use crate::host::HostError;
use std::time::Instant;
use thiserror::Error;

/// How positions and velocities are advanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scheme {
    /// Positions with the old velocities, as Qi, Zhu and Fan (2019) print it: gains energy in every undamped mode.
    ExplicitEuler,
    /// Velocities first.
    SymplecticEuler,
    /// First order, damps what is fast.
    BackwardEuler,
    /// Second order, damps less; a step of backward Euler after whatever breaks the past: contact, a cut, a new region.
    Bdf2,
    /// Second order, damps nothing.
    ImplicitMidpoint,
    /// No inertia: equilibrium at every step.
    QuasiStatic,
}

impl Scheme {
    /// As scenes write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::ExplicitEuler => "explicit-euler",
            Self::SymplecticEuler => "symplectic-euler",
            Self::BackwardEuler => "backward-euler",
            Self::Bdf2 => "bdf2",
            Self::ImplicitMidpoint => "implicit-midpoint",
            Self::QuasiStatic => "quasi-static",
        }
    }

    /// Whether a step solves a system of equations.
    pub fn is_implicit(self) -> bool {
        !matches!(self, Self::ExplicitEuler | Self::SymplecticEuler)
    }
}

/// What holds nodes during a step and lets them go again, such as a sphere in contact.
pub trait Holds {
    /// Constrains nodes, from the positions they have. `dt` (s) is how long the velocities of the step last.
    fn begin(&mut self, system: &mut System, dt: f64);
    /// Adds what it does besides, N.
    fn add_forces(&self, force: &mut [V3]);
    /// Looks at what a step does. Gives whether other nodes are held now, or other forces act. Where the step is not solved to the end,
    /// only what is certain changes.
    fn revise(&mut self, system: &mut System, outcome: &Outcome<'_>) -> bool;
    /// Whether it is certain, from a step that is being solved, what [`Holds::revise`] is going to change, and that it is something.
    fn foresees(&self, _: &System, _: &Outcome<'_>) -> bool {
        false
    }
    /// Whether it may come to hold a node in this step.
    fn is_near(&self) -> bool;
    /// Whether it holds any node.
    fn is_holding(&self) -> bool;
    /// Lets go of all nodes. To what it took to hold each, N (n x 3), it adds what it did to them besides.
    fn end(&mut self, system: &mut System, reaction: &mut [V3]);
}

/// What a step does to nodes.
pub struct Outcome<'a> {
    /// m/s, the velocity it gives a node
    pub after: &'a dyn Fn(&System, usize) -> V3,
    /// N, what it takes to hold a node
    pub reaction: &'a dyn Fn(usize) -> V3,
    /// How far they may be off, where the step is not solved to the end.
    pub doubt: Option<&'a Doubt<'a>>,
}

/// N, how far what it takes to hold a node may be off along a unit vector, and m/s, its velocity.
pub type Doubt<'a> = dyn Fn(&System, usize, V3) -> [f64; 2] + 'a;

/// What acts on a body during a step, besides itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Loads<'a> {
    /// m/s^2
    pub gravity: V3,
    /// N (n x 3), or empty
    pub forces: &'a [V3],
    /// What the tools do.
    pub tools: &'a [NodeSprings],
}

/// How a step went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport {
    /// Iterations of all solves.
    pub iterations: usize,
    /// The largest final relative residual.
    pub residual: f64,
    /// Whether every solve met its tolerance.
    pub converged: bool,
    /// m/s, the fastest node at the end
    pub fastest: f64,
    /// Newton iterations.
    pub newton: usize,
    /// s, wall clock: forces and matrix of the elements, and the solves
    pub seconds: [f64; 2],
}

impl Default for StepReport {
    fn default() -> Self {
        Self { iterations: 0, residual: 0.0, converged: true, fastest: 0.0, newton: 0, seconds: [0.0; 2] }
    }
}

/// Why a step was not taken.
#[derive(Debug, Error)]
pub enum StepError {
    /// The material failed.
    #[error(transparent)]
    Host(#[from] HostError),
    /// A node's velocity is not finite. Positions are those before the step, and the body stands still.
    #[error("the velocity of node {node} is not finite")]
    Diverged {
        /// Which.
        node: usize,
    },
}

/// A scheme with its settings and the vectors it works in.
pub struct Integrator {
    /// How.
    pub scheme: Scheme,
    /// Relative, of each solve.
    pub tolerance: f64,
    /// Iterations of each solve, at most.
    pub most_iterations: usize,
    /// Newton iterations of each step, at most.
    pub newton: usize,
    /// Of the first residual, where Newton's method stops.
    pub newton_tolerance: f64,
    /// m, how far a node goes in one iteration of a quasi-static step, at most
    pub longest_move: f64,
    /// N, what it took to hold each node in the last step (n x 3)
    pub reaction: Vec<V3>,
    pub(super) force: Vec<V3>,
    pub(super) still: Vec<V3>,
    /// Matrix times velocity, N s.
    moving: Vec<V3>,
    pub(super) b: Vec<V3>,
    pub(super) z: Vec<V3>,
    /// Where the step began, and the step before it.
    from: [Vec<V3>; 2],
    before: [Vec<V3>; 2],
    has_past: bool,
    pub(super) pcg: Pcg,
}

/// Times contacts are looked at anew in a step, at most.
pub(super) const PASSES: usize = 4;
/// Tolerance of a solve from which on moments of hinges are found to six digits.
const SIX_DIGITS: f64 = 1e-5;
/// Times a solve of a step is stopped, at most, for it will not be the last.
const STOPS: usize = 8;

/// `M (v - V) = g f(X + g v)`, where `X = x + carry (x - x_before)` and V likewise.
struct Form {
    g: f64,
    carry: f64,
}

impl Integrator {
    /// With room for nothing yet.
    pub fn new(scheme: Scheme, tolerance: f64, most_iterations: usize) -> Self {
        Self {
            scheme,
            tolerance,
            most_iterations,
            newton: if scheme == Scheme::QuasiStatic { 200 } else { 1 },
            newton_tolerance: 1e-6,
            longest_move: f64::INFINITY,
            reaction: Vec::new(),
            force: Vec::new(),
            still: Vec::new(),
            moving: Vec::new(),
            b: Vec::new(),
            z: Vec::new(),
            from: Default::default(),
            before: Default::default(),
            has_past: false,
            pcg: Pcg::default(),
        }
    }

    /// Which preconditioner solves take.
    pub fn set_preconditioner(&mut self, preconditioner: Preconditioner) {
        self.pcg.preconditioner = preconditioner;
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.force.len() * 9 * size_of::<V3>() + self.pcg.bytes()
    }

    /// Room for `n` nodes. After a change of nodes or elements, also forgets the last solution.
    pub fn resize(&mut self, n: usize) {
        self.force.resize(n, [0.0; 3]);
        self.reaction.clear();
        self.reaction.resize(n, [0.0; 3]);
        self.has_past = false;
        if self.scheme.is_implicit() {
            let [x, v] = &mut self.from;
            let [x_before, v_before] = &mut self.before;
            for field in [&mut self.still, &mut self.moving, &mut self.b, &mut self.z, x, v, x_before, v_before] {
                field.clear();
                field.resize(n, [0.0; 3]);
            }
            self.pcg.resize(n);
        }
    }

    /// The past does not lead to here: positions or velocities were set from outside.
    pub fn forget_past(&mut self) {
        self.has_past = false;
    }

    /// Moves `system` from `time` by `substeps` steps that come to `dt` (s) together.
    ///
    /// # Errors
    /// A material that fails, or a state that is no longer finite.
    pub fn step(
        &mut self,
        pool: &Pool,
        system: &mut System,
        loads: &Loads<'_>,
        time: (f64, f64),
        substeps: usize,
    ) -> Result<StepReport, StepError> {
        self.step_held(pool, system, (loads, &mut HoldsNothing), time, substeps)
    }

    /// The same while `holds` holds nodes.
    ///
    /// # Errors
    /// As [`Integrator::step`].
    pub fn step_held(
        &mut self,
        pool: &Pool,
        system: &mut System,
        (loads, holds): (&Loads<'_>, &mut dyn Holds),
        (time, dt): (f64, f64),
        substeps: usize,
    ) -> Result<StepReport, StepError> {
        let h = dt / substeps as f64;
        let mut report = StepReport::default();
        for sub in 0..substeps {
            let now = (time + sub as f64 * h, h);
            let stepped = match self.scheme {
                Scheme::QuasiStatic => self.settle(pool, system, (loads, holds), now, &mut report),
                scheme if scheme.is_implicit() => self.implicit(pool, system, (loads, holds), now, &mut report),
                _ => self.explicit(pool, system, (loads, holds), now, &mut report),
            };
            stepped.map_err(|error| self.blame(error, system))?;
            system.advance((now.0 + h, h))?;
        }
        Ok(report)
    }

    fn implicit(
        &mut self,
        pool: &Pool,
        system: &mut System,
        (loads, holds): (&Loads<'_>, &mut dyn Holds),
        now: (f64, f64),
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let dt = now.1;
        let (nodes, [x, v]) = (&system.nodes, &mut self.from);
        pool.pieces((&mut x[..], &mut v[..]), NODES, &|first, (x, v)| {
            x.copy_from_slice(&nodes.x[first..first + x.len()]);
            v.copy_from_slice(&nodes.v[first..first + v.len()]);
        });
        holds.begin(system, dt);
        let two = self.scheme == Scheme::Bdf2 && self.has_past && !holds.is_holding();
        let form = match self.scheme {
            Scheme::Bdf2 if two => Form { g: 2.0 / 3.0 * dt, carry: 1.0 / 3.0 },
            Scheme::ImplicitMidpoint => Form { g: 0.5 * dt, carry: 0.0 },
            _ => Form { g: dt, carry: 0.0 },
        };
        let mut first = 0.0;
        for iteration in 0..self.newton.max(1) {
            let size = self.newton_step(pool, system, (loads, holds), (now, &form), iteration, report)?;
            if iteration == 0 {
                first = size;
            }
            report.newton += 1;
            if size <= self.newton_tolerance * first {
                break;
            }
        }
        std::mem::swap(&mut self.from, &mut self.before);
        self.has_past = true;
        let (Nodes { x: to, v: speed, constraint, prescribed, .. }, [x, v], past) =
            (&mut system.nodes, &self.before, &self.from[0]);
        pool.pieces((&mut to[..], &mut speed[..]), NODES, &|first, (to, speed)| {
            for (i, (to, speed)) in (first..).zip(to.iter_mut().zip(speed)) {
                let x_before = if form.carry > 0.0 { axpy(x[i], form.carry, axpy(x[i], -1.0, past[i])) } else { x[i] };
                if self.scheme == Scheme::ImplicitMidpoint {
                    *to = axpy(x[i], dt, *speed);
                    let after = axpy(speed.map(|c| 2.0 * c), -1.0, v[i]);
                    *speed = constraint[i].merge(after, prescribed[i]);
                } else {
                    *to = axpy(x_before, form.g, *speed);
                }
            }
        });
        report.fastest = check(system).inspect_err(|_| system.nodes.x.copy_from_slice(&self.before[0]))?;
        holds.end(system, &mut self.reaction);
        Ok(())
    }

    /// One Newton step, contacts included. Gives the size of what it set out to remove.
    fn newton_step(
        &mut self,
        pool: &Pool,
        system: &mut System,
        (loads, holds): (&Loads<'_>, &mut dyn Holds),
        (now, form): ((f64, f64), &Form),
        iteration: usize,
        report: &mut StepReport,
    ) -> Result<f64, StepError> {
        let (g, dt) = (form.g, now.1);
        // The first step of backward Euler is linearised where the body is, all others where it is expected to be.
        let here = iteration == 0 && form.carry == 0.0 && g == dt;
        if !here {
            for i in 0..system.nodes.len() {
                let x = self.from[0][i];
                let carried = axpy(x, form.carry, axpy(x, -1.0, self.before[0][i]));
                system.nodes.x[i] = axpy(if form.carry > 0.0 { carried } else { x }, g, system.nodes.v[i]);
            }
        }
        // Backward Euler bears a matrix of half the stiffness; one step of the others would grow with a softer one than exact.
        let stand_in = if form.carry > 0.0 || g < dt { StandIn::Certain } else { StandIn::Half };
        let rounded = here && self.newton == 1 && self.pcg.bears_rounding(self.tolerance);
        let factors = Factors { mass: 1.0, stiffness: g * g, damping: g, stand_in, after_forces: true, rounded };
        let start = Instant::now();
        let still = if here { Some(&self.still[..]) } else { None };
        let force = (&mut self.force[..], rounded && self.tolerance >= SIX_DIGITS);
        let mut matrix = linearise(pool, system, (still, force), factors, now)?;
        report.seconds[0] += start.elapsed().as_secs_f64();
        for springs in loads.tools {
            matrix.add_diagonal(springs, (g * g, g));
        }
        let v = (!here).then_some(&system.nodes.v[..]);
        add_loads(&mut self.force, loads, &system.nodes.x, v);
        self.pcg.prepare(&matrix, &system.sets, &system.nodes.rest);
        // Where the body is: b = M v + g f_elastic - A v.
        let moving = here.then_some((&system.nodes.v[..], &mut self.moving[..]));
        self.pcg.guess(pool, &matrix, moving);
        let mut size = 0.0_f64;
        let (mut pass, mut stops, mut again) = (0, 0, false);
        while pass < PASSES {
            self.z.fill([0.0; 3]);
            holds.add_forces(&mut self.z);
            let nodes = &system.nodes;
            let (mut b, mut z) = (std::mem::take(&mut self.b), std::mem::take(&mut self.z));
            let start = match here {
                true => Start::Here(&self.moving),
                false => Start::There([&self.from[1], &self.before[1]], form.carry),
            };
            let (force, gravity) = (&self.force[..], loads.gravity);
            let squares = pool.fold((&mut b[..], &mut z[..]), &|first, (b, z)| {
                let prescribed = |i: usize| self.prescribed(i, nodes.prescribed[i], form, dt);
                pulp::Arch::new().dispatch(RightSide { nodes, force, gravity, g, start, prescribed, first, b, z })
            });
            (self.b, self.z) = (b, z);
            if !again {
                size = squares.sqrt();
            }
            let solve = Solve {
                matrix: &matrix,
                b: &self.b,
                z: &self.z,
                constraints: &nodes.constraint,
                motion: (&nodes.x, g),
                again,
                tolerance: self.tolerance,
                most: self.most_iterations,
            };
            let start = Instant::now();
            let (near, known) = (holds.is_near(), &*holds);
            let solved = self.pcg.solve_watched(pool, &solve, &mut |peek| {
                let outcome = Outcome {
                    after: &|s, i| axpy(s.nodes.v[i], 1.0, peek.at(i)),
                    reaction: &|i| peek.reaction(i).map(|c| c / g),
                    doubt: Some(&doubt(&matrix, peek.left(), g)),
                };
                near && stops < STOPS && known.foresees(system, &outcome)
            });
            report.seconds[1] += start.elapsed().as_secs_f64();
            if solved.too_rough {
                let start = Instant::now();
                matrix = assemble(pool, system, matrix, Factors { rounded: false, ..factors }, now)?;
                report.seconds[0] += start.elapsed().as_secs_f64();
                for springs in loads.tools {
                    matrix.add_diagonal(springs, (g * g, g));
                }
                let moving = here.then_some((&system.nodes.v[..], &mut self.moving[..]));
                self.pcg.load(pool, &matrix, moving);
                again = false;
                continue;
            }
            again = true;
            if !solved.residual.is_finite() {
                let odd = |i: &usize| !is_finite(self.b[*i]) || !matrix.diagonal(*i).iter().all(|k| k.is_finite());
                let node = (0..self.b.len()).find(odd).unwrap_or(0);
                let stiff = matrix.diagonal(node).iter().all(|k| k.is_finite());
                system.matrix = Some(matrix);
                system.nodes.x.copy_from_slice(&self.from[0]);
                return Err(match stiff {
                    true => StepError::Diverged { node },
                    false => system.material.not_finite("tangent", node).into(),
                });
            }
            report.iterations += solved.iterations;
            if solved.stopped.is_some() {
                stops += 1;
            } else {
                pass += 1;
                report.residual = report.residual.max(solved.residual);
                report.converged &= solved.converged;
            }
            if !near && nodes.constraint.iter().all(Constraint::is_free) {
                self.reaction.fill([0.0; 3]);
                break;
            }
            let (b, change) = (&self.b, &self.pcg.x);
            self.reaction.fill([0.0; 3]);
            for (i, product) in self.pcg.held() {
                self.reaction[i] = axpy(product, -1.0, b[i]).map(|c| c / g);
            }
            let (reaction, doubt) = (&self.reaction, doubt(&matrix, solved.stopped.unwrap_or(0.0), g));
            let outcome = Outcome {
                after: &|s, i| axpy(s.nodes.v[i], 1.0, change[i]),
                reaction: &|i| reaction[i],
                doubt: solved.stopped.map(|_| &doubt as &Doubt<'_>),
            };
            if !holds.revise(system, &outcome) && solved.stopped.is_none() {
                break;
            }
        }
        pool.pieces((&mut system.nodes.v[..], &mut self.pcg.x[..]), NODES, &|_, (v, dv): (&mut [V3], &mut [V3])| {
            for (v, dv) in v.iter_mut().zip(dv) {
                *dv = without_dust(*dv);
                *v = without_dust(axpy(*v, 1.0, *dv));
            }
        });
        if iteration > 0 || self.newton > 1 {
            // What is left to do next time has nothing to do with what was done.
            self.pcg.forget();
        }
        system.matrix = Some(matrix);
        Ok(size)
    }

    /// A state that is no longer finite is the material's doing where its force is not.
    fn blame(&self, error: StepError, system: &System) -> StepError {
        match error {
            StepError::Diverged { node } if !is_finite(self.force[node]) => {
                system.material.not_finite("forces", node).into()
            }
            other => other,
        }
    }

    /// The velocity of a held node that takes it where it has to be at the end of the step.
    fn prescribed(&self, i: usize, p: V3, form: &Form, dt: f64) -> V3 {
        if form.carry == 0.0 {
            return p;
        }
        let x = self.from[0][i];
        let carried = axpy(x, form.carry, axpy(x, -1.0, self.before[0][i]));
        axpy(axpy(x, dt, p), -1.0, carried).map(|c| c / form.g)
    }
}

/// The matrix and the forces of `system` as it stands, with velocities `v` in the forces, which may be those of
/// [`System::forces_rounded`]. The matrix is lent: it has to be put back.
///
/// # Errors
/// What the material says; then nothing is lent.
pub(super) fn linearise(
    pool: &Pool,
    system: &mut System,
    (v, force): (Option<&[V3]>, (&mut [V3], bool)),
    factors: Factors,
    now: (f64, f64),
) -> Result<Matrix, HostError> {
    system.forces_rounded(pool, v, now, force)?;
    let matrix = system.matrix.take().unwrap_or_default();
    assemble(pool, system, matrix, factors, now)
}

/// A matrix of `system` takes on the values of its state; it is put back if that fails.
fn assemble(
    pool: &Pool,
    system: &mut System,
    mut matrix: Matrix,
    factors: Factors,
    now: (f64, f64),
) -> Result<Matrix, HostError> {
    let state = (&system.nodes, system.coupled.as_mut());
    let assembled = matrix.assemble(pool, &system.material, &system.sets, state, factors, now);
    if let (Some(normals), Ok(())) = (&system.normals, &assembled) {
        matrix.add_normals(pool, normals, (&system.sets, &system.nodes), factors);
    }
    match assembled {
        Ok(()) => Ok(matrix),
        Err(error) => {
            system.matrix = Some(matrix);
            Err(error)
        }
    }
}

/// Refuses velocities that are not finite; gives the fastest, m/s.
pub(super) fn check(system: &mut System) -> Result<f64, StepError> {
    let v = &mut system.nodes.v;
    // Side by side, for one has to wait for the one before. What is not finite stays in a sum.
    let (mut fastest, mut sums) = ([0.0_f64; 8], [0.0; 8]);
    for v in v.chunks(fastest.len()) {
        for ((fastest, sum), v) in fastest.iter_mut().zip(&mut sums).zip(v) {
            let speed = dot(*v, *v);
            *fastest = if speed > *fastest { speed } else { *fastest };
            *sum += speed;
        }
    }
    if !sums.iter().all(|sum| sum.is_finite())
        && let Some(node) = v.iter().position(|v| !dot(*v, *v).is_finite())
    {
        v.fill([0.0; 3]);
        return Err(StepError::Diverged { node });
    }
    Ok(fastest.iter().fold(0.0_f64, |most, speed| most.max(*speed)).sqrt())
}

fn is_finite(v: V3) -> bool {
    v.iter().all(|c| c.is_finite())
}

/// Adds external forces and those of the tools to `force`.
pub(super) fn add_loads(force: &mut [V3], loads: &Loads<'_>, x: &[V3], v: Option<&[V3]>) {
    for (f, load) in force.iter_mut().zip(loads.forces) {
        *f = axpy(*f, 1.0, *load);
    }
    for springs in loads.tools {
        springs.add_to(force, x, v);
    }
}
