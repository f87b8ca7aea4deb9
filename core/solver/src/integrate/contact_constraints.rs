//! Interface between the integrator and contacts: constraints on nodes whose active set may change within a step.

use crate::algebra::Vec3;
use crate::system::System;

/// Largest number of full solves, each followed by an update of the active set, in an explicit step, and in one Newton iteration unless
/// contacts ask for more ([`ContactConstraints::max_passes`]).
pub const MAX_ACTIVE_SET_PASSES: usize = 4;

/// Contacts that constrain nodes for the duration of a step, such as a sphere touching a sheet.
///
/// A step calls [`begin`](Self::begin), then [`update_active_set`](Self::update_active_set) after each solve until nothing changes, then
/// [`end`](Self::end).
pub trait ContactConstraints {
    /// Finds candidates and constrains nodes at the positions before a step of `dt` (s).
    fn begin(&mut self, system: &mut System, dt: f64);
    /// Adds contact forces other than constraint forces, such as friction, to `force`, N (n x 3).
    fn add_forces(&self, force: &mut [Vec3]);
    /// Constrains and releases nodes according to a trial step. Returns whether the active set or a force changed. If the trial step has an error
    /// bound, only changes that are certain within it are made.
    fn update_active_set(&mut self, system: &mut System, trial: &TrialStep<'_>) -> bool;
    /// Whether a partial solution suffices: [`update_active_set`](Self::update_active_set) would make a change, and all of its changes are certain
    /// within the error bound. The solve is then stopped and repeated with the new active set.
    fn can_stop_early(&self, _: &System, _: &TrialStep<'_>) -> bool {
        false
    }
    /// Largest number of full solves in one Newton iteration.
    fn max_passes(&self) -> usize {
        MAX_ACTIVE_SET_PASSES
    }
    /// Whether the step ignores the steps before it, as backward Euler does: contacts begin and end with a step.
    fn interrupts_history(&self) -> bool {
        self.is_active()
    }
    /// Begins a Newton iteration of an implicit step.
    fn begin_iteration(&mut self) {}
    /// Whether any node may come into contact in this step. Without candidates the step skips the contact code.
    fn has_candidates(&self) -> bool;
    /// Whether any node is constrained, or pressed by the springs of a contact.
    fn is_active(&self) -> bool;
    /// Records its state before a step that may be taken back, which [`take_back`](Self::take_back) returns to, and drops what is left of the step before.
    fn keep_start(&mut self);
    /// Returns to the state that was recorded, because the step is taken again or was stopped, and releases all nodes.
    fn take_back(&mut self, system: &mut System);
    /// Releases all nodes. `reaction` holds the constraint forces of the step, N (n x 3); adds the forces of [`add_forces`](Self::add_forces).
    fn end(&mut self, system: &mut System, reaction: &mut [Vec3]);
}

/// Velocities and constraint forces at the end of a step with the present active set.
pub struct TrialStep<'a> {
    /// Position of a node where the contacts of the step began, m: before the step, or with explicit Euler after positions have moved. Those of the nodes are
    /// predicted ones after the first Newton iteration.
    pub start: &'a dyn Fn(&System, usize) -> Vec3,
    /// Velocity of a node after the step, m/s.
    pub velocity: &'a dyn Fn(&System, usize) -> Vec3,
    /// Constraint force on a node, N.
    pub reaction: &'a dyn Fn(usize) -> Vec3,
    /// Bound of the errors of both; `None` if the solve met its tolerance.
    pub error_bound: Option<&'a ErrorBound<'a>>,
}

/// Returns, for a node and a unit vector, bounds of the errors of its constraint force (N) and of its velocity (m/s) along that vector.
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

    fn keep_start(&mut self) {}

    fn take_back(&mut self, _: &mut System) {}

    fn end(&mut self, _: &mut System, _: &mut [Vec3]) {}
}
