//! The history of elements while the region changes.
//!
//! An element is known by its nodes, so one that stays keeps its history whatever the order of the new list is; and because nodes that a cut
//! copies are known by what they are copies of, both parts of a cut element have the history of the whole.

use pliant_solver::System;
use std::collections::HashMap;

/// Histories of the elements of a region that is about to change, by the elements' nodes.
pub(super) struct Histories(Vec<SetHistory>);

/// Of one set of elements.
#[derive(Default)]
struct SetHistory {
    /// (stride x m)
    history: Vec<f64>,
    /// Number of elements, m.
    count: usize,
    /// Number of each element.
    element: HashMap<ElementKey, usize>,
}

/// Nodes of an element, rising, without order among its corners.
type ElementKey = [usize; 4];

/// The key of an element with these nodes.
fn key(nodes: impl Iterator<Item = usize>) -> ElementKey {
    let mut key = [usize::MAX; 4];
    key.iter_mut().zip(nodes).for_each(|(to, node)| *to = node);
    key.sort_unstable();
    key
}

impl Histories {
    /// Of the present elements. Sets without a history cost nothing.
    pub(super) fn take(system: &System) -> Self {
        let of_set = |set: &pliant_solver::ElementSet| {
            if set.history().iter().all(|value| *value == 0.0) {
                return SetHistory::default();
            }
            let (count, corners) = (set.count(), set.nodes().len() / set.count().max(1));
            let elements = set.nodes().chunks_exact(corners).enumerate();
            let element = elements.map(|(e, nodes)| (key(nodes.iter().map(|n| *n as usize)), e)).collect();
            SetHistory { history: set.history().to_vec(), count, element }
        };
        Self(system.sets.iter().map(of_set).collect())
    }

    /// Gives the present elements the history of those they were; `old_node` is the number each node had, if it was there.
    pub(super) fn give(&self, system: &mut System, old_node: &[Option<usize>]) {
        for (set, before) in system.sets.iter_mut().zip(&self.0).filter(|(_, before)| before.count > 0) {
            let (count, stride) = (set.count(), before.history.len() / before.count);
            let corners = set.nodes().len() / count.max(1);
            let mut history = set.history().to_vec();
            for (e, nodes) in set.nodes().chunks_exact(corners.max(1)).enumerate() {
                let old = nodes.iter().map(|n| old_node[*n as usize].unwrap_or(usize::MAX));
                let Some(&was) = before.element.get(&key(old)) else { continue };
                (0..stride).for_each(|plane| history[plane * count + e] = before.history[plane * before.count + was]);
            }
            set.set_history(&history);
        }
    }
}
