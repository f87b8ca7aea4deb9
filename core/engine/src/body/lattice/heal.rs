//! Healing of a cut lattice: what a blade has parted hangs together again, voxel by voxel, and copies of nodes become one.
//!
//! A node that was two has the mass of both, and their mean position and velocity weighted by mass, so momentum is kept.

use super::fragments::NodeKey;
use super::{Lattice, LatticeError};
use pliant_solver::{Nodes, Vec3};
use std::collections::BTreeMap;

/// What is parted near a point.
#[derive(Clone, Debug, Default)]
pub struct PartedCells {
    /// Ids, ascending, of cut cells whose parts are near enough to be joined.
    pub near: Vec<u64>,
    /// Pairs of copies of a node that are farther apart, lower number first.
    pub apart: Vec<[u32; 2]>,
}

impl Lattice {
    /// Pairs of surface points that are connected through what was healed.
    pub(in crate::body) fn healed_pairs(&self) -> Vec<[u32; 2]> {
        self.fragments.healed_pairs()
    }

    /// The cut cells within `radius` (m) of a rest position (m), where copies of their nodes are within `join` (m) of each other, and pairs of copies
    /// that are within `radius` of each other.
    pub(in crate::body) fn parted_cells(&self, centre: Vec3, radius: f64, join: f64, nodes: &Nodes) -> PartedCells {
        let mut parted = PartedCells::default();
        let reach = radius + 0.5 * 3.0_f64.sqrt() * self.facts.edge;
        for (id, _) in self.fragments.centres().filter(|(_, middle)| (middle - centre).norm() <= reach) {
            let first = self.region.cell_id.partition_point(|cell| *cell < id);
            let Some(corners) = self.region.cell_corners.get(first).filter(|_| self.region.cell_id[first] == id) else {
                continue;
            };
            let copies = |node: u32| {
                let key = self.region.node_id[node as usize];
                let begin = self.region.node_id.partition_point(|other| *other < key);
                begin..self.region.node_id.partition_point(|other| *other <= key)
            };
            let gap = |a: usize, b: usize| (nodes.x[a] - nodes.x[b]).norm();
            let pairs = corners.iter().flat_map(|node| {
                let copies = copies(*node);
                (copies.start + 1..copies.end).map(move |other| (copies.start, other))
            });
            let pairs: Vec<(usize, usize)> = pairs.collect();
            let widest = pairs.iter().map(|(a, b)| gap(*a, *b)).fold(0.0, f64::max);
            if pairs.is_empty() {
                continue;
            } else if widest <= join {
                parted.near.push(id);
            } else {
                let facing = pairs.into_iter().filter(|(a, b)| gap(*a, *b) <= radius);
                parted.apart.extend(facing.map(|(a, b)| [a as u32, b as u32]));
            }
        }
        parted.apart.sort_unstable();
        parted.apart.dedup();
        parted
    }

    /// Joins what a blade has parted within `radius` (m) of a rest position (m) in cut cells. Nodes and elements change with the next
    /// [`Lattice::follow`]. Returns the ids, ascending, of the cells whose fragments or points have changed; none where nothing was parted.
    ///
    /// `side` and `neighbours` are as in [`Lattice::cut`].
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn heal(
        &mut self,
        cells: &[u64],
        centre: Vec3,
        radius: f64,
        side: impl Fn(u32) -> Vec3,
        neighbours: impl Fn(u32) -> Vec<u32>,
        nodes: &mut Nodes,
    ) -> Result<Vec<u64>, LatticeError> {
        let changed = self.fragments.heal(cells, centre, radius);
        if changed.is_empty() {
            return Ok(changed);
        }
        self.merge_copies(nodes);
        self.rebind_cells(changed, side, neighbours)
    }

    /// Gives copies that have become one node their mean state.
    fn merge_copies(&mut self, nodes: &mut Nodes) {
        let mut groups: BTreeMap<NodeKey, Vec<NodeKey>> = BTreeMap::new();
        for (from, into) in std::mem::take(&mut self.fragments.merged) {
            groups.entry(into).or_insert_with(|| vec![into]).push(from);
        }
        for (into, mut keys) in groups {
            keys.sort_unstable();
            keys.dedup();
            if keys.iter().any(|key| self.paint.is_pinned_node(key)) {
                self.paint.pin_node(into);
            }
            let index = |key: &NodeKey| {
                let of = |i: usize| NodeKey { node: self.region.node_id[i], copy: self.region.node_copy[i] };
                let first = self.region.node_id.partition_point(|other| *other < key.node);
                (first..self.region.node_id.len()).take_while(|i| of(*i).node == key.node).find(|i| of(*i) == *key)
            };
            let active: Vec<usize> = keys.iter().filter_map(index).collect();
            let held = active.iter().copied().find(|i| !nodes.constraint[*i].is_free());
            let weight = |i: usize| held.map_or(nodes.mass[i], |held| f64::from(u8::from(i == held)));
            let total: f64 = active.iter().map(|i| weight(*i)).sum();
            let mean = |field: &[Vec3]| active.iter().map(|i| weight(*i) / total * field[*i]).sum::<Vec3>();
            let (x, v) = (mean(&nodes.x), mean(&nodes.v));
            active.iter().for_each(|i| (nodes.x[*i], nodes.v[*i]) = (x, v));
        }
    }
}
