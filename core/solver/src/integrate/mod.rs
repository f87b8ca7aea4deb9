//! Time integration: one step of one body.
//!
//! Implicit schemes share one form. The unknown is a velocity v; the position it leads to is `X + g v`, and Newton's method on
//! `M (v - V) = g f(X + g v, v)` takes a step `A dv = M (V - v) + g f` with `A = M + g C + g^2 K`. Backward Euler has
//! X = x, V = v, g = dt; BDF2 (Gear 1971) the same with two states behind it; implicit midpoint solves for the velocity
//! halfway. One Newton step, linearised where the body is, is what a hand can wait for (Baraff and Witkin 1998).

mod explicit;
pub mod holds;
mod implicit;
pub mod limit;
mod quasi_static;
mod right_side;

use super::algebra::Vec3;
use super::solver::{Pcg, Preconditioner};
use super::springs::NodeSprings;
use super::system::System;
use super::threads::Pool;
use crate::force_model::{ForceError, StepTime};
use holds::{Holds, HoldsNothing};
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

/// What acts on a body during a step, besides itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Loads<'a> {
    /// m/s^2
    pub gravity: Vec3,
    /// N (n x 3), or empty
    pub forces: &'a [Vec3],
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
    Force(#[from] ForceError),
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
    pub reaction: Vec<Vec3>,
    pub(super) force: Vec<Vec3>,
    pub(super) still: Vec<Vec3>,
    /// Matrix times velocity, N s.
    pub(super) moving: Vec<Vec3>,
    pub(super) b: Vec<Vec3>,
    pub(super) z: Vec<Vec3>,
    /// Where the step began, and the step before it.
    pub(super) from: [Vec<Vec3>; 2],
    pub(super) before: [Vec<Vec3>; 2],
    pub(super) has_past: bool,
    pub(super) pcg: Pcg,
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
        self.force.len() * 9 * size_of::<Vec3>() + self.pcg.bytes()
    }

    /// Room for `n` nodes. After a change of nodes or elements, also forgets the last solution.
    pub fn resize(&mut self, n: usize) {
        self.force.resize(n, Vec3::zeros());
        for field in [&mut self.reaction, &mut self.still] {
            field.clear();
            field.resize(n, Vec3::zeros());
        }
        self.has_past = false;
        if self.scheme.is_implicit() {
            let [x, v] = &mut self.from;
            let [x_before, v_before] = &mut self.before;
            for field in [&mut self.moving, &mut self.b, &mut self.z, x, v, x_before, v_before] {
                field.clear();
                field.resize(n, Vec3::zeros());
            }
            self.pcg.resize(n);
        }
    }

    /// The past does not lead to here: positions or velocities were set from outside.
    pub fn forget_past(&mut self) {
        self.has_past = false;
    }

    /// Moves `system` by `substeps` steps that take as long as `time` says together.
    ///
    /// # Errors
    /// A material that fails, or a state that is no longer finite.
    pub fn step(
        &mut self,
        pool: &Pool,
        system: &mut System,
        loads: &Loads<'_>,
        time: StepTime,
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
        time: StepTime,
        substeps: usize,
    ) -> Result<StepReport, StepError> {
        let dt = time.dt / substeps as f64;
        let mut report = StepReport::default();
        for sub in 0..substeps {
            let now = StepTime { start: time.start + sub as f64 * dt, dt };
            let stepped = match self.scheme {
                Scheme::QuasiStatic => self.settle(pool, system, (loads, holds), now, &mut report),
                scheme if scheme.is_implicit() => self.implicit(pool, system, (loads, holds), now, &mut report),
                _ => self.explicit(pool, system, (loads, holds), now, &mut report),
            };
            stepped.map_err(|error| self.blame(error, system))?;
            system.advance(StepTime { start: now.end(), dt })?;
        }
        Ok(report)
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
}

/// Refuses velocities that are not finite; gives the fastest, m/s.
pub(super) fn check(system: &mut System) -> Result<f64, StepError> {
    let v = &mut system.nodes.v;
    // Side by side, for one has to wait for the one before. What is not finite stays in a sum.
    let (mut fastest, mut sums) = ([0.0_f64; 8], [0.0; 8]);
    for v in v.chunks(fastest.len()) {
        for ((fastest, sum), v) in fastest.iter_mut().zip(&mut sums).zip(v) {
            let speed = v.norm_squared();
            *fastest = if speed > *fastest { speed } else { *fastest };
            *sum += speed;
        }
    }
    if !sums.iter().all(|sum| sum.is_finite())
        && let Some(node) = v.iter().position(|v| !v.norm_squared().is_finite())
    {
        v.fill(Vec3::zeros());
        return Err(StepError::Diverged { node });
    }
    Ok(fastest.iter().fold(0.0_f64, |most, speed| most.max(*speed)).sqrt())
}

pub(super) fn is_finite(v: Vec3) -> bool {
    v.iter().all(|c| c.is_finite())
}

/// Adds external forces and those of the tools to `force`.
pub(super) fn add_loads(force: &mut [Vec3], loads: &Loads<'_>, x: &[Vec3], v: Option<&[Vec3]>) {
    for (f, load) in force.iter_mut().zip(loads.forces) {
        *f += *load;
    }
    for springs in loads.tools {
        springs.add_to(force, x, v);
    }
}
