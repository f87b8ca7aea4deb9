//! The embedding of the surface in the lattice: positions of points from those of nodes, and forces on nodes from forces on points by the
//! transpose.

use super::fragments::CellFragment;
use super::smooth::{interpolate, weights};
use super::{Lattice, LatticeError, NO_WEIGHTS};
use crate::body::Samples;
use crate::body::model::Model;
use crate::body::skin::{EmbeddedPoint, Skin};
use bytemuck::{cast_slice, cast_slice_mut};
use pliant_plugin_api::abi;
use pliant_solver::{Nodes, Pool, Vec3};

/// Buffers that are reused from call to call.
#[derive(Default)]
pub(super) struct Scratch {
    places: Vec<Vec3>,
    cells: Vec<u64>,
    corners: Vec<[Vec3; 8]>,
    now: Vec<Vec3>,
    rest: Vec<Vec3>,
}

/// A rest position in the grid.
#[derive(Clone, Copy, Debug)]
pub(super) struct GridPoint {
    /// Id of the occupied cell that contains it, or [`abi::NO_CELL`].
    pub cell: u64,
    /// Weights of the corners of the cell there.
    pub weights: [f64; 8],
}

impl Lattice {
    /// Locates a rest position (m) in the grid.
    pub(super) fn locate(&self, point: Vec3) -> Result<GridPoint, LatticeError> {
        let (mut id, mut weights) = ([abi::NO_CELL], [[0.0; 8]]);
        self.source.weights(self.settings.level, &[point.into()], &mut id, &mut weights)?;
        Ok(GridPoint { cell: id[0], weights: weights[0] })
    }

    /// Values of a nodal field (n) at the corners of an active cell.
    pub fn corners(&self, cell: u32, field: &[Vec3]) -> [Vec3; 8] {
        self.region.cell_corners[cell as usize].map(|n| field[n as usize])
    }

    /// Id and fragment of an active cell.
    pub(super) fn cell_fragment(&self, cell: u32) -> CellFragment {
        let cell = cell as usize;
        CellFragment { cell: self.region.cell_id[cell], fragment: self.region.cell_fragment[cell] as usize }
    }

    /// Position of an active node in the grid, m: the rest position before any edit.
    pub fn grid_rest(&self, node: u32) -> Vec3 {
        self.region.node_rest[node as usize].into()
    }

    /// Surface points embedded in an active cell.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn points(&self, cell: u32) -> Result<&[u32], LatticeError> {
        if let Some(points) = self.fragments.points(self.cell_fragment(cell)) {
            return Ok(points);
        }
        let [begin, end] = self.region.cell_points[cell as usize];
        Ok(&self.source.points(self.settings.level)?[begin as usize..end as usize])
    }

    /// The active cell, or fragment, that contains a rest position (m) in the cell with this id.
    fn cell_at(&self, id: u64, point: Vec3) -> Option<usize> {
        let first = self.region.cell_id.partition_point(|c| *c < id);
        if self.region.cell_id.get(first) != Some(&id) {
            return None;
        }
        let fragment = self.fragments.fragment_at(id, point);
        (first..self.region.cell_id.len())
            .take_while(|c| self.region.cell_id[*c] == id)
            .find(|c| self.region.cell_fragment[*c] as usize == fragment)
    }

    /// The active cell, or fragment, that contains a rest position (m).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn cell_of(&self, point: Vec3) -> Result<Option<usize>, LatticeError> {
        Ok(self.cell_at(self.locate(point)?.cell, point))
    }

    /// Displacements of the corners of an active cell from their positions in the grid, m.
    pub fn displacements(&self, cell: u32, nodes: &Nodes) -> [Vec3; 8] {
        self.region.cell_corners[cell as usize].map(|n| nodes.x[n as usize] - self.grid_rest(n))
    }

    /// Writes the weights of rest positions (m, p x 3) in an active cell at its corners to `weights` (p x 8).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn weights_in(&mut self, cell: u32, places: &[Vec3], weights: &mut [[f64; 8]]) -> Result<(), LatticeError> {
        self.scratch.cells.resize(places.len(), 0);
        let cells = &mut self.scratch.cells[..places.len()];
        self.source.weights(self.settings.level, cast_slice(places), cells, weights)?;
        if self.has_failed_cells() {
            weights.iter_mut().zip(places).for_each(|(weights, place)| self.limit_weights(cell, *place, weights));
        }
        Ok(())
    }

    /// Appends to `out` the present positions (m) of rest positions (m, p x 3) in one active cell, with their trilinear weights (p x 8).
    /// Jets of nodes are computed once after each [`Lattice::forget_jets`].
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed_places(
        &mut self,
        cell: u32,
        places: &[Vec3],
        trilinear: &[[f64; 8]],
        nodes: &Nodes,
        out: &mut Vec<Vec3>,
    ) -> Result<(), LatticeError> {
        if let Some(grid) = self.source.nonlinear() {
            let corners = vec![self.corners(cell, &nodes.x); places.len()];
            let first = out.len();
            out.resize(first + places.len(), Vec3::zeros());
            return Ok(grid.place(
                self.settings.level,
                cast_slice(places),
                cast_slice(&corners),
                cast_slice_mut(&mut out[first..]),
            )?);
        }
        let places = places.iter().zip(trilinear);
        if let Some(smooth) = &mut self.smooth {
            let mut jets = smooth.displacement_jets(&self.region, cell as usize, nodes);
            if !smooth.rest_jets.is_empty() {
                jets = jets.plus(&smooth.rest_jets_of(&self.region, cell as usize));
            }
            out.extend(places.map(|(place, trilinear)| place + interpolate(&weights(trilinear), &jets)));
            return Ok(());
        }
        let moved = self.displacements(cell, nodes);
        let embedded =
            |(place, weights): (&Vec3, &[f64; 8])| weights.iter().zip(&moved).fold(*place, |sum, (w, u)| sum + *w * *u);
        out.extend(places.map(embedded));
        Ok(())
    }

    /// Marks the jets of all nodes as outdated, after nodes have moved.
    pub fn forget_jets(&mut self) {
        if let Some(smooth) = &mut self.smooth {
            smooth.forget();
        }
    }

    /// Appends to `out` the displacements (m) of the surface points of an active cell that nodal displacements `field` (m, n x 3) cause. The
    /// grid must be linear.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn displace_points(
        &mut self,
        cell: u32,
        field: &[Vec3],
        model: &Model,
        out: &mut Vec<Vec3>,
    ) -> Result<(), LatticeError> {
        let first = self.set_weights(cell, model)?;
        let rows = &self.weights[first..first + self.points(cell)?.len()];
        if let Some(smooth) = &self.smooth {
            let jets = smooth.cell_jets(&self.region, cell as usize, |n| field[n as usize]);
            out.extend(rows.iter().map(|trilinear| interpolate(&weights(trilinear), &jets)));
            return Ok(());
        }
        let corners = self.corners(cell, field);
        out.extend(rows.iter().map(|weights| weights.iter().zip(&corners).map(|(w, u)| *w * *u).sum::<Vec3>()));
        Ok(())
    }

    /// Displacement (m) of the present rest shape from that of the file at a rest position of the file (m); zero outside of active cells.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn rest_offset_at(&self, point: Vec3) -> Result<Vec3, LatticeError> {
        if self.rest_offsets.is_empty() {
            return Ok(Vec3::zeros());
        }
        let located = self.locate(point)?;
        let Some(cell) = self.cell_at(located.cell, point) else { return Ok(Vec3::zeros()) };
        if let Some(smooth) = &self.smooth {
            return Ok(interpolate(&weights(&located.weights), &smooth.rest_jets_of(&self.region, cell)));
        }
        let corners = self.region.cell_corners[cell].iter().zip(&located.weights);
        Ok(corners.fold(Vec3::zeros(), |sum, (&n, w)| {
            self.rest_offsets.get(&self.node_key(n)).map_or(sum, |offset| sum + *w * offset.displacement)
        }))
    }

    /// Displacement (m) of the present shape from the rest shape of the file at a rest position of the file (m); `None` outside of active
    /// cells.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn displacement_at(&self, point: Vec3, nodes: &Nodes) -> Result<Option<Vec3>, LatticeError> {
        match self.cell_of(point)? {
            Some(_) => Ok(Some(self.embed_point(point, nodes)?.now - point)),
            None => Ok(None),
        }
    }

    /// Samples embedded in an active cell, as a range of their lists.
    pub fn samples_of(&self, samples: &Samples, cell: u32) -> std::ops::Range<usize> {
        let fragment = self.cell_fragment(cell);
        samples.of_fragment(fragment, self.fragments.contains(fragment.cell))
    }

    /// Whether a blade has cut any cell or come near it.
    pub fn has_cuts(&self) -> bool {
        self.fragments.cell_ids().next().is_some()
    }

    /// Positions, in the present shape and the present rest shape, of a rest position of the file (m). Outside of active cells both are the
    /// given one.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed_point(&self, point: Vec3, nodes: &Nodes) -> Result<EmbeddedPoint, LatticeError> {
        let mut located = self.locate(point)?;
        let Some(cell) = self.cell_at(located.cell, point) else {
            return Ok(EmbeddedPoint { now: point, settled: point });
        };
        self.limit_weights(cell as u32, point, &mut located.weights);
        if let Some(smooth) = &self.smooth {
            let weights = weights(&located.weights);
            let offset = smooth.rest_jets_of(&self.region, cell);
            let moved = |n: u32| nodes.x[n as usize] - nodes.rest[n as usize];
            let moved = interpolate(&weights, &smooth.cell_jets(&self.region, cell, moved));
            let settled = point + interpolate(&weights, &offset);
            return Ok(EmbeddedPoint { now: settled + moved, settled });
        }
        let at = |field: &[Vec3]| -> Result<Vec3, LatticeError> {
            if let Some(grid) = self.source.nonlinear() {
                let (corners, mut out) = ([self.corners(cell as u32, field)], [[0.0; 3]]);
                grid.place(self.settings.level, &[point.into()], cast_slice(&corners), &mut out)?;
                return Ok(out[0].into());
            }
            let corners = self.region.cell_corners[cell].iter().zip(&located.weights);
            Ok(corners.fold(point, |sum, (&n, w)| sum + *w * (field[n as usize] - self.grid_rest(n))))
        };
        Ok(EmbeddedPoint { now: at(&nodes.x)?, settled: at(&nodes.rest)? })
    }

    /// Updates the positions of the surface points of one active cell, after nodes have moved.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed(&mut self, cell: u32, nodes: &Nodes, model: &Model, skin: &mut Skin) -> Result<(), LatticeError> {
        self.forget_jets();
        self.embed_cell(cell, nodes, model, skin)
    }

    /// [`Lattice::embed`] for several cells in a row: jets of nodes are those since the last [`Lattice::forget_jets`].
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed_cell(&mut self, cell: u32, nodes: &Nodes, model: &Model, skin: &mut Skin) -> Result<(), LatticeError> {
        if self.source.is_nonlinear() {
            return self.embed_nonlinear(cell, nodes, model, skin);
        }
        let first = self.set_weights(cell, model)?;
        if let Some(smooth) = &mut self.smooth {
            let jets = smooth.displacement_jets(&self.region, cell as usize, nodes);
            let is_at_rest = jets.is_zero();
            for (i, &v) in self.points(cell)?.iter().enumerate() {
                // The surface at rest is exact to the last bit.
                let u = if is_at_rest { Vec3::zeros() } else { interpolate(&weights(&self.weights[first + i]), &jets) };
                skin.place(v, skin.settled[v as usize] + u);
            }
            return Ok(());
        }
        // Displacements are interpolated, not positions: the surface at rest is then exact to the last bit.
        let corners = self.region.cell_corners[cell as usize];
        let moved = corners.map(|n| nodes.x[n as usize] - nodes.rest[n as usize]);
        for (i, &v) in self.points(cell)?.iter().enumerate() {
            let weights = &self.weights[first + i];
            let u: Vec3 = weights.iter().zip(&moved).map(|(w, u)| *w * *u).sum();
            skin.place(v, skin.settled[v as usize] + u);
        }
        Ok(())
    }

    /// Updates the positions of all points in active cells.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn embed_all(
        &mut self,
        _pool: &Pool,
        nodes: &Nodes,
        model: &Model,
        skin: &mut Skin,
    ) -> Result<(), LatticeError> {
        self.forget_jets();
        (0..self.region.cell_id.len() as u32).try_for_each(|cell| {
            if self.points(cell)?.is_empty() { Ok(()) } else { self.embed_cell(cell, nodes, model, skin) }
        })
    }

    /// First row of `weights` of a cell's surface points; computes them on first use.
    pub(super) fn set_weights(&mut self, cell: u32, model: &Model) -> Result<usize, LatticeError> {
        let known = self.weights_of[cell as usize];
        if known != NO_WEIGHTS {
            return Ok(known as usize);
        }
        let first = self.weights.len();
        let mut scratch = std::mem::take(&mut self.scratch);
        let points = self.points(cell)?;
        scratch.places.clear();
        scratch.places.extend(points.iter().map(|&v| self.binding_place(v, model.surface.points[v as usize])));
        scratch.cells.clear();
        scratch.cells.resize(points.len(), 0);
        self.weights.resize(first + scratch.places.len(), [0.0; 8]);
        let (places, cells) = (&scratch.places, &mut scratch.cells);
        self.source.weights(self.settings.level, cast_slice(places), cells, &mut self.weights[first..])?;
        if self.has_failed_cells() {
            let mut weights = std::mem::take(&mut self.weights);
            let rows = weights[first..].iter_mut().zip(places.iter());
            rows.for_each(|(weights, place)| self.limit_weights(cell, *place, weights));
            self.weights = weights;
        }
        self.weights_of[cell as usize] = first as u32;
        self.scratch = scratch;
        Ok(first)
    }

    /// [`Lattice::embed_cell`] for a grid whose embedding is not linear: the plugin places the points.
    fn embed_nonlinear(
        &mut self,
        cell: u32,
        nodes: &Nodes,
        model: &Model,
        skin: &mut Skin,
    ) -> Result<(), LatticeError> {
        let Some(grid) = self.source.nonlinear() else { return Ok(()) };
        let mut s = std::mem::take(&mut self.scratch);
        let points = self.points(cell)?;
        s.places.clear();
        s.places.extend(points.iter().map(|&v| model.surface.points[v as usize]));
        s.now.resize(points.len(), Vec3::zeros());
        s.rest.resize(points.len(), Vec3::zeros());
        for (field, out) in [(&nodes.rest, &mut s.rest), (&nodes.x, &mut s.now)] {
            s.corners.clear();
            s.corners.resize(points.len(), self.corners(cell, field));
            grid.place(self.settings.level, cast_slice(&s.places), cast_slice(&s.corners), cast_slice_mut(out))?;
        }
        for (i, &v) in points.iter().enumerate() {
            let u = s.now[i] - s.rest[i];
            skin.place(v, skin.settled[v as usize] + u);
        }
        self.scratch = s;
        Ok(())
    }

    /// Finds the active cell of each rest position (m, p x 3), `None` outside of all, and the trilinear weights there (p x 8).
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn find(
        &mut self,
        places: &[Vec3],
        cells: &mut Vec<Option<u32>>,
        weights: &mut Vec<[f64; 8]>,
    ) -> Result<(), LatticeError> {
        let mut ids = std::mem::take(&mut self.scratch.cells);
        ids.clear();
        ids.resize(places.len(), abi::NO_CELL);
        weights.clear();
        weights.resize(places.len(), [0.0; 8]);
        let result = self.source.weights(self.settings.level, cast_slice(places), &mut ids, weights);
        cells.clear();
        cells.extend(ids.iter().zip(places).map(|(id, place)| self.cell_at(*id, *place).map(|cell| cell as u32)));
        if self.has_failed_cells() {
            let found = cells.iter().zip(places).zip(weights.iter_mut());
            found
                .filter_map(|((cell, place), weights)| Some(((*cell)?, place, weights)))
                .for_each(|(cell, place, weights)| self.limit_weights(cell, *place, weights));
        }
        self.scratch.cells = ids;
        Ok(result?)
    }

    /// Distributes forces (N, p x 3) at points that [`Lattice::find`] has found among the nodes, by the transpose of the embedding: calls
    /// `visit(node, force)`, several times for a node of several points. Forces outside of all cells are dropped.
    pub fn distribute_forces(
        &mut self,
        cells: &[Option<u32>],
        trilinear: &[[f64; 8]],
        forces: &[Vec3],
        mut visit: impl FnMut(u32, Vec3),
    ) {
        let found =
            cells.iter().zip(trilinear).zip(forces).filter_map(|((cell, w), f)| Some(((*cell)? as usize, w, f)));
        if let Some(smooth) = &mut self.smooth {
            found.for_each(|(cell, trilinear, f)| smooth.add_load(&self.region, cell, &weights(trilinear), *f));
            return smooth.pull_back(&self.region, visit);
        }
        for (cell, trilinear, force) in found {
            self.region.cell_corners[cell].iter().zip(trilinear).for_each(|(node, w)| visit(*node, *w * force));
        }
    }

    /// Distributes a stiffness at a point that [`Lattice::find`] has found among the diagonal entries of nodes: calls `visit(node, share)`,
    /// the share (1) relative to the stiffness.
    pub fn visit_stiffness_shares(&mut self, cell: u32, trilinear: &[f64; 8], mut visit: impl FnMut(u32, f64)) {
        if let Some(smooth) = &mut self.smooth {
            return smooth.visit_stiffness_shares(&self.region, cell as usize, &weights(trilinear), visit);
        }
        self.region.cell_corners[cell as usize].iter().zip(trilinear).for_each(|(node, w)| visit(*node, *w));
    }

    /// Distributes forces (N, p x 3) at rest positions (m, p x 3) among the nodes where the embedding is not linear, by its present derivative:
    /// calls `visit(node, force)`.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn pull_back(
        &mut self,
        places: &[Vec3],
        loads: &[Vec3],
        nodes: &Nodes,
        mut visit: impl FnMut(u32, Vec3),
    ) -> Result<(), LatticeError> {
        let Some(grid) = self.source.nonlinear() else { return Ok(()) };
        for (place, load) in places.iter().zip(loads) {
            let id = grid.locate(self.settings.level, (*place).into())?.cell;
            let Some(cell) = self.cell_at(id, *place) else { continue };
            let (corners, mut out) = ([self.corners(cell as u32, &nodes.x)], [[[0.0; 3]; 8]]);
            let (place, load) = ([(*place).into()], [(*load).into()]);
            grid.pull_back(self.settings.level, &place, cast_slice(&corners), &load, &mut out)?;
            for (node, f) in self.region.cell_corners[cell].iter().zip(out[0]) {
                visit(*node, f.into());
            }
        }
        Ok(())
    }
}
