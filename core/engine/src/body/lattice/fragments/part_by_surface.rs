//! Parts cut cells by the parts of the surface that their voxels are in.
//!
//! A blade parts the links that it crosses, and near edges, thin places and limbs that lie side by side it can miss one of them. The cut surface is exact: two
//! voxels in different parts of it are not connected.

use super::voxels::{self, COUNT, Voxels};
use super::{BodyInterior, CutCell, Fragments};
use pliant_cut::BodyPart;
use pliant_host::{Grid, HostError};
use pliant_solver::Vec3;
use std::collections::BTreeMap;

/// The parts of the surface that voxels of cut cells are in, of each cell from when it is asked for first.
#[derive(Default)]
pub struct VoxelParts {
    /// Each place that voxels are in.
    known: Vec<Vec<BodyPart>>,
    /// Number of the place of each voxel of each cell; `None` outside of the body.
    of: BTreeMap<u64, [Option<u32>; COUNT]>,
}

impl VoxelParts {
    /// Finds the place of each solid voxel: what its point is in, else, where the surface is too thin there to tell, the place of the nearest one that is in anything.
    fn add(&mut self, id: u64, voxels: &Voxels, around: impl Fn(&[Vec3]) -> Vec<Vec<BodyPart>>) {
        if self.of.contains_key(&id) {
            return;
        }
        let solid = || (0..COUNT).filter(|voxel| voxels.is_solid(*voxel));
        let mut place = [None; COUNT];
        let points: Vec<Vec3> = solid().map(|voxel| voxels.points()[voxel]).collect();
        for (voxel, parts) in solid().zip(around(&points)) {
            if !parts.is_empty() {
                let known = self.known.iter().position(|known| *known == parts).unwrap_or_else(|| {
                    self.known.push(parts);
                    self.known.len() - 1
                });
                place[voxel] = Some(known as u32);
            }
        }
        let found = place;
        for voxel in solid().filter(|voxel| found[*voxel].is_none()) {
            let others = (0..COUNT).filter(|other| found[*other].is_some());
            place[voxel] = others.min_by_key(|o| voxels::distance_squared(voxel, *o)).and_then(|o| found[o]);
        }
        self.of.insert(id, place);
    }

    /// Whether two places are in different parts of the surface of one body. Bodies that overlap are in each other's parts.
    fn are_apart(&self, a: Option<u32>, b: Option<u32>) -> bool {
        let (Some(a), Some(b)) = (a, b) else { return false };
        let [a, b] = [a, b].map(|place| &self.known[place as usize]);
        let other_part = |part: &BodyPart| b.iter().any(|other| part.is_parted_from(*other));
        a.iter().any(other_part) && !a.iter().any(|part| b.contains(part))
    }

    /// Removes the links of a cell between voxels that are apart. Returns whether there were any.
    fn part(&self, id: u64, cell: &mut CutCell) -> bool {
        let mut has_parted = false;
        let place = &self.of[&id];
        for axis in 0..3 {
            let next_cell = self.of.get(&cell.neighbours[2 * axis + 1]);
            for voxel in 0..COUNT {
                let other = match voxels::next(voxel, axis) {
                    Some(other) => place[other],
                    None => next_cell.and_then(|next| next[voxels::opposite(voxel, axis)]),
                };
                if cell.voxels.is_connected(voxel, axis) && self.are_apart(place[voxel], other) {
                    cell.voxels.part(voxel, axis);
                    has_parted = true;
                }
            }
        }
        has_parted
    }
}

impl Fragments {
    /// Parts cells between voxels that are in different parts of the surface: `around` gives those that each of some rest positions (m) is in. Of the cells without a cut
    /// those that are `between` parts are parted too. `parts` are those found for the same surface before. Nothing of a lattice that was healed is parted. Returns the ids of the cells whose fragments or nodes may have
    /// changed.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn part_by_surface(
        &mut self,
        grid: &Grid,
        level: u32,
        between: &[u64],
        parts: &mut VoxelParts,
        around: impl Fn(&[Vec3]) -> Vec<Vec<BodyPart>>,
        interior: &impl BodyInterior,
    ) -> Result<Vec<u64>, HostError> {
        if self.is_healed() {
            return Ok(Vec::new());
        }
        self.add_cells(grid, level, between, interior)?;
        self.cells.iter().for_each(|(id, cell)| parts.add(*id, &cell.voxels, &around));
        let mut near = Vec::new();
        for (id, cell) in &mut self.cells {
            if parts.part(*id, cell) || between.binary_search(id).is_ok() {
                cell.voxels.label();
                near.push(*id);
            }
        }
        if near.is_empty() {
            return Ok(near);
        }
        near.append(&mut self.merge_slivers(&near));
        Ok(self.assign_nodes(&near))
    }
}
