//! Explicit steps: the new velocities follow from the forces of the present state.

use super::contact_constraints::{MAX_ACTIVE_SET_PASSES, TrialStep};
use super::scheme::ExplicitOrder;
use super::{Integrator, StepError, StepReport, Substep, add_loads, check};
use crate::algebra::{Vec3, flush_denormals};
use crate::system::System;
use crate::threads::{NODES, Pool};

impl Integrator {
    /// Takes an explicit step.
    ///
    /// # Errors
    /// Returns the error of the material, or [`StepError::Diverged`].
    pub(super) fn explicit(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        order: ExplicitOrder,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let (pool, loads, dt) = (step.pool, step.loads, step.time.dt);
        system.forces(pool, None, step.time, &mut self.force)?;
        add_loads(&mut self.force, loads, &system.nodes.x, Some(&system.nodes.v));
        step.contacts.begin(system, dt);
        match order {
            ExplicitOrder::PositionFirst => move_nodes(pool, system, dt),
            ExplicitOrder::VelocityFirst => {}
        }
        let mut work = 0.0;
        for _ in 0..MAX_ACTIVE_SET_PASSES {
            // Without candidates there are no contact forces to clear and to add.
            let has_contacts = step.contacts.has_candidates();
            if has_contacts {
                self.scratch.fill(Vec3::zeros());
                step.contacts.add_forces(&mut self.scratch);
            }
            let (nodes, force, gravity) = (&system.nodes, &self.force, loads.gravity);
            let vectors = (&mut self.scratch[..], &mut self.reaction[..]);
            work = pool.fold(vectors, &|first, (scratch, reaction): (&mut [Vec3], &mut [Vec3])| {
                let mut work = 0.0;
                for (i, (next, reaction)) in (first..).zip(scratch.iter_mut().zip(reaction)) {
                    let of_contact = if has_contacts { *next } else { Vec3::zeros() };
                    let f = if has_contacts { force[i] + of_contact } else { force[i] };
                    let free = nodes.v[i] + dt * (gravity + 1.0 / nodes.mass[i] * f);
                    if nodes.constraint[i].is_free() {
                        (*next, *reaction) = (flush_denormals(free), Vec3::zeros());
                        if has_contacts {
                            work += of_contact.dot(next);
                        }
                        continue;
                    }
                    *next = flush_denormals(nodes.constraint[i].merge(free, nodes.prescribed[i]));
                    *reaction = (*next - free) * nodes.mass[i] / dt;
                    work += (of_contact + *reaction).dot(next);
                }
                work
            });
            let (next, reaction) = (&self.scratch, &self.reaction);
            let trial = TrialStep {
                start: &|s, i| s.nodes.x[i],
                velocity: &|_, i| next[i],
                reaction: &|i| reaction[i],
                error_bound: None,
            };
            if !step.contacts.update_active_set(system, &trial) {
                break;
            }
        }
        self.refinement.contact_work += dt * work;
        std::mem::swap(&mut system.nodes.v, &mut self.scratch);
        report.max_speed = check(system).inspect_err(|_| match order {
            ExplicitOrder::PositionFirst => {
                // The velocities before the step are here since the swap.
                system.nodes.x.iter_mut().zip(&self.scratch).for_each(|(x, v)| *x -= dt * *v);
            }
            ExplicitOrder::VelocityFirst => {}
        })?;
        match order {
            ExplicitOrder::PositionFirst => {}
            ExplicitOrder::VelocityFirst => move_nodes(pool, system, dt),
        }
        step.contacts.end(system, &mut self.reaction);
        Ok(())
    }
}

/// Updates positions: `x += dt v`, with `dt` in s.
fn move_nodes(pool: &Pool, system: &mut System, dt: f64) {
    let v = &system.nodes.v;
    pool.par_chunks(&mut system.nodes.x[..], NODES, &|first, x: &mut [Vec3]| {
        for (x, v) in x.iter_mut().zip(&v[first..]) {
            *x += dt * *v;
        }
    });
}
