//! Cutting of a lattice: which cells are divided, and in which fragment each surface point is embedded.

use super::fragments::{Anchor, BodyInterior};
use super::majority::Embeddings;
use super::point_bindings::BoundPoint;
use super::{Lattice, LatticeError};
use pliant_mesh::DisjointSets;
use pliant_plugin_api::abi;
use pliant_solver::Vec3;
use std::collections::BTreeMap;

impl Lattice {
    /// Cuts the cells that a blade has swept. Nodes and elements change with the next [`Lattice::follow`]. Returns the ids, ascending, of
    /// the cells whose fragments or points have changed.
    ///
    /// `swept` are triangles in the rest shape (m), `new` the surface points that the cut has made. `side` gives a rest position close to a
    /// point and on its side of all cuts (m), `neighbours` the points it shares a triangle with, and `interior` where the body is.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn cut(
        &mut self,
        swept: &[[Vec3; 3]],
        new: impl Iterator<Item = u32>,
        side: impl Fn(u32) -> Vec3,
        neighbours: impl Fn(u32) -> Vec<u32>,
        interior: &impl BodyInterior,
    ) -> Result<Vec<u64>, LatticeError> {
        let level = self.settings.level;
        // Scenes with a cut of tetrahedra are refused.
        let Some(grid) = self.source.plugin() else { return Ok(Vec::new()) };
        let mut changed = self.fragments.cut(grid, level, swept, interior)?;
        for point in new {
            let place = side(point);
            let id = self.cut_cell_of(place)?;
            self.bindings.add(point, id, place);
            changed.push(id);
        }
        changed.sort_unstable();
        changed.dedup();
        self.rebind_cells(changed, side, neighbours)
    }

    /// Embeds the surface points of cells (ids, ascending) in their present fragments. Returns the cells.
    pub(super) fn rebind_cells(
        &mut self,
        changed: Vec<u64>,
        side: impl Fn(u32) -> Vec3,
        neighbours: impl Fn(u32) -> Vec<u32>,
    ) -> Result<Vec<u64>, LatticeError> {
        let level = self.settings.level;
        let mut points: Vec<BoundPoint> = Vec::new();
        for &id in &changed {
            let own = self.source.points_of(level, id)?;
            points.extend(own.iter().map(|point| BoundPoint { point: *point, containing: id }));
            points.extend(self.bindings.of_cell(id));
            self.fragments.release(id);
        }
        points.sort_unstable();
        points.dedup();
        if self.fragments.is_part() {
            // Points without triangles are those of other parts.
            points.retain(|bound| !neighbours(bound.point).is_empty());
        }
        let (mut embeddings, mut containing_of) = (Embeddings::new(), BTreeMap::new());
        for bound in points {
            let BoundPoint { point, containing } = bound;
            if let Some(cell) = self.bindings.remove(point) {
                self.fragments.release_point(cell, point);
            }
            let anchor = self.fragments.anchor(containing, side(point));
            self.bind(bound, &anchor);
            embeddings.insert(point, anchor.fragment);
            containing_of.insert(point, containing);
        }
        self.rebind_by_majority(embeddings, &containing_of, side, neighbours);
        self.needs_rebuild = true;
        Ok(changed)
    }

    /// Embeds a surface point in the fragment of an anchor.
    pub(super) fn bind(&mut self, bound: BoundPoint, anchor: &Anchor) {
        self.fragments.bind(anchor, bound.point);
        self.bindings.bind(bound, anchor.fragment.cell, anchor.place);
    }

    /// Ids of the cells that a blade has cut or come near, ascending.
    pub fn cut_cells(&self) -> impl Iterator<Item = u64> + '_ {
        self.fragments.cell_ids()
    }

    /// Whether a blade has cut the cell with this id or come near it.
    pub fn is_cut(&self, id: u64) -> bool {
        self.fragments.contains(id)
    }

    /// Whether any parts have been joined again.
    pub fn is_healed(&self) -> bool {
        self.fragments.is_healed()
    }

    /// Whether a rest position (m) lies in an occupied cell.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn is_occupied(&self, point: Vec3) -> Result<bool, LatticeError> {
        Ok(self.locate(point)?.cell != abi::NO_CELL)
    }

    /// The cell and fragment in which a rest position (m) is embedded; `None` outside of all occupied cells.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(in crate::body) fn anchor_at(&self, point: Vec3) -> Result<Option<Anchor>, LatticeError> {
        let id = self.locate(point)?.cell;
        Ok((id != abi::NO_CELL).then(|| self.fragments.anchor(id, point)))
    }

    /// Id of the cut cell that contains a rest position (m), or of the nearest one.
    fn cut_cell_of(&self, point: Vec3) -> Result<u64, LatticeError> {
        let id = self.locate(point)?.cell;
        if self.fragments.contains(id) {
            return Ok(id);
        }
        let distance = |centre: Vec3| (centre - point).norm_squared();
        let cells = self.fragments.centres();
        Ok(cells.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).map_or(id, |(id, _)| id))
    }

    /// Rest position (m) at which a surface point of the model at `own` is embedded.
    pub(super) fn binding_place(&self, point: u32, own: Vec3) -> Vec3 {
        self.bindings.place(point).unwrap_or(own)
    }

    /// The connected part of the active cells that each active node belongs to, numbered from 0 (n).
    pub fn parts(&self) -> Vec<u32> {
        let mut sets = DisjointSets::new(self.region.node_id.len());
        for corners in &self.region.cell_corners {
            corners[1..].iter().for_each(|&n| sets.unite(corners[0], n));
        }
        let roots: Vec<u32> = (0..self.region.node_id.len() as u32).map(|n| sets.find(n)).collect();
        let mut number = vec![u32::MAX; roots.len()];
        let mut count = 0;
        for &root in &roots {
            if number[root as usize] == u32::MAX {
                number[root as usize] = count;
                count += 1;
            }
        }
        roots.iter().map(|root| number[*root as usize]).collect()
    }
}
