//! Contacts of nodes in the last step, from which those of the next one begin.

use super::held::Touched;
use pliant_solver::Vec3;

/// A contact of a node in the last step.
#[derive(Clone, Copy)]
pub(super) struct PreviousContact {
    pub(super) node: u32,
    /// The tip or obstacle, and the second one if the node was between two.
    pub(super) touched: Touched,
    /// Friction force, N, if the node keeps sliding.
    pub(super) friction: Option<Vec3>,
}

/// Contacts of the last step, nodes ascending, also as they were before a step that may be taken again.
#[derive(Default)]
pub(super) struct PreviousContacts {
    last: Vec<PreviousContact>,
    start: Vec<PreviousContact>,
}

impl PreviousContacts {
    /// The contact of a node.
    pub(super) fn of(&self, node: u32) -> Option<PreviousContact> {
        self.last.binary_search_by_key(&node, |last| last.node).ok().map(|at| self.last[at])
    }

    /// Removes all contacts.
    pub(super) fn clear(&mut self) {
        self.last.clear();
    }

    /// Adds a contact. Before the next [`Self::of`] nodes must ascend again ([`Self::sort`]).
    pub(super) fn add(&mut self, contact: PreviousContact) {
        self.last.push(contact);
    }

    /// Sorts the contacts by node.
    pub(super) fn sort(&mut self) {
        self.last.sort_unstable_by_key(|last| last.node);
    }

    /// Keeps the contacts for [`Self::restore_start`].
    pub(super) fn keep_start(&mut self) {
        self.start.clone_from(&self.last);
    }

    /// Takes the contacts back that [`Self::keep_start`] has kept.
    pub(super) fn restore_start(&mut self) {
        self.last.clone_from(&self.start);
    }
}
