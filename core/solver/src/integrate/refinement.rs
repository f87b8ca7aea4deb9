//! Explicit steps that are divided further.
//!
//! Substeps are chosen by the frequencies of a body at rest. A body that is crushed or stretched may have higher ones: the damping of a stretched
//! solid grows with the square of its stretch. Then the fastest modes grow from substep to substep, until a state is not finite. So a step that would
//! gain energy, or ends not finite, is taken again with twice as many substeps, and the following ones have as many, until enough of them were calm.
//! With [`Integrator::max_substeps`] a step that gains energy stands.

use super::energy_guard::work;
use super::implicit::energy;
use super::{Integrator, StepError, StepReport, Substep};
use crate::force_model::ForceError;
use crate::system::System;

/// Steps without a gain after which substeps are doubled in length again.
const CALM_STEPS: u32 = 64;

/// How much further steps are divided now.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Refinement {
    /// How often substeps are halved.
    halvings: u32,
    /// Steps since `halvings` has changed.
    calm: u32,
    /// Work of the forces of contacts and fixings in this step, J.
    pub contact_work: f64,
}

impl Refinement {
    /// Number of substeps for `planned` ones, `most` at most unless more are planned.
    fn substeps(&self, planned: usize, most: usize) -> usize {
        (planned << self.halvings).min(most.max(planned))
    }

    /// Halves the substeps, up to `most` of them. Returns whether it did.
    fn halve(&mut self, planned: usize, most: usize) -> bool {
        let allowed = (planned << self.halvings).saturating_mul(2) <= most;
        if allowed {
            (self.halvings, self.calm) = (self.halvings + 1, 0);
        }
        allowed
    }

    /// Counts a step that stands.
    fn count_calm_step(&mut self) {
        self.calm += 1;
        if self.calm >= CALM_STEPS {
            (self.halvings, self.calm) = (self.halvings.saturating_sub(1), 0);
        }
    }
}

impl Integrator {
    /// Takes an explicit step in `planned` substeps, or in more if it would gain energy or end not finite.
    ///
    /// # Errors
    /// Those of [`Integrator::step_with_contacts`].
    pub(super) fn refined_step(
        &mut self,
        system: &mut System,
        step: &mut Substep<'_>,
        planned: usize,
    ) -> Result<StepReport, StepError> {
        self.keep_start(system);
        let (before, mut repeated_steps, mut first_error) = (self.refinement, 0, None);
        loop {
            system.keep_history();
            self.refinement.contact_work = 0.0;
            let stepped = self.substeps(system, step, self.refinement.substeps(planned, self.max_substeps), true);
            let stands = match &stepped {
                Ok(report) => match self.admits_substeps(system, step, report.max_speed) {
                    Ok(stands) => stands,
                    Err(error) => {
                        self.return_to_start(system);
                        step.contacts.take_back(system);
                        return Err(error.into());
                    }
                },
                Err(StepError::Cancelled | StepError::TimedOut) => {
                    self.refinement = before;
                    return stepped;
                }
                Err(StepError::Diverged { .. } | StepError::Force(_)) => false,
            };
            if stands {
                self.refinement.count_calm_step();
            } else if self.refinement.halve(planned, self.max_substeps) {
                repeated_steps += 1;
                // A plugin that has panicked gives its message once.
                match stepped {
                    Ok(_) => {
                        self.return_to_start(system);
                        step.contacts.take_back(system);
                    }
                    Err(error) => _ = first_error.get_or_insert(error),
                }
                continue;
            }
            return match stepped {
                Ok(report) => Ok(StepReport { repeated_steps, ..report }),
                Err(error) => Err(first_error.unwrap_or(error)),
            };
        }
    }

    /// Whether the step from `self.start` to the present state, whose fastest node moves at `fastest` (m/s), may stand. An energy that is not to be had
    /// at its end counts as a gain.
    ///
    /// # Errors
    /// Returns the error of the material at its start.
    fn admits_substeps(&mut self, system: &mut System, step: &Substep<'_>, fastest: f64) -> Result<bool, ForceError> {
        if fastest < self.guarded_speed {
            return Ok(true);
        }
        let [x, v] = &self.start;
        let work = work(step.loads, &system.nodes, &[], [x, v]) + self.refinement.contact_work;
        let Ok(after) = energy(system, step) else { return Ok(false) };
        self.swap_with_start(system);
        let before = energy(system, step);
        self.swap_with_start(system);
        Ok(self.energy_guard.admit(before?, after, work))
    }

    fn swap_with_start(&mut self, system: &mut System) {
        let [x, v] = &mut self.start;
        std::mem::swap(&mut system.nodes.x, x);
        std::mem::swap(&mut system.nodes.v, v);
        system.swap_history();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn substeps_double_up_to_the_limit_and_come_back_when_steps_are_calm() {
        let mut refinement = Refinement::default();
        assert!(refinement.halve(3, 12) && refinement.halve(3, 12) && !refinement.halve(3, 12));
        assert_eq!(refinement.substeps(3, 12), 12);
        assert_eq!(
            [refinement.substeps(4, 12), refinement.substeps(20, 12)],
            [12, 20],
            "a stiff contact asks for more"
        );
        (0..CALM_STEPS - 1).for_each(|_| refinement.count_calm_step());
        assert_eq!(refinement.substeps(3, 12), 12);
        refinement.count_calm_step();
        assert_eq!(refinement.substeps(3, 12), 6);
        (0..10 * CALM_STEPS).for_each(|_| refinement.count_calm_step());
        assert_eq!(refinement.substeps(3, 12), 3);
    }
}
