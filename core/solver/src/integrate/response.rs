//! How a body answers impulses at the end of an implicit step: the velocity changes that its own system of the step gives them.
//!
//! A step of backward Euler solves `A dv = b` with `A = M + g C + g^2 K`. Impulses p that act during the step add to b, so by linearity they change
//! the velocities at its end by `A^-1 p`, and the sum is the step that has them as forces p / g. Contact between bodies, whose steps are
//! taken one by one, finds its impulses with these responses (Duriez, Dubois, Kheddar and Andriot 2006).

use super::implicit::{add_tools, assemble_taken};
use super::{Integrator, Loads, Substep};
use crate::algebra::Vec3;
use crate::constraint::Constraint;
use crate::force_model::{ForceError, StepTime};
use crate::interrupts::Interrupts;
use crate::solver::filtered_system::{FilteredSystem, SolveReport};
use crate::system::System;
use crate::system_scales::{HessianApproximation, SystemScales};
use crate::threads::Pool;

impl Integrator {
    /// Prepares [`Integrator::respond`] after the step of `time`. The matrix of the step is used again if it was that of one implicit step of this length
    /// in double precision; otherwise it is assembled anew at the positions before the last substep, with the springs of `loads`.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn begin_responses(
        &mut self,
        pool: &Pool,
        system: &mut System,
        loads: &Loads<'_>,
        time: StepTime,
    ) -> Result<(), ForceError> {
        let is_of_step = self.matrix_step == time.dt && system.matrix.as_ref().is_some_and(|matrix| !matrix.is_f32());
        if !is_of_step {
            self.assemble_of_step(pool, system, loads, time)?;
        }
        self.has_springs = loads.tools.iter().any(|springs| !springs.is_empty());
        for field in [&mut self.z, &mut self.b] {
            field.fill(Vec3::zeros());
        }
        // The solution of the step is put aside, for the next guess is extrapolated from it.
        self.momentum.copy_from_slice(&self.pcg.x);
        self.pcg.begin_responses();
        Ok(())
    }

    /// Assembles the matrix of a step of backward Euler and loads it into the solver.
    fn assemble_of_step(
        &mut self,
        pool: &Pool,
        system: &mut System,
        loads: &Loads<'_>,
        time: StepTime,
    ) -> Result<(), ForceError> {
        let scales = SystemScales {
            mass: 1.0,
            stiffness: time.dt * time.dt,
            damping: time.dt,
            hessian: HessianApproximation::AtLeastHalf,
            strains_are_current: false,
            allow_f32: false,
        };
        let swap = |system: &mut System, [x, v]: &mut [Vec<Vec3>; 2]| {
            std::mem::swap(&mut system.nodes.x, x);
            std::mem::swap(&mut system.nodes.v, v);
        };
        let mut nothing = super::contact_constraints::NoContacts;
        let step = Substep { pool, loads, contacts: &mut nothing, time };
        // `before` is the start of the last substep: steps swap it with `from` at their end.
        swap(system, &mut self.before);
        let assembled = assemble_taken(&step, system, scales);
        swap(system, &mut self.before);
        let mut matrix = assembled?;
        add_tools(&mut matrix, loads, time.dt);
        self.matrix_step = time.dt;
        self.pcg.prepare(&matrix, &system.sets, &system.nodes.rest);
        self.pcg.load(pool, &matrix, None);
        self.needs_update = true;
        system.matrix = Some(matrix);
        Ok(())
    }

    /// Solves `S A dv = S p` for impulses p (N s, n x 3) on a body whose nodes have these `constraints` S, starting from the response before.
    /// The result is [`Integrator::response`], to `tolerance` relative to p in the norm of the preconditioner. Of a body without constraints and springs
    /// the momentum of the response is that of p to rounding, whatever the tolerance is.
    pub fn respond(
        &mut self,
        pool: &Pool,
        system: &System,
        constraints: &[Constraint],
        impulses: &[Vec3],
        tolerance: f64,
    ) -> SolveReport {
        let Some(matrix) = &system.matrix else { return SolveReport::default() };
        // The deadline was that of the body's own step.
        let interrupts = Interrupts { cancel: self.interrupts.cancel.clone(), deadline: None };
        self.b.copy_from_slice(impulses);
        let filtered = FilteredSystem {
            matrix,
            b: &self.b,
            z: &self.z,
            constraints,
            positions: &system.nodes.x,
            displacement_per_unit: self.matrix_step,
            same_matrix: !std::mem::take(&mut self.needs_update),
            tolerance,
            max_iterations: self.max_iterations,
            interrupts: Some(&interrupts),
        };
        let report = self.pcg.solve(pool, &filtered);
        if !self.has_springs && self.pcg.constrained().next().is_none() {
            let (mass, x) = (&system.nodes.mass, &self.pcg.x);
            let lost: Vec3 = impulses.iter().zip(mass).zip(x).map(|((p, m), v)| p - *m * v).sum();
            self.pcg.add_uniform(mass, lost / mass.iter().sum::<f64>());
        }
        report
    }

    /// Velocity changes of the last [`Integrator::respond`], m/s (n x 3).
    pub fn response(&self) -> &[Vec3] {
        &self.pcg.x
    }

    /// Adds the forces of constraints under the last impulses to `reaction`. The next guess of the solver is the one that it was without responses.
    pub fn end_responses(&mut self) {
        for (i, product) in self.pcg.constrained() {
            self.reaction[i] += (product - self.b[i]) / self.matrix_step;
        }
        self.pcg.x.copy_from_slice(&self.momentum);
    }
}
