//! Equilibrium: a step without inertia.
//!
//! Newton's method on the forces, damped as Levenberg (1944) does it by a share of the masses that falls while it goes well,
//! and held back until the potential energy does not rise.

use super::holds::Holds;
use super::implicit::linearise;
use super::{Integrator, Loads, StepError, StepReport, add_loads, check};
use crate::algebra::Vec3;
use crate::constraint::Constraint;
use crate::factors::{Factors, StandIn};
use crate::force_model::StepTime;
use crate::solver::solve::Solve;
use crate::system::System;
use crate::threads::Pool;
use pliant_plugin_api::TangentScale;
use std::time::Instant;

/// Damping at the start, 1/s^2, the largest before it gives up, and the least.
const DAMPING: [f64; 3] = [1e3, 1e12, 1e-6];
/// Tolerances that may be left where no step lowers the energy any more.
const STUCK: f64 = 1e3;
/// Of the energy, what rounding in strains may leave of it.
const ROUNDED: f64 = 1e-9;
/// Halvings of a step, at most.
const HALVINGS: usize = 12;

impl Integrator {
    /// Moves the nodes to equilibrium. Velocities are what it took over `dt`.
    pub(super) fn settle(
        &mut self,
        pool: &Pool,
        system: &mut System,
        (loads, holds): (&Loads<'_>, &mut dyn Holds),
        now: StepTime,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let dt = now.dt;
        let start = system.nodes.x.clone();
        holds.begin(system, dt);
        for i in 0..start.len() {
            // What is led goes first.
            if system.nodes.constraint[i] == Constraint::Fixed {
                system.nodes.x[i] = start[i] + dt * system.nodes.prescribed[i];
            }
        }
        let mut damping = DAMPING[0];
        let mut scale = 0.0_f64;
        let mut energy = self.potential(system, loads, now)?;
        let mut settled = false;
        for _ in 0..self.newton {
            let (largest, solved) = self.push(pool, system, (loads, &mut *holds), now, damping, report)?;
            scale = scale.max(largest.1);
            if largest.0 <= self.newton_tolerance * scale || !solved {
                settled = solved;
                break;
            }
            report.newton += 1;
            let longest = self.pcg.x.iter().map(|d| d.norm_squared()).fold(0.0, f64::max).sqrt();
            let mut share = if longest > self.longest_move { self.longest_move / longest } else { 1.0 };
            let from = system.nodes.x.clone();
            // What the forces do on the way. Less than rounding leaves of the energy, the energy cannot judge it.
            let work: f64 = self.b.iter().zip(&self.pcg.x).map(|(f, d)| f.dot(d)).sum();
            let noise = if work < ROUNDED * energy.abs() { ROUNDED } else { 1e-12 } * energy.abs();
            let mut went = false;
            for _ in 0..HALVINGS {
                for i in 0..from.len() {
                    system.nodes.x[i] = from[i] + share * self.pcg.x[i];
                }
                let after = self.potential(system, loads, now)?;
                if after <= energy + noise {
                    (energy, went) = (after, true);
                    break;
                }
                share *= 0.5;
            }
            damping = if went && share == 1.0 { damping / 4.0 } else { damping * 4.0 }.clamp(DAMPING[2], DAMPING[1]);
            if !went {
                system.nodes.x.copy_from_slice(&from);
                if damping >= DAMPING[1] || longest <= 1e-12 {
                    // Rounding may leave more than was asked for; much more is no equilibrium.
                    settled = largest.0 <= STUCK * self.newton_tolerance * scale;
                    break;
                }
            }
        }
        report.converged &= settled;
        let nodes = &mut system.nodes;
        for i in 0..start.len() {
            nodes.v[i] = (nodes.x[i] - start[i]) / dt;
        }
        report.fastest = check(system).inspect_err(|_| system.nodes.x.copy_from_slice(&start))?;
        holds.end(system, &mut self.reaction);
        system.nodes.v.fill(Vec3::zeros());
        Ok(())
    }

    /// Solves for the next move. Gives the largest force that is left and the largest of all, N, and whether it worked.
    fn push(
        &mut self,
        pool: &Pool,
        system: &mut System,
        (loads, holds): (&Loads<'_>, &mut dyn Holds),
        now: StepTime,
        damping: f64,
        report: &mut StepReport,
    ) -> Result<((f64, f64), bool), StepError> {
        system.nodes.v.fill(Vec3::zeros());
        let factors = Factors {
            mass: damping,
            stiffness: 1.0,
            damping: 0.0,
            stand_in: StandIn::Searched,
            after_forces: true,
            rounded: false,
        };
        let began = Instant::now();
        let mut matrix = linearise(pool, system, (None, (&mut self.force, false)), factors, now)?;
        report.seconds[0] += began.elapsed().as_secs_f64();
        for springs in loads.tools {
            matrix.add_diagonal(springs, TangentScale { stiffness: 1.0, damping: 0.0 });
        }
        add_loads(&mut self.force, loads, &system.nodes.x, None);
        holds.add_forces(&mut self.force);
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
        let solve = Solve {
            matrix: &matrix,
            b: &self.b,
            z: &self.z,
            constraints: &nodes.constraint,
            motion: (&nodes.x, 1.0),
            again: false,
            tolerance: self.tolerance,
            most: self.most_iterations,
        };
        let began = Instant::now();
        let solved = self.pcg.solve(pool, &solve);
        report.seconds[1] += began.elapsed().as_secs_f64();
        system.matrix = Some(matrix);
        report.iterations += solved.iterations;
        report.residual = solved.residual;
        Ok(((left.sqrt(), all.sqrt()), !solved.broken))
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
