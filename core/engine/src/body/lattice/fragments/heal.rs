//! Healing of cut cells: voxels that a blade has parted are linked again.

use super::Fragments;
use pliant_mesh::DisjointSets;
use pliant_solver::Vec3;
use std::collections::{BTreeMap, HashMap};

impl Fragments {
    /// Whether any parts have been joined again.
    pub fn is_healed(&self) -> bool {
        self.cells.values().any(|cell| cell.is_healed)
    }

    /// Pairs of surface points of what is connected in cut cells through a cell that was healed: enough pairs to tell that their parts of the surface
    /// are one; none where nothing was healed.
    pub fn healed_pairs(&self) -> Vec<[u32; 2]> {
        if !self.is_healed() {
            return Vec::new();
        }
        let fragments = || self.cells.values().flat_map(|cell| cell.fragments.iter().map(|f| (f, cell.is_healed)));
        let mut sets = DisjointSets::new(fragments().count());
        let mut first_at = HashMap::new();
        for (number, (fragment, _)) in (0..).zip(fragments()) {
            for node in fragment.nodes {
                let other = *first_at.entry(node).or_insert(number);
                sets.unite(number, other);
            }
        }
        let mut is_healed = vec![false; fragments().count()];
        for (number, _) in (0..).zip(fragments()).filter(|(_, (_, healed))| *healed) {
            is_healed[sets.find(number) as usize] = true;
        }
        let (mut pairs, mut first_of) = (Vec::new(), BTreeMap::new());
        for (number, (fragment, _)) in (0..).zip(fragments()) {
            let root = sets.find(number);
            for point in fragment.points.iter().filter(|_| is_healed[root as usize]) {
                pairs.push([*first_of.entry(root).or_insert(*point), *point]);
            }
        }
        pairs.retain(|[a, b]| a != b);
        pairs
    }

    /// Links again what was parted within `radius` (m) of a rest position (m) in the cells `ids`; [`Fragments::merged`] then has the nodes that have
    /// become one. Returns the ids of the cells whose fragments or nodes may have changed.
    pub fn heal(&mut self, ids: &[u64], centre: Vec3, radius: f64) -> Vec<u64> {
        self.merged.clear();
        let mut near = Vec::new();
        for id in ids {
            if let Some(cell) = self.cells.get_mut(id)
                && cell.voxels.heal(centre, radius)
            {
                cell.voxels.label();
                cell.is_healed = true;
                near.push(*id);
            }
        }
        if near.is_empty() {
            return near;
        }
        near.append(&mut self.merge_slivers(&near));
        self.assign_nodes(&near)
    }
}
