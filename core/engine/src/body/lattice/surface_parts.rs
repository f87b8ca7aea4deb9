//! Whether the parts of the lattice are those of the cut surface, and how they become that.

use super::fragments::{BodyInterior, VoxelParts};
use super::{Lattice, LatticeError, parts};
use pliant_cut::BodyPart;
use pliant_mesh::Surface;
use pliant_plugin_api::abi;
use pliant_solver::Vec3;
use std::collections::{BTreeMap, BTreeSet};

impl Lattice {
    /// Whether a part of the lattice, active or not, has points of several parts of one body. `part_of` has the part of each triangle of `surface`.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn joins_parts(
        &self,
        surface: &Surface,
        part_of: &[Option<BodyPart>],
    ) -> Result<bool, LatticeError> {
        let mut of_body = BTreeMap::new();
        if part_of.iter().flatten().all(|part| !of_body.entry(part.body).or_insert(*part).is_parted_from(*part)) {
            return Ok(false);
        }
        let components = self.components(surface.points.len())?;
        let mut first = vec![None; components.count as usize];
        let part_of = parts_of_points(surface, part_of);
        let mut points = components.of_vertex.iter().zip(&part_of);
        Ok(points.any(|(component, part)| {
            first.get_mut(*component as usize).zip(*part).is_some_and(|(first, part)| !agrees(first, part))
        }))
    }

    /// Parts the cells that hold parts of the surface together: `around` gives the parts that each of some rest positions (m) is in. Cells without a cut, of parts that
    /// lie side by side, are parted where they are `between` the parts. Nodes and elements change with the next [`Lattice::follow`]. Returns the ids,
    /// ascending, of the cells whose fragments or points have changed.
    ///
    /// `side`, `neighbours` and `interior` are as in [`Lattice::cut`].
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn part_by_surface(
        &mut self,
        between: &[u64],
        known: &mut VoxelParts,
        around: impl Fn(&[Vec3]) -> Vec<Vec<BodyPart>>,
        side: impl Fn(u32) -> Vec3,
        neighbours: impl Fn(u32) -> Vec<u32>,
        interior: &impl BodyInterior,
    ) -> Result<Vec<u64>, LatticeError> {
        let Some(grid) = self.source.plugin() else { return Ok(Vec::new()) };
        let mut changed =
            self.fragments.part_by_surface(grid, self.settings.level, between, known, around, interior)?;
        changed.sort_unstable();
        changed.dedup();
        if changed.is_empty() { Ok(changed) } else { self.rebind_cells(changed, side, neighbours) }
    }

    /// Cells without a cut, ascending, that have a node in common with several parts of one body. Where a cell has no points, `around` gives the parts that
    /// rest positions (m) in fragments are in, and `near` those with triangles in a cell without a cut around its centre (m).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn cells_between_parts(
        &self,
        surface: &Surface,
        part_of: &[Option<BodyPart>],
        around: impl Fn(&[Vec3]) -> Vec<Vec<BodyPart>>,
        near: impl Fn(Vec3) -> Vec<BodyPart>,
    ) -> Result<Vec<u64>, LatticeError> {
        let Some(grid) = self.source.plugin() else { return Ok(Vec::new()) };
        let region = self.whole_region()?;
        let part_of = parts_of_points(surface, part_of);
        let mut first = vec![None; region.node_id.len()];
        let mut is_between = vec![false; region.node_id.len()];
        let mut add = |corners: [u32; 8], part: BodyPart| {
            for node in corners.map(|node| node as usize) {
                is_between[node] |= !agrees(&mut first[node], part);
            }
        };
        let mut has_points = vec![false; region.cell_id.len()];
        self.for_points(&region, |cell, point| {
            has_points[cell] = true;
            if let Some(part) = part_of[point as usize] {
                add(region.cell_corners[cell], part);
            }
        })?;
        let (mut cut_cells, mut places) = (Vec::new(), Vec::new());
        for cell in (0..region.cell_id.len()).filter(|cell| !has_points[*cell]) {
            if let Some(place) = self.fragments.place(parts::fragment(&region, cell)) {
                cut_cells.push(cell);
                places.push(place);
                continue;
            }
            let facts = grid.cell(self.settings.level, region.cell_id[cell])?;
            if facts.state == abi::CELL_SURFACE {
                near(facts.centre.into()).into_iter().for_each(|part| add(region.cell_corners[cell], part));
            }
        }
        for (cell, parts) in cut_cells.into_iter().zip(around(&places)) {
            parts.into_iter().for_each(|part| add(region.cell_corners[cell], part));
        }
        let cells = region.cell_id.iter().zip(&region.cell_corners);
        let between = cells.filter(|(_, corners)| corners.iter().any(|node| is_between[*node as usize]));
        let whole = between.map(|(id, _)| *id).filter(|id| !self.fragments.contains(*id));
        Ok(whole.collect::<BTreeSet<_>>().into_iter().collect())
    }
}

/// Whether a part is no other part of the body of the first one, which it becomes where there is none.
fn agrees(first: &mut Option<BodyPart>, part: BodyPart) -> bool {
    !first.get_or_insert(part).is_parted_from(part)
}

/// The part of each point, from that of each triangle.
fn parts_of_points(surface: &Surface, part_of: &[Option<BodyPart>]) -> Vec<Option<BodyPart>> {
    let mut of_point = vec![None; surface.points.len()];
    for (corners, part) in surface.triangles.iter().zip(part_of) {
        corners.iter().for_each(|point| of_point[*point as usize] = *part);
    }
    of_point
}
