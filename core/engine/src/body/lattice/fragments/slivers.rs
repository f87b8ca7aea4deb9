//! Parts too small to go their own way.
//!
//! Cuts that cross or run side by side leave splinters of a voxel or two, without the mass to take a force and often without
//! an end in the mesh. A part that hangs together over less than half a cell in all stays with what it was cut from.

use super::Fragments;
use pliant_plugin_api::abi;
use std::collections::{BTreeMap, BTreeSet};

/// Voxels below which a part stays with another; a cell has 64.
const LEAST: u32 = 32;

/// A cell and a fragment of it.
type Piece = (u64, usize);

impl Fragments {
    /// Merges parts that are too small into what is beside them, as far as the cells `near` are in them: nothing else can
    /// have become small. Gives the cells that changed.
    pub(super) fn merge_slivers(&mut self, near: &[u64]) -> Vec<u64> {
        let mut seeds: BTreeSet<u64> = near.iter().copied().collect();
        seeds.extend(near.iter().filter_map(|id| self.cells.get(id)).flat_map(|cell| cell.neighbours));
        let mut small: BTreeSet<Piece> = BTreeSet::new();
        for id in seeds {
            let Some(cell) = self.cells.get(&id) else { continue };
            for f in 0..cell.voxels.count() {
                if !small.contains(&(id, f)) {
                    small.extend(self.small_part((id, f)).into_iter().flatten());
                }
            }
        }
        let mut of_cell: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
        small.into_iter().for_each(|(id, f)| of_cell.entry(id).or_default().push(f));
        let mut changed = Vec::new();
        for (id, small) in of_cell {
            let Some(cell) = self.cells.get_mut(&id).filter(|cell| small.len() < cell.voxels.count()) else { continue };
            let is_small: Vec<bool> = (0..cell.voxels.count()).map(|f| small.contains(&f)).collect();
            cell.voxels.merge(&is_small);
            changed.push(id);
        }
        changed
    }

    /// All that hangs together with a piece, if it is too small; the search ends when it is not.
    fn small_part(&self, seed: Piece) -> Option<BTreeSet<Piece>> {
        let mut part = BTreeSet::from([seed]);
        let mut waiting = vec![seed];
        let mut voxels = 0;
        while let Some((id, f)) = waiting.pop() {
            let cell = &self.cells[&id];
            voxels += cell.voxels.size(f);
            if voxels >= LEAST {
                return None;
            }
            for axis in 0..3 {
                let (before, next) = (cell.neighbours[2 * axis], cell.neighbours[2 * axis + 1]);
                for (voxel, other, joined) in cell.voxels.face(axis) {
                    if joined && next != abi::NO_CELL && cell.voxels.fragment(voxel) == f {
                        // What goes on in a cell that no blade has come near is not small.
                        let cell = self.cells.get(&next).map(|cell| &cell.voxels)?;
                        if cell.is_solid(other) && part.insert((next, cell.fragment(other))) {
                            waiting.push((next, cell.fragment(other)));
                        }
                    }
                    if before == abi::NO_CELL || cell.voxels.fragment(other) != f || !cell.voxels.is_solid(other) {
                        continue;
                    }
                    let cell = self.cells.get(&before).map(|cell| &cell.voxels)?;
                    if cell.is_joined(voxel, axis) && part.insert((before, cell.fragment(voxel))) {
                        waiting.push((before, cell.fragment(voxel)));
                    }
                }
            }
        }
        Some(part)
    }
}
