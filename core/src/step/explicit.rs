//! Explicit steps: new velocities from the forces where the body is.

use super::holds::{Holds, Outcome, PASSES};
use super::integrate::{Integrator, Loads, Scheme, StepError, StepReport, add_loads, check};
use super::pool::Pool;
use super::system::System;
use super::{axpy, without_dust};

impl Integrator {
    pub(super) fn explicit(
        &mut self,
        pool: &Pool,
        system: &mut System,
        (loads, holds): (&Loads<'_>, &mut dyn Holds),
        now: (f64, f64),
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        system.forces(pool, None, now, &mut self.force)?;
        add_loads(&mut self.force, loads, &system.nodes.x, Some(&system.nodes.v));
        holds.begin(system, now.1);
        let dt = now.1;
        if self.scheme == Scheme::ExplicitEuler {
            for (x, v) in system.nodes.x.iter_mut().zip(&system.nodes.v) {
                *x = axpy(*x, dt, *v);
            }
        }
        for _ in 0..PASSES {
            self.still.clear();
            self.still.resize(self.force.len(), [0.0; 3]);
            holds.add_forces(&mut self.still);
            let nodes = &system.nodes;
            for i in 0..nodes.len() {
                let a = axpy(loads.gravity, 1.0 / nodes.mass[i], axpy(self.force[i], 1.0, self.still[i]));
                let free = axpy(nodes.v[i], dt, a);
                let held = without_dust(nodes.constraint[i].merge(free, nodes.prescribed[i]));
                self.reaction[i] = axpy(held, -1.0, free).map(|c| c * nodes.mass[i] / dt);
                self.still[i] = held;
            }
            let (still, reaction) = (&self.still, &self.reaction);
            let outcome = Outcome { after: &|_, i| still[i], reaction: &|i| reaction[i], doubt: None };
            if !holds.revise(system, &outcome) {
                break;
            }
        }
        std::mem::swap(&mut system.nodes.v, &mut self.still);
        report.fastest = check(system)?;
        if self.scheme != Scheme::ExplicitEuler {
            for (x, v) in system.nodes.x.iter_mut().zip(&system.nodes.v) {
                *x = axpy(*x, dt, *v);
            }
        }
        holds.end(system, &mut self.reaction);
        Ok(())
    }
}
