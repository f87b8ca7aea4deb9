//! Contacts as the integrator sees them: constraints on nodes whose active set may change within a step.

use crate::algebra::Vec3;
use crate::system::System;

/// Most times the active set is updated after a full solve within one step.
pub const MAX_ACTIVE_SET_PASSES: usize = 4;

/// Contacts that constrain nodes during a step and release them again, such as a sphere that touches a sheet.
///
/// A step calls [`begin`](Self::begin), then [`update_active_set`](Self::update_active_set) after each solve until nothing changes, then
/// [`end`](Self::end).
pub trait ContactConstraints {
    /// Finds candidates and constrains nodes, at the positions before the step. `dt` (s) is how long the step's velocities last.
    fn begin(&mut self, system: &mut System, dt: f64);
    /// Adds the contact forces that are no constraints, such as friction, N, to `force` (n x 3).
    fn add_forces(&self, force: &mut [Vec3]);
    /// Constrains and releases nodes according to a trial step. Returns whether the active set or a force changed. Of a trial step with an
    /// error bound only changes that are certain within the bound are made.
    fn update_active_set(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool;
    /// Whether a partial solution already makes certain everything [`update_active_set`](Self::update_active_set) would change, and that it
    /// would change something: then the solve is stopped and begun again with the new active set.
    fn can_stop_early(&self, _: &System, _: &TrialStep<'_>) -> bool {
        false
    }
    /// Whether any node may come into contact in this step. Without candidates a step skips all contact work.
    fn has_candidates(&self) -> bool;
    /// Whether any node is constrained.
    fn is_active(&self) -> bool;
    /// Releases all nodes. Adds to `reaction`, the constraint forces of the step, N (n x 3), the forces of
    /// [`add_forces`](Self::add_forces).
    fn end(&mut self, system: &mut System, reaction: &mut [Vec3]);
}

/// Velocities and constraint forces that a step would end with under the present active set.
pub struct TrialStep<'a> {
    /// Velocity of a node after the step, m/s.
    pub velocity: &'a dyn Fn(&System, usize) -> Vec3,
    /// Constraint force on a node, N.
    pub reaction: &'a dyn Fn(usize) -> Vec3,
    /// How far both may be from the solution; `None` for a solve that met its tolerance.
    pub error_bound: Option<&'a ErrorBound<'a>>,
}

/// Bounds for a node along a unit vector: of the error of its constraint force, N, and of its velocity, m/s.
pub type ErrorBound<'a> = dyn Fn(&System, usize, Vec3) -> [f64; 2] + 'a;

/// No contacts: nothing is constrained.
pub struct NoContacts;

impl ContactConstraints for NoContacts {
    fn begin(&mut self, _: &mut System, _: f64) {}

    fn add_forces(&self, _: &mut [Vec3]) {}

    fn update_active_set(&mut self, _: &mut System, _: &TrialStep<'_>) -> bool {
        false
    }

    fn has_candidates(&self) -> bool {
        false
    }

    fn is_active(&self) -> bool {
        false
    }

    fn end(&mut self, _: &mut System, _: &mut [Vec3]) {}
}
