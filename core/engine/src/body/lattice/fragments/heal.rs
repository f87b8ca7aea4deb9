//! Healing of cut cells: voxels that a blade has parted are linked again.

use super::Fragments;
use pliant_solver::Vec3;

impl Fragments {
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
                near.push(*id);
            }
        }
        if near.is_empty() {
            return near;
        }
        self.new_copies.clear();
        near.append(&mut self.merge_slivers(&near));
        self.assign_nodes(&near)
    }
}
