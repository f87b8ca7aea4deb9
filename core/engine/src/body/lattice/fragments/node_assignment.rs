//! Assigns nodes to the corners of fragments: which corners share a node, and which node it is.

use super::voxels::FaceLink;
use super::{CutCell, Fragment, Fragments, NewCopy, NodeKey};
use pliant_mesh::DisjointSets;
use pliant_plugin_api::abi;
use std::collections::{BTreeMap, BTreeSet, HashSet};

/// Equivalence classes of fragment corners: the corners of one class are one node.
///
/// A corner has the number `first[cell] + 8 fragment + corner`. Numbers after all corners stand for grid nodes that are corners of uncut
/// cells.
struct CornerClasses {
    sets: DisjointSets,
    /// Number of the first corner of each cell.
    first: BTreeMap<u64, u32>,
    /// Number of each grid node that an uncut cell has as a corner.
    grid_nodes: BTreeMap<u64, u32>,
}

impl CornerClasses {
    /// The number of a grid node.
    fn grid_node(&mut self, id: u64) -> u32 {
        *self.grid_nodes.entry(id).or_insert_with(|| self.sets.add())
    }
}

/// Corners on the common face of two cells along an axis: corner of the first cell, corner of the second.
fn common_corners(axis: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..8).filter(move |c| c >> axis & 1 == 1).map(move |c| (c, c & !(1 << axis)))
}

impl Fragments {
    /// Assigns nodes to the fragments of the cells that have a corner in common with `near`, the cells whose voxels may have changed.
    /// Returns the ids of those and of all others whose nodes changed.
    pub(super) fn assign_nodes(&mut self, near: &[u64]) -> Vec<u64> {
        let changed = near.iter().filter_map(|id| self.cells.get(id));
        let nodes: HashSet<u64> = changed.flat_map(|cell| cell.nodes).collect();
        let around: BTreeSet<u64> =
            nodes.iter().filter_map(|node| self.cells_of_node.get(node)).flatten().copied().collect();
        let ids: Vec<u64> = around.into_iter().collect();
        let (mut first, mut total) = (BTreeMap::new(), 0);
        for id in &ids {
            first.insert(*id, total);
            total += 8 * self.cells[id].voxels.count() as u32;
        }
        let sets = DisjointSets::new(total as usize);
        let mut classes = CornerClasses { sets, first, grid_nodes: BTreeMap::new() };
        ids.iter().for_each(|id| self.unite_with_neighbours(*id, &mut classes));
        let previous = self.previous_nodes(&ids);
        let key_of = self.name_classes(&nodes, classes, &previous);
        self.merged = self.merged_nodes(&ids, &key_of);
        let mut changed: BTreeSet<u64> = near.iter().copied().collect();
        let mut corner = 0;
        for id in &ids {
            let Some(cell) = self.cells.get_mut(id) else { continue };
            let mut fragments = Vec::with_capacity(cell.voxels.count());
            for f in 0..cell.voxels.count() {
                let nodes = std::array::from_fn(|c| key_of[corner + c]);
                fragments.push(Fragment { share: cell.voxels.share(f), nodes, points: Vec::new() });
                corner += 8;
            }
            let same = fragments.len() == cell.fragments.len()
                && fragments.iter().zip(&cell.fragments).all(|(a, b)| a.nodes == b.nodes);
            if same {
                let pairs = fragments.iter_mut().zip(&mut cell.fragments);
                pairs.for_each(|(a, b)| std::mem::swap(&mut a.points, &mut b.points));
            } else {
                changed.insert(*id);
            }
            cell.fragments = fragments;
            cell.voxels.store_labels();
        }
        changed.into_iter().filter(|id| self.cells.contains_key(id)).collect()
    }

    /// Unites the corners of a cell's fragments with those of its neighbours, across every face through which voxels are connected.
    fn unite_with_neighbours(&self, id: u64, classes: &mut CornerClasses) {
        let (cell, base) = (&self.cells[&id], classes.first[&id]);
        for axis in 0..3 {
            let next = cell.neighbours[2 * axis + 1];
            if next != abi::NO_CELL {
                let other_cell = self.cells.get(&next);
                let is_solid = |voxel: usize| other_cell.is_none_or(|cell| cell.voxels.is_solid(voxel));
                // A cut cell without common corners with the changed cells keeps its nodes.
                let is_unchanged = other_cell.is_some() && !classes.first.contains_key(&next);
                // A sliver is merged into larger fragments; the links inside of it do not connect these.
                let in_sliver = |link: &FaceLink| {
                    let is_merged = |cell: &CutCell| cell.voxels.is_merged(link.neighbour);
                    cell.voxels.is_merged(link.voxel) && other_cell.is_some_and(is_merged)
                };
                let links = cell.voxels.face(axis).filter(|link| !is_unchanged && !in_sliver(link));
                for link in links.filter(|link| link.is_connected && is_solid(link.neighbour)) {
                    let own = base + 8 * cell.voxels.fragment(link.voxel) as u32;
                    for (c, d) in common_corners(axis) {
                        let other = match other_cell {
                            Some(cell) => {
                                classes.first[&next] + 8 * cell.voxels.fragment(link.neighbour) as u32 + d as u32
                            }
                            None => classes.grid_node(cell.nodes[c]),
                        };
                        classes.sets.unite(own + c as u32, other);
                    }
                }
            }
            // All links to an uncut neighbour in the negative direction are connected.
            let previous = cell.neighbours[2 * axis];
            if previous != abi::NO_CELL && !self.cells.contains_key(&previous) {
                for link in cell.voxels.face(axis).filter(|link| cell.voxels.is_solid(link.neighbour)) {
                    let own = base + 8 * cell.voxels.fragment(link.neighbour) as u32;
                    for (_, c) in common_corners(axis) {
                        let other = classes.grid_node(cell.nodes[c]);
                        classes.sets.unite(own + c as u32, other);
                    }
                }
            }
        }
    }

    /// The previous node of each corner, by number: that of the previous fragment that held the first voxel of the present fragment.
    fn previous_nodes(&self, ids: &[u64]) -> Vec<NodeKey> {
        let mut keys = Vec::new();
        for id in ids {
            let cell = &self.cells[id];
            for f in 0..cell.voxels.count() {
                let previous = cell.voxels.previous_fragment(cell.voxels.first(f)).min(cell.fragments.len() - 1);
                keys.extend(cell.fragments[previous].nodes);
            }
        }
        keys
    }

    /// Pairs of a previous node and the node that replaces it, by the present node of each corner (`key_of`). A present fragment may consist of voxels of
    /// several previous ones, where parts are linked again; the nodes of all of these are replaced, not only of the one that held the first voxel.
    fn merged_nodes(&self, ids: &[u64], key_of: &[NodeKey]) -> Vec<(NodeKey, NodeKey)> {
        let is_new = |key: &NodeKey| self.new_copies.iter().any(|new| new.key == *key);
        let (mut merged, mut corner) = (BTreeSet::new(), 0);
        for id in ids {
            let cell = &self.cells[id];
            let voxels = (0..super::voxels::COUNT).filter(|voxel| cell.voxels.is_solid(*voxel));
            let parts = voxels.map(|voxel| [cell.voxels.previous_fragment(voxel), cell.voxels.fragment(voxel)]);
            for [previous, present] in parts.collect::<BTreeSet<_>>() {
                let Some(before) = cell.fragments.get(previous) else { continue };
                merged.extend(before.nodes.into_iter().zip(key_of[corner + 8 * present..].iter().copied()));
            }
            corner += 8 * cell.voxels.count();
        }
        merged.into_iter().filter(|(old, new)| old != new && !is_new(new)).collect()
    }

    /// The node of every corner, by number. A class with a grid node is that node; of the classes that had one node before, the first keeps it
    /// and every other gets a new copy. Corners at other places than `nodes` keep their node.
    fn name_classes(&mut self, nodes: &HashSet<u64>, mut classes: CornerClasses, previous: &[NodeKey]) -> Vec<NodeKey> {
        let sets = &mut classes.sets;
        let has_grid_node: BTreeSet<u32> = classes.grid_nodes.values().map(|number| sets.find(*number)).collect();
        let mut names: BTreeMap<u32, NodeKey> = BTreeMap::new();
        let mut taken: BTreeSet<NodeKey> = BTreeSet::new();
        let corners = 0..previous.len() as u32;
        let is_renamed = |corner: &u32| nodes.contains(&previous[*corner as usize].node);
        for corner in corners.clone().filter(is_renamed) {
            let root = sets.find(corner);
            if has_grid_node.contains(&root) {
                let key = NodeKey { node: previous[corner as usize].node, copy: 0 };
                names.insert(root, key);
                taken.insert(key);
            }
        }
        let mut out = Vec::with_capacity(previous.len());
        for corner in corners {
            let (root, old) = (sets.find(corner), previous[corner as usize]);
            if !is_renamed(&corner) {
                out.push(old);
                continue;
            }
            let (copies, new_copies) = (&mut self.copies, &mut self.new_copies);
            let key = *names.entry(root).or_insert_with(|| {
                if taken.insert(old) {
                    return old;
                }
                let count = copies.entry(old.node).or_insert(0);
                *count += 1;
                let key = NodeKey { node: old.node, copy: *count };
                new_copies.push(NewCopy { key, original: old });
                taken.insert(key);
                key
            });
            out.push(key);
        }
        out
    }
}
