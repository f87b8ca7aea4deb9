//! Explicit steps: new velocities from the forces where the body is.

use super::holds::{Holds, Outcome, PASSES};
use super::{Integrator, Loads, Scheme, StepError, StepReport, add_loads, check};
use crate::algebra::{Vec3, without_dust};
use crate::force_model::StepTime;
use crate::system::System;
use crate::threads::{NODES, Pool};

impl Integrator {
    pub(super) fn explicit(
        &mut self,
        pool: &Pool,
        system: &mut System,
        (loads, holds): (&Loads<'_>, &mut dyn Holds),
        now: StepTime,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        system.forces(pool, None, now, &mut self.force)?;
        add_loads(&mut self.force, loads, &system.nodes.x, Some(&system.nodes.v));
        holds.begin(system, now.dt);
        let dt = now.dt;
        if self.scheme == Scheme::ExplicitEuler {
            go_on(pool, system, dt);
        }
        for _ in 0..PASSES {
            // Nothing is near most of the time: then there are no forces to clear and to add.
            let pushes = holds.is_near();
            if pushes {
                self.still.fill(Vec3::zeros());
                holds.add_forces(&mut self.still);
            }
            let (nodes, force, gravity) = (&system.nodes, &self.force, loads.gravity);
            let parts = (&mut self.still[..], &mut self.reaction[..]);
            pool.pieces(parts, NODES, &|first, (still, reaction): (&mut [Vec3], &mut [Vec3])| {
                for (i, (still, reaction)) in (first..).zip(still.iter_mut().zip(reaction)) {
                    let f = if pushes { force[i] + *still } else { force[i] };
                    let free = nodes.v[i] + dt * (gravity + 1.0 / nodes.mass[i] * f);
                    if nodes.constraint[i].is_free() {
                        (*still, *reaction) = (without_dust(free), Vec3::zeros());
                        continue;
                    }
                    *still = without_dust(nodes.constraint[i].merge(free, nodes.prescribed[i]));
                    *reaction = (*still - free) * nodes.mass[i] / dt;
                }
            });
            let (still, reaction) = (&self.still, &self.reaction);
            let outcome = Outcome { after: &|_, i| still[i], reaction: &|i| reaction[i], doubt: None };
            if !holds.revise(system, &outcome) {
                break;
            }
        }
        std::mem::swap(&mut system.nodes.v, &mut self.still);
        report.fastest = check(system)?;
        if self.scheme != Scheme::ExplicitEuler {
            go_on(pool, system, dt);
        }
        holds.end(system, &mut self.reaction);
        Ok(())
    }
}

/// `x += dt v`
fn go_on(pool: &Pool, system: &mut System, dt: f64) {
    let v = &system.nodes.v;
    pool.pieces(&mut system.nodes.x[..], NODES, &|first, x: &mut [Vec3]| {
        for (x, v) in x.iter_mut().zip(&v[first..]) {
            *x += dt * *v;
        }
    });
}
