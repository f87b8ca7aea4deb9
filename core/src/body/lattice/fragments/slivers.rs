//! Parts too small to go their own way.
//!
//! Cuts that cross or run side by side leave splinters of a voxel or two, without the mass to take a force and often without
//! an end in the mesh. A part that hangs together over less than half a cell in all stays with what it was cut from.

use super::Fragments;
use pliant_plugin_api::abi;
use std::collections::BTreeMap;

/// Voxels below which a part stays with another; a cell has 64.
const LEAST: u32 = 32;

impl Fragments {
    /// Merges parts that are too small into what is beside them. Gives the cells that changed.
    pub(super) fn merge_slivers(&mut self) -> Vec<u64> {
        let mut first: BTreeMap<u64, usize> = BTreeMap::new();
        let mut total = 0;
        for (id, cell) in &self.cells {
            first.insert(*id, total);
            total += cell.voxels.count();
        }
        let mut root: Vec<usize> = (0..total).collect();
        let mut held = vec![false; total];
        for (id, cell) in &self.cells {
            for axis in 0..3 {
                let (before, next) = (cell.neighbours[2 * axis], cell.neighbours[2 * axis + 1]);
                for (voxel, other, joined) in cell.voxels.face(axis) {
                    let mine = first[id] + cell.voxels.fragment(voxel);
                    match self.cells.get(&next) {
                        Some(cell) if joined && cell.voxels.is_solid(other) => {
                            let (a, b) =
                                (find(&mut root, mine), find(&mut root, first[&next] + cell.voxels.fragment(other)));
                            root[a.max(b)] = a.min(b);
                        }
                        None if joined && next != abi::NO_CELL => held[mine] = true,
                        _ => {}
                    }
                    if before != abi::NO_CELL && !self.cells.contains_key(&before) && cell.voxels.is_solid(other) {
                        held[first[id] + cell.voxels.fragment(other)] = true;
                    }
                }
            }
        }
        let mut voxels = vec![0_u32; total];
        for (id, cell) in &self.cells {
            for f in 0..cell.voxels.count() {
                let top = find(&mut root, first[id] + f);
                voxels[top] += cell.voxels.size(f);
                held[top] |= held[first[id] + f];
            }
        }
        let small: Vec<bool> =
            (0..total).map(|f| find(&mut root, f)).map(|top| !held[top] && voxels[top] < LEAST).collect();
        let mut changed = Vec::new();
        for (id, cell) in &mut self.cells {
            let of_cell = &small[first[id]..first[id] + cell.voxels.count()];
            if of_cell.contains(&true) && of_cell.contains(&false) {
                cell.voxels.merge(of_cell);
                changed.push(*id);
            }
        }
        changed
    }
}

fn find(root: &mut [usize], mut at: usize) -> usize {
    while root[at] != at {
        root[at] = root[root[at]];
        at = root[at];
    }
    at
}
