//! Which corners of which fragments are one node.

use super::{Fragment, Fragments, NodeKey};
use pliant_plugin_api::abi;
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// Union-find over corners of fragments, and the nodes of the grid that cells away from the cut stand on.
struct Classes {
    root: Vec<u32>,
}

impl Classes {
    fn find(&mut self, mut at: u32) -> u32 {
        while self.root[at as usize] != at {
            let up = self.root[at as usize];
            self.root[at as usize] = self.root[up as usize];
            at = self.root[at as usize];
        }
        at
    }

    /// The lower root stays, so that the result does not depend on the order of unions.
    fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.root[a.max(b) as usize] = a.min(b);
    }
}

/// The four corners of a cell on its far face along an axis, and of the next cell on its near face.
fn common_corners(axis: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..8).filter(move |c| c >> axis & 1 == 1).map(move |c| (c, c & !(1 << axis)))
}

impl Fragments {
    /// Gives the fragments around changed cells their nodes again. `near` are the cells whose voxels may have changed; gives
    /// those and all others whose nodes did. A node depends on the cells that stand on it alone.
    pub(super) fn assign_nodes(&mut self, near: &[u64]) -> Vec<u64> {
        let changed = near.iter().filter_map(|id| self.cells.get(id));
        let nodes: HashSet<u64> = changed.flat_map(|cell| cell.nodes).collect();
        let around: BTreeSet<u64> =
            nodes.iter().filter_map(|node| self.standing.get(node)).flatten().copied().collect();
        let ids: Vec<u64> = around.into_iter().collect();
        // Handles: eight to a fragment, in order of cells; then one to each node that an uncut cell stands on.
        let mut first: BTreeMap<u64, u32> = BTreeMap::new();
        let mut total = 0;
        for id in &ids {
            first.insert(*id, total);
            total += 8 * self.cells[id].voxels.count() as u32;
        }
        let mut classes = Classes { root: (0..total).collect() };
        let mut original: BTreeMap<u64, u32> = BTreeMap::new();
        for id in &ids {
            self.join(*id, &first, &mut classes, &mut original);
        }
        let before = self.previous_nodes(&ids);
        let is_original: BTreeSet<u32> = original.values().map(|h| classes.find(*h)).collect();
        let key_of = self.name_classes(&nodes, &mut classes, &before, &is_original);
        let mut changed: BTreeSet<u64> = near.iter().copied().collect();
        let mut handle = 0;
        for id in &ids {
            let Some(cell) = self.cells.get_mut(id) else { continue };
            let mut fragments = Vec::with_capacity(cell.voxels.count());
            for f in 0..cell.voxels.count() {
                let nodes = std::array::from_fn(|c| key_of[(handle + c as u32) as usize]);
                fragments.push(Fragment { share: cell.voxels.share(f), nodes, points: Vec::new() });
                handle += 8;
            }
            let same = fragments.len() == cell.fragments.len()
                && fragments.iter().zip(&cell.fragments).all(|(a, b)| a.nodes == b.nodes);
            if same {
                fragments
                    .iter_mut()
                    .zip(&mut cell.fragments)
                    .for_each(|(a, b)| std::mem::swap(&mut a.points, &mut b.points));
            } else {
                changed.insert(*id);
            }
            cell.fragments = fragments;
            cell.voxels.settle();
        }
        changed.into_iter().filter(|id| self.cells.contains_key(id)).collect()
    }

    /// Unites the corners a cell shares with its neighbours.
    fn join(&self, id: u64, first: &BTreeMap<u64, u32>, classes: &mut Classes, original: &mut BTreeMap<u64, u32>) {
        let (cell, base) = (&self.cells[&id], first[&id]);
        for axis in 0..3 {
            let next = cell.neighbours[2 * axis + 1];
            if next != abi::NO_CELL {
                let solid = |other: usize| self.cells.get(&next).is_none_or(|cell| cell.voxels.is_solid(other));
                let apart = self.cells.contains_key(&next) && !first.contains_key(&next);
                let joints = cell.voxels.face(axis).filter(|(_, other, joined)| !apart && *joined && solid(*other));
                for (voxel, other, _) in joints {
                    let mine = base + 8 * cell.voxels.fragment(voxel) as u32;
                    for (c, d) in common_corners(axis) {
                        let theirs = match self.cells.get(&next) {
                            Some(cell) => first[&next] + 8 * cell.voxels.fragment(other) as u32 + d as u32,
                            None => node(cell.nodes[c], classes, original),
                        };
                        classes.unite(mine + c as u32, theirs);
                    }
                }
            }
            // A neighbour before this one that was not cut has all its links to it whole.
            let before = cell.neighbours[2 * axis];
            if before != abi::NO_CELL && !self.cells.contains_key(&before) {
                for (_, voxel, _) in cell.voxels.face(axis).filter(|(_, voxel, _)| cell.voxels.is_solid(*voxel)) {
                    let mine = base + 8 * cell.voxels.fragment(voxel) as u32;
                    for (_, c) in common_corners(axis) {
                        let theirs = node(cell.nodes[c], classes, original);
                        classes.unite(mine + c as u32, theirs);
                    }
                }
            }
        }
    }

    /// By handle: what the corner was called before, from the fragment that held the first voxel of the one now.
    fn previous_nodes(&self, ids: &[u64]) -> Vec<NodeKey> {
        let mut keys = Vec::new();
        for id in ids {
            let cell = &self.cells[id];
            for f in 0..cell.voxels.count() {
                let old = cell.voxels.was(cell.voxels.first(f)).min(cell.fragments.len() - 1);
                keys.extend(cell.fragments[old].nodes);
            }
        }
        keys
    }

    /// A name for the class of every handle of `nodes`: the grid's own node where an uncut cell stands on it, the old name for the
    /// first class that had it, a new copy for every other. Handles of other nodes keep theirs.
    fn name_classes(
        &mut self,
        nodes: &HashSet<u64>,
        classes: &mut Classes,
        before: &[NodeKey],
        is_original: &BTreeSet<u32>,
    ) -> Vec<NodeKey> {
        let mut names: BTreeMap<u32, NodeKey> = BTreeMap::new();
        let mut taken: BTreeSet<NodeKey> = BTreeSet::new();
        let total = before.len() as u32;
        let asked = |handle: &u32| nodes.contains(&before[*handle as usize].0);
        for handle in (0..total).filter(asked) {
            let top = classes.find(handle);
            if is_original.contains(&top) {
                let key = (before[handle as usize].0, 0);
                names.insert(top, key);
                taken.insert(key);
            }
        }
        let mut out = Vec::with_capacity(total as usize);
        for handle in 0..total {
            let (top, old) = (classes.find(handle), before[handle as usize]);
            if !asked(&handle) {
                out.push(old);
                continue;
            }
            let copies = &mut self.copies;
            let born = &mut self.born;
            let key = *names.entry(top).or_insert_with(|| {
                if taken.insert(old) {
                    return old;
                }
                let count = copies.entry(old.0).or_insert(0);
                *count += 1;
                let key = (old.0, *count);
                born.push((key, old));
                taken.insert(key);
                key
            });
            out.push(key);
        }
        out
    }
}

/// The handle of a node that an uncut cell stands on.
fn node(id: u64, classes: &mut Classes, original: &mut BTreeMap<u64, u32>) -> u32 {
    *original.entry(id).or_insert_with(|| {
        let handle = classes.root.len() as u32;
        classes.root.push(handle);
        handle
    })
}
