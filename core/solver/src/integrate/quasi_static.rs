//! Quasi-static step: static equilibrium without inertia.
//!
//! Newton's method with Levenberg (1944) damping, a multiple of the mass matrix that decreases while iterations succeed, and a backtracking line
//! search on the potential energy.

use super::implicit::assemble_taken;
use super::{Integrator, Loads, StepError, StepReport, Substep, add_loads, check};
use crate::algebra::Vec3;
use crate::constraint::Constraint;
use crate::force_model::StepTime;
use crate::solver::filtered_system::FilteredSystem;
use crate::system::System;
use crate::system_scales::{HessianApproximation, SystemScales};
use pliant_plugin_api::TangentScale;
use std::time::Instant;

/// Levenberg damping at the start, 1/s^2.
const INITIAL_DAMPING: f64 = 1e3;
/// Largest damping, 1/s^2. If even this step does not decrease the energy, the search ends.
const MAX_DAMPING: f64 = 1e12;
/// Smallest damping, 1/s^2.
const MIN_DAMPING: f64 = 1e-6;
/// Residual, in tolerances, up to which a state that no step improves counts as converged: the rest is rounding.
const STALLED_TOLERANCES: f64 = 1e3;
/// Relative rounding error of the energy, by cancellation in small strains.
const ENERGY_ROUNDING: f64 = 1e-9;
/// Largest number of halvings of a step in the line search.
const MAX_HALVINGS: usize = 12;

/// Result of one Newton solve.
struct NewtonSolve {
    /// Largest unbalanced force on a node, N.
    unbalanced: f64,
    /// Largest force on a node, constrained or not, N: the reference of the convergence test.
    scale: f64,
    /// Whether the matrix was positive definite along the solve.
    is_definite: bool,
    /// Whether the linear solve has met its tolerance, or found forces that are rounding alone.
    has_converged: bool,
}

impl Integrator {
    /// Moves the nodes to static equilibrium.
    pub(super) fn settle(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let dt = step.time.dt;
        let start = system.nodes.x.clone();
        let velocities = system.nodes.v.clone();
        let settled = self.search_for_equilibrium(system, step, report);
        if settled.is_err() {
            system.nodes.x.copy_from_slice(&start);
            system.nodes.v.copy_from_slice(&velocities);
        }
        report.converged &= settled?;
        let nodes = &mut system.nodes;
        for i in 0..start.len() {
            nodes.v[i] = (nodes.x[i] - start[i]) / dt;
        }
        report.max_speed = check(system).inspect_err(|_| system.nodes.x.copy_from_slice(&start))?;
        step.contacts.end(system, &mut self.reaction);
        system.nodes.v.fill(Vec3::zeros());
        Ok(())
    }

    /// Newton's method from the present positions. Returns whether it has found an equilibrium.
    fn search_for_equilibrium(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        report: &mut StepReport,
    ) -> Result<bool, StepError> {
        let (loads, now, dt) = (step.loads, step.time, step.time.dt);
        step.contacts.begin(system, dt);
        let nodes = &mut system.nodes;
        for i in 0..nodes.x.len() {
            // Nodes with prescribed motion move first.
            if nodes.constraint[i] == Constraint::Fixed {
                nodes.x[i] += dt * nodes.prescribed[i];
            }
        }
        let mut damping = INITIAL_DAMPING;
        let mut scale = 0.0_f64;
        let mut energy = self.potential(system, loads, now)?;
        let mut settled = false;
        for _ in 0..self.max_newton {
            let solve = self.solve_for_equilibrium(system, step, damping, report)?;
            scale = scale.max(solve.scale);
            let longest = self.pcg.x.iter().map(|d| d.norm_squared()).fold(0.0, f64::max).sqrt();
            // Where all forces are rounding they are no measure of each other, and move no node by its last digit.
            let is_at_rest = solve.has_converged && longest == 0.0;
            if solve.unbalanced <= self.newton_tolerance * scale || is_at_rest || !solve.is_definite {
                settled = solve.is_definite;
                break;
            }
            report.newton_iterations += 1;
            let mut fraction = if longest > self.max_displacement { self.max_displacement / longest } else { 1.0 };
            let from = system.nodes.x.clone();
            // Work of the forces along the step. If it is below the rounding error of the energy, an increase of the energy is no reason to reject.
            let work: f64 = self.b.iter().zip(&self.pcg.x).map(|(f, d)| f.dot(d)).sum();
            let noise = if work < ENERGY_ROUNDING * energy.abs() { ENERGY_ROUNDING } else { 1e-12 } * energy.abs();
            let mut accepted = false;
            for _ in 0..MAX_HALVINGS {
                self.interrupts.check()?;
                for i in 0..from.len() {
                    system.nodes.x[i] = from[i] + fraction * self.pcg.x[i];
                }
                let after = self.potential(system, loads, now)?;
                if after <= energy + noise {
                    (energy, accepted) = (after, true);
                    break;
                }
                fraction *= 0.5;
            }
            damping =
                if accepted && fraction == 1.0 { damping / 4.0 } else { damping * 4.0 }.clamp(MIN_DAMPING, MAX_DAMPING);
            if !accepted {
                system.nodes.x.copy_from_slice(&from);
                if damping >= MAX_DAMPING || longest <= 1e-12 {
                    // Rounding may leave more than the tolerance, but not much more.
                    settled = solve.unbalanced <= STALLED_TOLERANCES * self.newton_tolerance * scale;
                    break;
                }
            }
        }
        Ok(settled)
    }

    /// Solves for the next displacement, m (n x 3), which is left in `self.pcg.x`.
    fn solve_for_equilibrium(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        damping: f64,
        report: &mut StepReport,
    ) -> Result<NewtonSolve, StepError> {
        let (pool, loads) = (step.pool, step.loads);
        system.nodes.v.fill(Vec3::zeros());
        let scales = SystemScales {
            mass: damping,
            stiffness: 1.0,
            damping: 0.0,
            hessian: HessianApproximation::Unbounded,
            strains_are_current: true,
            allow_f32: false,
        };
        let began = Instant::now();
        system.forces(pool, None, step.time, &mut self.force)?;
        let mut matrix = assemble_taken(step, system, scales)?;
        report.assembly_seconds += began.elapsed().as_secs_f64();
        for springs in loads.tools {
            matrix.add_diagonal(springs, TangentScale { stiffness: 1.0, damping: 0.0 });
        }
        add_loads(&mut self.force, loads, &system.nodes.x, None);
        step.contacts.add_forces(&mut self.force);
        let nodes = &system.nodes;
        let (mut left, mut all) = (0.0_f64, 0.0_f64);
        for i in 0..nodes.len() {
            self.b[i] = self.force[i] + nodes.mass[i] * loads.gravity;
            let free = nodes.constraint[i].filter(self.b[i]);
            left = left.max(free.norm_squared());
            all = all.max(self.b[i].norm_squared()).max((nodes.mass[i] * loads.gravity.norm()).powi(2));
            self.reaction[i] = free - self.b[i];
            self.z[i] = Vec3::zeros();
        }
        self.pcg.forget();
        self.pcg.prepare(&matrix, &system.sets, &system.nodes.rest);
        self.pcg.guess(pool, &matrix, None);
        let solve = FilteredSystem {
            matrix: &matrix,
            b: &self.b,
            z: &self.z,
            constraints: &nodes.constraint,
            positions: &nodes.x,
            displacement_per_unit: 1.0,
            same_matrix: false,
            tolerance: self.tolerance,
            max_iterations: self.max_iterations,
            interrupts: Some(&self.interrupts),
        };
        let began = Instant::now();
        let solved = self.pcg.solve(pool, &solve);
        report.solve_seconds += began.elapsed().as_secs_f64();
        system.matrix = Some(matrix);
        self.interrupts.check()?;
        report.iterations += solved.iterations;
        report.residual = solved.residual;
        Ok(NewtonSolve {
            unbalanced: left.sqrt(),
            scale: all.sqrt(),
            is_definite: !solved.broken,
            has_converged: solved.converged,
        })
    }

    /// Potential energy of body and loads, J.
    fn potential(&mut self, system: &mut System, loads: &Loads<'_>, now: StepTime) -> Result<f64, StepError> {
        let mut energy = system.energy(now)?;
        for (x, mass) in system.nodes.x.iter().zip(&system.nodes.mass) {
            energy -= mass * loads.gravity.dot(x);
        }
        for (x, f) in system.nodes.x.iter().zip(loads.forces) {
            energy -= f.dot(x);
        }
        Ok(energy + loads.tools.iter().map(|springs| springs.potential(&system.nodes.x)).sum::<f64>())
    }
}
