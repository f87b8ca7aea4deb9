//! Contact of a body with fingertips and obstacles together.

use super::ObstacleContacts;
use crate::contact::SheetTips;
use pliant_solver::{ContactConstraints, System, TrialStep, Vec3};

/// The contacts of a body: with the fingertips on it and with obstacles. A vertex that a tip holds follows the tip as far as no obstacle is in the way.
pub struct BodyContacts<'a> {
    /// Fingertips on a sheet; none on a solid.
    pub tips: &'a mut SheetTips,
    /// Contacts of the body with obstacles.
    pub obstacles: &'a mut ObstacleContacts,
}

impl ContactConstraints for BodyContacts<'_> {
    fn begin(&mut self, system: &mut System, dt: f64) {
        self.obstacles.find_fixed(system);
        self.tips.begin(system, dt);
        self.obstacles.begin(system, dt);
    }

    fn add_forces(&self, force: &mut [Vec3]) {
        self.tips.add_forces(force);
        self.obstacles.add_forces(force);
    }

    fn update_active_set(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool {
        let tips = self.tips.update_active_set(system, trial);
        self.obstacles.update_active_set(system, trial) || tips
    }

    fn can_stop_early(&self, system: &System, trial: &TrialStep<'_>) -> bool {
        // With both, changes of the one could undo those of the other.
        !self.tips.is_active() && self.obstacles.can_stop_early(system, trial)
    }

    fn interrupts_history(&self) -> bool {
        self.tips.interrupts_history() || self.obstacles.interrupts_history()
    }

    fn begin_iteration(&mut self) {
        self.tips.begin_iteration();
    }

    fn max_passes(&self) -> usize {
        self.tips.max_passes()
    }

    fn has_candidates(&self) -> bool {
        self.tips.has_candidates() || self.obstacles.has_candidates()
    }

    fn is_active(&self) -> bool {
        self.tips.is_active() || self.obstacles.is_active()
    }

    fn keep_start(&mut self) {
        self.tips.keep_start();
        self.obstacles.keep_start();
    }

    fn take_back(&mut self, system: &mut System) {
        self.tips.take_back(system);
        self.obstacles.take_back(system);
    }

    fn end(&mut self, system: &mut System, reaction: &mut [Vec3]) {
        self.tips.end(system, reaction);
        self.obstacles.end(system, reaction);
    }
}
