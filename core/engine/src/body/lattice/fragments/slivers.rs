//! Merges fragments that are too small to move on their own.
//!
//! Cuts that cross or run side by side leave slivers of a voxel or two, with hardly any mass and often without a counterpart in the mesh. A
//! connected part of fragments with less than half the volume of a cell is merged with the fragments it was cut from.

use super::{CellFragment, Fragments};
use pliant_plugin_api::abi;
use std::collections::{BTreeMap, BTreeSet};

/// Fewest voxels of a part; a cell has 64.
const MIN_VOXELS: u32 = 32;

impl Fragments {
    /// Merges small parts with the fragments beside them, cell by cell. `near` are the cells whose voxels may have changed: only parts near
    /// these can be small. Returns the ids of the changed cells.
    pub(super) fn merge_slivers(&mut self, near: &[u64]) -> Vec<u64> {
        let mut seeds: BTreeSet<u64> = near.iter().copied().collect();
        seeds.extend(near.iter().filter_map(|id| self.cells.get(id)).flat_map(|cell| cell.neighbours));
        let mut small: BTreeSet<CellFragment> = BTreeSet::new();
        for id in seeds {
            let Some(cell) = self.cells.get(&id) else { continue };
            for fragment in 0..cell.voxels.count() {
                let seed = CellFragment { cell: id, fragment };
                if !small.contains(&seed) {
                    small.extend(self.small_part(seed).into_iter().flatten());
                }
            }
        }
        let mut small_of_cell: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
        small.into_iter().for_each(|small| small_of_cell.entry(small.cell).or_default().push(small.fragment));
        let mut changed = Vec::new();
        for (id, small) in small_of_cell {
            let Some(cell) = self.cells.get_mut(&id).filter(|cell| small.len() < cell.voxels.count()) else { continue };
            let is_small: Vec<bool> = (0..cell.voxels.count()).map(|f| small.contains(&f)).collect();
            cell.voxels.merge(&is_small);
            changed.push(id);
        }
        changed
    }

    /// The connected part that contains a fragment, if it is small; `None` as soon as it is not.
    fn small_part(&self, seed: CellFragment) -> Option<BTreeSet<CellFragment>> {
        let mut part = BTreeSet::from([seed]);
        let mut stack = vec![seed];
        let mut voxels = 0;
        while let Some(CellFragment { cell: id, fragment }) = stack.pop() {
            let cell = &self.cells[&id];
            voxels += cell.voxels.size(fragment);
            if voxels >= MIN_VOXELS {
                return None;
            }
            for axis in 0..3 {
                let (previous, next) = (cell.neighbours[2 * axis], cell.neighbours[2 * axis + 1]);
                for link in cell.voxels.face(axis) {
                    if link.is_connected && next != abi::NO_CELL && cell.voxels.fragment(link.voxel) == fragment {
                        // A part that reaches an uncut cell is not small.
                        let other = self.cells.get(&next).map(|cell| &cell.voxels)?;
                        let reached = CellFragment { cell: next, fragment: other.fragment(link.neighbour) };
                        if other.is_solid(link.neighbour) && part.insert(reached) {
                            stack.push(reached);
                        }
                    }
                    // The voxel at the same place of this cell's first layer, seen from the previous cell.
                    let own = link.neighbour;
                    if previous == abi::NO_CELL || cell.voxels.fragment(own) != fragment || !cell.voxels.is_solid(own) {
                        continue;
                    }
                    let other = self.cells.get(&previous).map(|cell| &cell.voxels)?;
                    let reached = CellFragment { cell: previous, fragment: other.fragment(link.voxel) };
                    if other.is_connected(link.voxel, axis) && part.insert(reached) {
                        stack.push(reached);
                    }
                }
            }
        }
        Some(part)
    }
}
