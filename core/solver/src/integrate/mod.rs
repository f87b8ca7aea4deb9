//! Time integration: one step of one body.
//!
//! Implicit schemes share one form. The unknown is the velocity v of a stage, whose position is `X + g v` with the effective step size g.
//! Newton's method on `M (v - V) = g f(X + g v, v)` solves `A dv = M (V - v) + g f` with `A = M + g C + g^2 K`. A scheme is defined by its
//! coefficients ([`scheme`]).

pub mod contact_constraints;
mod energy_guard;
mod explicit;
mod implicit;
pub mod limit;
mod quasi_static;
mod refinement;
mod response;
mod right_side;
pub mod scheme;
#[cfg(test)]
mod velocity_tests;

use super::algebra::Vec3;
use super::solver::{Pcg, Preconditioner};
use super::springs::NodeSprings;
use super::system::System;
use super::threads::Pool;
use crate::force_model::{ForceError, StepTime};
use crate::interrupts::Interrupts;
use contact_constraints::{ContactConstraints, NoContacts};
use energy_guard::EnergyGuard;
use refinement::Refinement;
use scheme::{ExplicitOrder, History, Method, Scheme};
use thiserror::Error;

/// External loads on a body during a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Loads<'a> {
    /// Acceleration of gravity, m/s^2.
    pub gravity: Vec3,
    /// External force on each node, N (n x 3), or empty for none.
    pub forces: &'a [Vec3],
    /// Linear springs and dampers on nodes, one set for each tool.
    pub tools: &'a [NodeSprings],
}

/// Statistics of a step, over all of its substeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport {
    /// Iterations of the linear solver, summed over all solves.
    pub iterations: usize,
    /// Largest final relative residual of a solve, in the norm of the preconditioner.
    pub residual: f64,
    /// Whether every solve met its tolerance.
    pub converged: bool,
    /// Speed of the fastest node at the end, m/s.
    pub max_speed: f64,
    /// Number of Newton iterations, over all substeps.
    pub newton_iterations: usize,
    /// Number of substeps.
    pub substeps: usize,
    /// Steps that would have gained energy and were taken again: implicit ones with backward Euler and more Newton iterations, explicit ones with
    /// twice as many substeps.
    pub repeated_steps: usize,
    /// Wall-clock time of element forces and matrix assembly, s.
    pub assembly_seconds: f64,
    /// Wall-clock time of the linear solves, s.
    pub solve_seconds: f64,
}

impl Default for StepReport {
    fn default() -> Self {
        Self {
            iterations: 0,
            residual: 0.0,
            converged: true,
            max_speed: 0.0,
            newton_iterations: 0,
            substeps: 1,
            repeated_steps: 0,
            assembly_seconds: 0.0,
            solve_seconds: 0.0,
        }
    }
}

/// Why a step failed. The body is where it was before the step (explicit schemes that move nodes first: but for rounding), and contacts hold none of
/// its nodes.
#[derive(Debug, Error)]
pub enum StepError {
    /// The material failed. All velocities are set to zero. If it failed in the update of its history, a step of one substep has moved the body.
    #[error(transparent)]
    Force(#[from] ForceError),
    /// A node's velocity is not finite. All velocities are set to zero.
    #[error("the velocity of node {node} is not finite")]
    Diverged {
        /// Index of the first such node.
        node: usize,
    },
    /// The step was stopped ([`Interrupts::cancel`]).
    #[error("stopped")]
    Cancelled,
    /// The step took too long ([`Interrupts::deadline`]).
    #[error("took too long")]
    TimedOut,
}

/// A time integration scheme with its settings and work vectors, for one body.
pub struct Integrator {
    /// Time integration scheme.
    pub scheme: Scheme,
    /// Relative tolerance of each linear solve, in the norm of the preconditioner.
    pub tolerance: f64,
    /// Largest number of iterations of each linear solve.
    pub max_iterations: usize,
    /// Largest number of Newton iterations of each step.
    pub max_newton: usize,
    /// Relative tolerance of Newton's method: it stops when the residual falls below this fraction of the first one.
    pub newton_tolerance: f64,
    /// Largest displacement of a node in one Newton iteration of a quasi-static step, m.
    pub max_displacement: f64,
    /// Speed of a node, m/s, from which on a step of backward Euler, BDF2 or symplectic Euler may not gain energy; one of a midpoint rule may not at
    /// any speed.
    pub guarded_speed: f64,
    /// Substeps, at most, of a step of symplectic Euler that would gain energy.
    pub max_substeps: usize,
    /// Whether contact after the step may change velocities ([`Integrator::respond`]): implicit steps are then those of backward Euler, as with contacts
    /// within them, with a matrix in double precision.
    pub in_contact: bool,
    /// What ends a step before it is done.
    pub interrupts: Interrupts,
    /// Constraint force on each node in the last step, N (n x 3).
    pub reaction: Vec<Vec3>,
    /// Force on each node, N (n x 3).
    force: Vec<Vec3>,
    /// Explicit schemes: contact forces (N), then new velocities (m/s). Implicit schemes: zero velocities (n x 3).
    scratch: Vec<Vec3>,
    /// A v, N s (n x 3).
    momentum: Vec<Vec3>,
    /// Right-hand side of the linear system, N s (n x 3).
    b: Vec<Vec3>,
    /// Prescribed changes of the velocities, m/s (n x 3).
    z: Vec<Vec3>,
    /// Positions and velocities at the beginning of a step of several substeps.
    start: [Vec<Vec3>; 2],
    /// Positions and velocities at the beginning of the substep, of implicit schemes.
    from: [Vec<Vec3>; 2],
    /// Positions and velocities at the beginning of the substep before.
    before: [Vec<Vec3>; 2],
    /// Effective step size of the matrix that the solver has, s; 0 before the first.
    matrix_step: f64,
    /// Whether that matrix is new to the preconditioner.
    needs_update: bool,
    /// Whether a spring of a tool takes momentum from the body.
    has_springs: bool,
    history: History,
    energy_guard: EnergyGuard,
    refinement: Refinement,
    pcg: Pcg,
}

/// Inputs of a step or of one of its substeps.
struct Substep<'a> {
    pool: &'a Pool,
    loads: &'a Loads<'a>,
    contacts: &'a mut dyn ContactConstraints,
    time: StepTime,
}

impl Integrator {
    /// An integrator for zero nodes; call [`Integrator::resize`] next. `max_newton` is 200 for quasi-static steps and 1 for all others.
    pub fn new(scheme: Scheme, tolerance: f64, max_iterations: usize) -> Self {
        Self {
            scheme,
            tolerance,
            max_iterations,
            max_newton: if scheme == Scheme::QuasiStatic { 200 } else { 1 },
            newton_tolerance: 1e-6,
            max_displacement: f64::INFINITY,
            guarded_speed: f64::INFINITY,
            max_substeps: 0,
            in_contact: false,
            interrupts: Interrupts::default(),
            reaction: Vec::new(),
            force: Vec::new(),
            scratch: Vec::new(),
            momentum: Vec::new(),
            b: Vec::new(),
            z: Vec::new(),
            start: Default::default(),
            from: Default::default(),
            before: Default::default(),
            matrix_step: 0.0,
            needs_update: false,
            has_springs: false,
            history: History::Interrupted,
            energy_guard: EnergyGuard::default(),
            refinement: Refinement::default(),
            pcg: Pcg::default(),
        }
    }

    /// An integrator for zero nodes with the settings of this one; call [`Integrator::resize`] next.
    #[must_use]
    pub fn with_same_settings(&self) -> Self {
        let mut other = Self::new(self.scheme, self.tolerance, self.max_iterations);
        other.max_newton = self.max_newton;
        other.newton_tolerance = self.newton_tolerance;
        other.max_displacement = self.max_displacement;
        other.guarded_speed = self.guarded_speed;
        other.max_substeps = self.max_substeps;
        other.set_preconditioner(self.pcg.preconditioner);
        other
    }

    /// Chooses the preconditioner of the linear solves.
    pub fn set_preconditioner(&mut self, preconditioner: Preconditioner) {
        self.pcg.preconditioner = preconditioner;
    }

    /// Memory of the work vectors, bytes.
    pub fn bytes(&self) -> usize {
        self.force.len() * 11 * size_of::<Vec3>() + self.pcg.bytes()
    }

    /// Sets the number of nodes and discards the history. Call it after nodes or elements have changed.
    pub fn resize(&mut self, n: usize) {
        self.matrix_step = 0.0;
        self.force.resize(n, Vec3::zeros());
        let [x, v] = &mut self.start;
        for field in [&mut self.reaction, &mut self.scratch, x, v] {
            field.clear();
            field.resize(n, Vec3::zeros());
        }
        self.forget_history();
        if self.scheme.is_implicit() {
            let [x, v] = &mut self.from;
            let [x_before, v_before] = &mut self.before;
            for field in [&mut self.momentum, &mut self.b, &mut self.z, x, v, x_before, v_before] {
                field.clear();
                field.resize(n, Vec3::zeros());
            }
            self.pcg.resize(n);
        }
    }

    /// Discards the previous state. Call it after positions or velocities were set from outside.
    pub fn forget_history(&mut self) {
        self.history = History::Interrupted;
        self.energy_guard.reset();
        self.refinement = Refinement::default();
    }

    /// Advances `system` by `time.dt` in `substeps` equal steps, without contacts.
    ///
    /// # Errors
    /// Returns the error of the material, [`StepError::Diverged`] if a velocity is not finite, or an interrupt.
    pub fn step(
        &mut self,
        pool: &Pool,
        system: &mut System,
        loads: &Loads<'_>,
        time: StepTime,
        substeps: usize,
    ) -> Result<StepReport, StepError> {
        self.step_with_contacts(pool, system, loads, &mut NoContacts, time, substeps)
    }

    /// Advances `system` by `time.dt` in `substeps` equal steps under contact constraints.
    ///
    /// # Errors
    /// Those of [`Integrator::step`].
    pub fn step_with_contacts(
        &mut self,
        pool: &Pool,
        system: &mut System,
        loads: &Loads<'_>,
        contacts: &mut dyn ContactConstraints,
        time: StepTime,
        substeps: usize,
    ) -> Result<StepReport, StepError> {
        // Nothing is begun that would have to be taken back: solver and history go on as if the step had not been asked for.
        self.interrupts.check()?;
        let mut step = Substep { pool, loads, contacts, time };
        step.contacts.keep_start();
        let is_guarded = matches!(self.scheme.properties().method, Method::Explicit(ExplicitOrder::VelocityFirst))
            && self.guarded_speed < f64::INFINITY;
        let stepped = if is_guarded {
            self.refined_step(system, &mut step, substeps)
        } else {
            if substeps > 1 {
                self.keep_start(system);
                system.keep_history();
            }
            self.substeps(system, &mut step, substeps, substeps > 1)
        };
        if let Err(StepError::Diverged { .. } | StepError::Force(_)) = &stepped {
            system.nodes.v.fill(Vec3::zeros());
        }
        stepped
    }

    /// Takes a step in `substeps` equal parts. If it fails, contacts let go of what they hold, and with `has_start` (`self.start` and
    /// [`System::keep_history`] have the state before it) the body returns to its start.
    fn substeps(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        substeps: usize,
        has_start: bool,
    ) -> Result<StepReport, StepError> {
        let mut report = StepReport { substeps, ..StepReport::default() };
        let stepped = self.take_substeps(system, step, substeps, &mut report);
        stepped.map(|()| report).map_err(|error| {
            let error = self.attribute(error, system);
            step.contacts.take_back(system);
            if has_start {
                self.return_to_start(system);
            }
            self.reaction.fill(Vec3::zeros());
            self.history = History::Interrupted;
            self.pcg.forget();
            error
        })
    }

    /// The loop of [`substeps`](Self::substeps). On an error positions are those at the start of a substep.
    fn take_substeps(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        substeps: usize,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let (pool, loads, time) = (step.pool, step.loads, step.time);
        let dt = time.dt / substeps as f64;
        for sub in 0..substeps {
            self.interrupts.check()?;
            let now = StepTime { start: time.start + sub as f64 * dt, dt };
            let mut step = Substep { pool, loads, contacts: &mut *step.contacts, time: now };
            match self.scheme.properties().method {
                Method::Equilibrium => self.settle(system, &mut step, report),
                Method::Implicit(coefficients) => self.implicit(system, &mut step, coefficients, report),
                Method::Explicit(order) => self.explicit(system, &mut step, order, report),
            }?;
            system.advance(pool, StepTime { start: now.end(), dt })?;
        }
        Ok(())
    }

    /// Records positions and velocities before a step.
    fn keep_start(&mut self, system: &System) {
        let [x, v] = &mut self.start;
        x.copy_from_slice(&system.nodes.x);
        v.copy_from_slice(&system.nodes.v);
    }

    /// Puts positions, velocities and the history of elements back to what was recorded.
    fn return_to_start(&self, system: &mut System) {
        system.nodes.x.copy_from_slice(&self.start[0]);
        system.nodes.v.copy_from_slice(&self.start[1]);
        system.swap_history();
    }

    /// Attributes a state that is not finite to the material if its force is not finite, and to the solver otherwise.
    fn attribute(&self, error: StepError, system: &System) -> StepError {
        if let StepError::Diverged { node } = error
            && !is_finite(self.force[node])
        {
            return system.material.not_finite("forces", node).into();
        }
        error
    }
}

/// Returns the largest speed of a node, m/s.
///
/// # Errors
/// [`StepError::Diverged`] if a velocity is not finite; all velocities are then set to zero.
fn check(system: &mut System) -> Result<f64, StepError> {
    let v = &mut system.nodes.v;
    // Eight independent sums, because each addition waits for the previous one. A value that is not finite makes its sum not finite.
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

fn is_finite(v: Vec3) -> bool {
    v.iter().all(|c| c.is_finite())
}

/// Adds external forces and the forces of the tools at positions `x` (m) and velocities `v` (m/s) to `force` (N), all n x 3.
fn add_loads(force: &mut [Vec3], loads: &Loads<'_>, x: &[Vec3], v: Option<&[Vec3]>) {
    for (f, load) in force.iter_mut().zip(loads.forces) {
        *f += *load;
    }
    for springs in loads.tools {
        springs.add_to(force, x, v);
    }
}
