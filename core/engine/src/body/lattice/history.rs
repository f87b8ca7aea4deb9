//! Transfers the history variables of elements to a new region.
//!
//! Elements are identified by their nodes, so the order of the new list does not matter. A copy of a node counts as the node it was copied
//! from, so both parts of a cut element get the history of the whole. Elements at one stencil, as those of a quadratic tetrahedron, keep their order in it.

use pliant_solver::System;
use std::collections::HashMap;

/// Histories of the elements of a region before it changes, by element set.
pub(super) struct Histories(Vec<SetHistory>);

/// History of one element set; empty where all history variables are zero.
#[derive(Default)]
struct SetHistory {
    /// History variables, one row of all elements for each variable (stride x m).
    history: Vec<f64>,
    /// Number of elements, m.
    count: usize,
    /// First element of each stencil, by its nodes.
    element: HashMap<ElementKey, usize>,
}

/// Nodes of an element, or the corners of a quadratic tetrahedron, ascending, with `usize::MAX` after the last.
type ElementKey = [usize; 4];

/// The key of an element with these nodes.
fn key(nodes: impl Iterator<Item = usize>) -> ElementKey {
    let mut key = [usize::MAX; 4];
    key.iter_mut().zip(nodes).for_each(|(to, node)| *to = node);
    key.sort_unstable();
    key
}

impl Histories {
    /// Copies the histories of the present elements.
    pub(super) fn take(system: &System) -> Self {
        let history_of = |set: &pliant_solver::ElementSet| {
            if set.history().iter().all(|value| *value == 0.0) {
                return SetHistory::default();
            }
            let stencils = set.nodes().chunks_exact(set.stencil()).enumerate();
            let first = |(s, nodes): (usize, &[u32])| (key(nodes.iter().map(|n| *n as usize)), s * set.parts());
            SetHistory { history: set.history().to_vec(), count: set.count(), element: stencils.map(first).collect() }
        };
        Self(system.sets.iter().map(history_of).collect())
    }

    /// Writes the histories to the present elements; new elements keep their initial history. `old_node` has the number of each present
    /// node at the time of [`Histories::take`], if it existed.
    pub(super) fn restore(&self, system: &mut System, old_node: &[Option<usize>]) {
        for (set, old) in system.sets.iter_mut().zip(&self.0).filter(|(_, old)| old.count > 0) {
            let (count, stride) = (set.count(), old.history.len() / old.count);
            let parts = set.parts();
            let mut history = set.history().to_vec();
            for (s, nodes) in set.nodes().chunks_exact(set.stencil()).enumerate() {
                let old_nodes = nodes.iter().map(|n| old_node[*n as usize].unwrap_or(usize::MAX));
                let Some(&from) = old.element.get(&key(old_nodes)) else { continue };
                for (plane, part) in (0..stride).flat_map(|plane| (0..parts).map(move |part| (plane, part))) {
                    history[plane * count + s * parts + part] = old.history[plane * old.count + from + part];
                }
            }
            set.set_history(&history);
        }
    }
}
