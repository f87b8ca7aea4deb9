//! Implicit steps with inertia: Newton's method with an active set of contact constraints.

use super::contact_constraints::{ErrorBound, TrialStep};
use super::energy_guard::work;
use super::right_side::{RightSide, Start};
use super::scheme::{History, ImplicitCoefficients, Linearisation, backward_euler};
use super::{Integrator, Loads, StepError, StepReport, Substep, add_loads, check, is_finite};
use crate::algebra::{Vec3, flush_denormals};
use crate::force_model::ForceError;
use crate::matrix::Matrix;
use crate::nodes::Nodes;
use crate::solver::Momentum;
use crate::solver::filtered_system::FilteredSystem;
use crate::solver::partial_solution::error_bound;
use crate::system::System;
use crate::system_scales::SystemScales;
use crate::threads::NODES;
use pliant_plugin_api::TangentScale;
use pliant_plugin_api::lanes::vector_unit;
use std::time::Instant;

/// Relative tolerance of a solve above which hinge moments may be computed in single precision (six digits).
const SIX_DIGIT_TOLERANCE: f64 = 1e-5;
/// Newton iterations, at most, of a step that is taken again: it is long for the forces.
const REPEATED_NEWTON: usize = 8;
/// Largest number of solves that are stopped early for a change of the active set, in one Newton iteration.
const MAX_EARLY_STOPS: usize = 8;

impl ImplicitCoefficients {
    /// X of a node whose positions are `x` and, one step earlier, `before`, all in m.
    fn extrapolate(&self, x: Vec3, before: Vec3) -> Vec3 {
        if self.history > 0.0 { x + self.history * (x - before) } else { x }
    }
}

/// One Newton iteration of a step.
struct Iteration<'a> {
    coefficients: &'a ImplicitCoefficients,
    /// Index of the iteration, from 0.
    index: usize,
}

impl Iteration<'_> {
    /// Whether forces are linearised at the positions before the step.
    fn at_current_state(&self) -> bool {
        self.index == 0
            && match self.coefficients.first {
                Linearisation::Current => true,
                Linearisation::Predicted => false,
            }
    }

    /// Factors of masses, stiffness and damping in the matrix; whether its blocks may be in single precision.
    fn scales(&self, allow_f32: bool) -> SystemScales {
        let effective_dt = self.coefficients.effective_dt;
        SystemScales {
            mass: 1.0,
            stiffness: effective_dt * effective_dt,
            damping: effective_dt,
            hessian: self.coefficients.hessian,
            strains_are_current: true,
            allow_f32,
        }
    }
}

impl Integrator {
    /// Takes an implicit step with the coefficients of a scheme.
    ///
    /// # Errors
    /// Returns the error of the material, or [`StepError::Diverged`].
    pub(super) fn implicit(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        coefficients: fn(f64, History) -> ImplicitCoefficients,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let (pool, dt) = (step.pool, step.time.dt);
        let (nodes, [x, v]) = (&system.nodes, &mut self.from);
        pool.par_chunks((&mut x[..], &mut v[..]), NODES, &|first, (x, v)| {
            x.copy_from_slice(&nodes.x[first..first + x.len()]);
            v.copy_from_slice(&nodes.v[first..first + v.len()]);
        });
        step.contacts.begin(system, dt);
        let history =
            if self.in_contact || step.contacts.interrupts_history() { History::Interrupted } else { self.history };
        let mut of_scheme = coefficients(dt, history);
        // Contacts begin and end with a step; the midpoint rules would extrapolate what they do to a node beyond it.
        if of_scheme.stage < 1.0 && (self.in_contact || step.contacts.is_active() || step.contacts.has_candidates()) {
            of_scheme = backward_euler::coefficients(dt, History::Interrupted);
        }
        report.max_speed = self.step_from_start(system, step, &of_scheme, report).inspect_err(|_| {
            system.nodes.x.copy_from_slice(&self.from[0]);
            system.nodes.v.copy_from_slice(&self.from[1]);
        })?;
        std::mem::swap(&mut self.from, &mut self.before);
        self.history = History::Continuous;
        step.contacts.end(system, &mut self.reaction);
        Ok(())
    }

    /// Takes the step from the state in `self.from`, and again with backward Euler if it would gain energy. Returns the speed of its fastest node, m/s.
    fn step_from_start(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        coefficients: &ImplicitCoefficients,
        report: &mut StepReport,
    ) -> Result<f64, StepError> {
        self.solve_step(system, step, coefficients, self.max_newton, report)?;
        let fastest = check(system)?;
        let is_damped = coefficients.stage == 1.0 && fastest < self.guarded_speed;
        if is_damped || self.admits(system, step)? {
            return Ok(fastest);
        }
        system.nodes.x.copy_from_slice(&self.from[0]);
        system.nodes.v.copy_from_slice(&self.from[1]);
        self.pcg.forget();
        report.repeated_steps += 1;
        let damped = backward_euler::coefficients(step.time.dt, History::Interrupted);
        self.solve_step(system, step, &damped, self.max_newton.max(REPEATED_NEWTON), report)?;
        check(system)
    }

    /// Whether the step to the present state may stand.
    ///
    /// # Errors
    /// Returns the error of the material.
    fn admits(&mut self, system: &mut System, step: &Substep<'_>) -> Result<bool, StepError> {
        let after = energy(system, step)?;
        self.z.copy_from_slice(&self.reaction);
        step.contacts.add_forces(&mut self.z);
        let work = work(step.loads, &system.nodes, &self.z, [&self.from[0], &self.from[1]]);
        let mut swap = |system: &mut System| {
            std::mem::swap(&mut system.nodes.x, &mut self.from[0]);
            std::mem::swap(&mut system.nodes.v, &mut self.from[1]);
        };
        swap(system);
        let before = energy(system, step);
        swap(system);
        Ok(self.energy_guard.admit(before?, after, work))
    }

    /// Newton's method, of `max_newton` iterations at most, for one step from the state in `self.from`; leaves the nodes at its end.
    fn solve_step(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        coefficients: &ImplicitCoefficients,
        max_newton: usize,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let (pool, dt) = (step.pool, step.time.dt);
        let mut first = 0.0;
        for index in 0..max_newton.max(1) {
            let iteration = Iteration { coefficients, index };
            let residual_norm = self.newton_step(system, step, &iteration, report)?;
            if index == 0 {
                first = residual_norm;
            }
            report.newton_iterations += 1;
            if residual_norm <= self.newton_tolerance * first {
                break;
            }
        }
        let (Nodes { x: x_new, v: v_new, constraint, prescribed, .. }, [x, v], past) =
            (&mut system.nodes, &self.from, &self.before[0]);
        pool.par_chunks((&mut x_new[..], &mut v_new[..]), NODES, &|first, (x_new, v_new)| {
            for (i, (x_new, v_new)) in (first..).zip(x_new.iter_mut().zip(v_new)) {
                if coefficients.stage < 1.0 {
                    // Extrapolates the velocity of the stage to the end of the step: v_0 + (v - v_0) / stage.
                    *x_new = x[i] + dt * *v_new;
                    let end = *v_new / coefficients.stage - v[i] * (1.0 / coefficients.stage - 1.0);
                    *v_new = constraint[i].merge(end, prescribed[i]);
                } else {
                    *x_new = coefficients.extrapolate(x[i], past[i]) + coefficients.effective_dt * *v_new;
                }
            }
        });
        Ok(())
    }

    /// One Newton iteration: solves until the active set no longer changes. Returns the norm of the initial residual, N s.
    fn newton_step(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        iteration: &Iteration<'_>,
        report: &mut StepReport,
    ) -> Result<f64, StepError> {
        self.interrupts.check()?;
        step.contacts.begin_iteration();
        if !iteration.at_current_state() {
            self.predict(&mut system.nodes, iteration.coefficients);
        }
        let mut matrix = self.assemble_system(system, step, iteration, report)?;
        let residual_norm = self.solve_active_set(system, step, iteration, &mut matrix, report);
        system.matrix = Some(matrix);
        let residual_norm = residual_norm?;
        let vectors = (&mut system.nodes.v[..], &mut self.pcg.x[..]);
        step.pool.par_chunks(vectors, NODES, &|_, (v, dv): (&mut [Vec3], &mut [Vec3])| {
            for (v, dv) in v.iter_mut().zip(dv) {
                *dv = flush_denormals(*dv);
                *v = flush_denormals(*v + *dv);
            }
        });
        if iteration.index > 0 || self.max_newton > 1 {
            // The corrections of successive Newton iterations are no sequence that an initial guess could extrapolate.
            self.pcg.forget();
        }
        Ok(residual_norm)
    }

    /// Whether the matrix of an iteration may be in single precision.
    fn allows_f32(&self, iteration: &Iteration<'_>) -> bool {
        let is_only_solve = iteration.at_current_state() && self.max_newton == 1 && !self.in_contact;
        is_only_solve && self.pcg.allows_f32(self.tolerance)
    }

    /// Computes forces and matrix of an iteration, and prepares the preconditioner and the initial guess. The caller gives the matrix back to `system`.
    fn assemble_system(
        &mut self,
        system: &mut System,
        step: &Substep<'_>,
        iteration: &Iteration<'_>,
        report: &mut StepReport,
    ) -> Result<Matrix, StepError> {
        let (pool, loads, effective_dt) = (step.pool, step.loads, iteration.coefficients.effective_dt);
        let (at_current, allow_f32) = (iteration.at_current_state(), self.allows_f32(iteration));
        let start = Instant::now();
        // At the current state the velocity term of the forces is part of A v.
        let v = if at_current { Some(&self.scratch[..]) } else { None };
        system.forces_with_precision(
            pool,
            v,
            step.time,
            &mut self.force,
            allow_f32 && self.tolerance >= SIX_DIGIT_TOLERANCE,
        )?;
        let mut matrix = assemble_taken(step, system, iteration.scales(allow_f32))?;
        report.assembly_seconds += start.elapsed().as_secs_f64();
        add_tools(&mut matrix, loads, effective_dt);
        self.matrix_step = effective_dt;
        let v = (!at_current).then_some(&system.nodes.v[..]);
        add_loads(&mut self.force, loads, &system.nodes.x, v);
        self.pcg.prepare(&matrix, &system.sets, &system.nodes.rest);
        // At the current state: b = M v + g f_elastic - A v.
        let momentum = at_current.then_some(Momentum { v: &system.nodes.v, product: &mut self.momentum });
        self.pcg.guess(pool, &matrix, momentum);
        Ok(matrix)
    }

    /// Solves for the velocity change until the active set of contacts no longer changes. Returns the norm of the initial residual, N s.
    fn solve_active_set(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        iteration: &Iteration<'_>,
        matrix: &mut Matrix,
        report: &mut StepReport,
    ) -> Result<f64, StepError> {
        let (pool, effective_dt) = (step.pool, iteration.coefficients.effective_dt);
        let mut residual_norm = 0.0_f64;
        let (mut pass, mut stops, mut same_matrix) = (0, 0, false);
        while pass < step.contacts.max_passes() {
            let squares = self.right_side(&system.nodes, step, iteration);
            if !same_matrix {
                residual_norm = squares.sqrt();
            }
            let nodes = &system.nodes;
            let filtered = FilteredSystem {
                matrix,
                b: &self.b,
                z: &self.z,
                constraints: &nodes.constraint,
                positions: &nodes.x,
                displacement_per_unit: effective_dt,
                same_matrix,
                tolerance: self.tolerance,
                max_iterations: self.max_iterations,
                interrupts: Some(&self.interrupts),
            };
            let start = Instant::now();
            let (near, contacts, from) = (step.contacts.has_candidates(), &*step.contacts, &self.from[0]);
            let solved = self.pcg.solve_until(pool, &filtered, &mut |partial| {
                let trial = TrialStep {
                    start: &|_, i| from[i],
                    velocity: &|s, i| s.nodes.v[i] + partial.at(i),
                    reaction: &|i| partial.reaction(i) / effective_dt,
                    error_bound: Some(&error_bound(matrix, partial.residual_squared(), effective_dt)),
                };
                near && stops < MAX_EARLY_STOPS && contacts.can_stop_early(system, &trial)
            });
            report.solve_seconds += start.elapsed().as_secs_f64();
            self.interrupts.check()?;
            if solved.needs_f64 {
                let start = Instant::now();
                assemble(step, system, matrix, iteration.scales(false))?;
                report.assembly_seconds += start.elapsed().as_secs_f64();
                add_tools(matrix, step.loads, effective_dt);
                let v = &system.nodes.v;
                let momentum = iteration.at_current_state().then_some(Momentum { v, product: &mut self.momentum });
                self.pcg.load(pool, matrix, momentum);
                same_matrix = false;
                continue;
            }
            same_matrix = true;
            if !solved.residual.is_finite() {
                let error = self.diverged(system, matrix);
                system.nodes.x.copy_from_slice(&self.from[0]);
                return Err(error);
            }
            report.iterations += solved.iterations;
            if solved.stopped_at.is_some() {
                stops += 1;
            } else {
                pass += 1;
                report.residual = report.residual.max(solved.residual);
                report.converged &= solved.converged;
            }
            self.reaction.fill(Vec3::zeros());
            if !near && self.pcg.constrained().next().is_none() {
                break;
            }
            let (b, change) = (&self.b, &self.pcg.x);
            for (i, product) in self.pcg.constrained() {
                self.reaction[i] = (product - b[i]) / effective_dt;
            }
            let bound = error_bound(matrix, solved.stopped_at.unwrap_or(0.0), effective_dt);
            let (from, reaction) = (&self.from[0], &self.reaction);
            let trial = TrialStep {
                start: &|_, i| from[i],
                velocity: &|s, i| s.nodes.v[i] + change[i],
                reaction: &|i| reaction[i],
                error_bound: solved.stopped_at.map(|_| &bound as &ErrorBound<'_>),
            };
            if !step.contacts.update_active_set(system, &trial) && solved.stopped_at.is_none() {
                break;
            }
        }
        Ok(residual_norm)
    }

    /// Moves nodes to the predicted positions of the stage, `X + effective_dt v`.
    fn predict(&self, nodes: &mut Nodes, coefficients: &ImplicitCoefficients) {
        for (i, (x_new, v)) in nodes.x.iter_mut().zip(&nodes.v).enumerate() {
            *x_new = coefficients.extrapolate(self.from[0][i], self.before[0][i]) + coefficients.effective_dt * *v;
        }
    }

    /// Computes the right-hand side b and the prescribed velocity changes z for the present active set. Returns `|S b|^2`, N^2 s^2.
    fn right_side(&mut self, nodes: &Nodes, step: &Substep<'_>, iteration: &Iteration<'_>) -> f64 {
        let (coefficients, dt) = (iteration.coefficients, step.time.dt);
        let (mut b, mut z) = (std::mem::take(&mut self.b), std::mem::take(&mut self.z));
        z.fill(Vec3::zeros());
        step.contacts.add_forces(&mut z);
        let start = match iteration.at_current_state() {
            true => Start::Current { momentum: &self.momentum },
            false => {
                Start::Predicted { velocity: &self.from[1], before: &self.before[1], history: coefficients.history }
            }
        };
        let (force, gravity, effective_dt) = (&self.force[..], step.loads.gravity, coefficients.effective_dt);
        let squares = step.pool.fold((&mut b[..], &mut z[..]), &|first, (b, z)| {
            let prescribed = |i: usize| self.prescribed(i, nodes.prescribed[i], coefficients, dt);
            vector_unit().dispatch(RightSide { nodes, force, gravity, effective_dt, start, prescribed, first, b, z })
        });
        (self.b, self.z) = (b, z);
        squares
    }

    /// Attributes a system without a finite solution to the material if its forces or stiffness are not finite, and to the solver otherwise.
    fn diverged(&self, system: &System, matrix: &Matrix) -> StepError {
        let is_stiff = |i: usize| matrix.diagonal(i).iter().all(|k| k.is_finite());
        let node = (0..self.b.len()).find(|i| !is_finite(self.b[*i]) || !is_stiff(*i)).unwrap_or(0);
        if is_stiff(node) { StepError::Diverged { node } } else { system.material.not_finite("tangent", node).into() }
    }

    /// Stage velocity, m/s, with which node `i` moves by `dt p` over the step, for a prescribed velocity `p` (m/s).
    fn prescribed(&self, i: usize, p: Vec3, coefficients: &ImplicitCoefficients, dt: f64) -> Vec3 {
        if coefficients.history == 0.0 {
            return p;
        }
        let x = self.from[0][i];
        (x + dt * p - coefficients.extrapolate(x, self.before[0][i])) / coefficients.effective_dt
    }
}

/// Kinetic and elastic energy of the present state, J.
///
/// # Errors
/// Returns the error of the material.
pub(super) fn energy(system: &mut System, step: &Substep<'_>) -> Result<f64, ForceError> {
    Ok(system.nodes.kinetic_energy() + system.energy(step.time)?)
}

/// Adds the stiffness and damping of the tools to the matrix of a step with this effective step size (s).
pub(super) fn add_tools(matrix: &mut Matrix, loads: &Loads<'_>, effective_dt: f64) {
    for springs in loads.tools {
        matrix.add_diagonal(springs, TangentScale { stiffness: effective_dt * effective_dt, damping: effective_dt });
    }
}

/// Takes the matrix out of `system` and assembles it for the present state; the caller puts it back.
///
/// # Errors
/// Returns the error of the material and puts the matrix back.
pub(super) fn assemble_taken(
    step: &Substep<'_>,
    system: &mut System,
    scales: SystemScales,
) -> Result<Matrix, ForceError> {
    let mut matrix = system.matrix.take().unwrap_or_default();
    match assemble(step, system, &mut matrix, scales) {
        Ok(()) => Ok(matrix),
        Err(error) => {
            system.matrix = Some(matrix);
            Err(error)
        }
    }
}

/// Assembles a matrix of `system` for the present state.
///
/// # Errors
/// Returns the error of the material.
fn assemble(
    step: &Substep<'_>,
    system: &mut System,
    matrix: &mut Matrix,
    scales: SystemScales,
) -> Result<(), ForceError> {
    let (state, coupled) = system.assembly_parts(step.time);
    matrix.assemble(step.pool, state, coupled, scales)?;
    if let Some(normals) = &system.normals {
        matrix.add_normals(step.pool, normals, &system.sets, &system.nodes, scales);
    }
    Ok(())
}
