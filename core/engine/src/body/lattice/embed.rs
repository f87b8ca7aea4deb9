//! How the surface follows the nodes, and how loads on it go back: by the transpose.

use super::{Lattice, LatticeError, NO_WEIGHTS};
use crate::body::Samples;
use crate::body::model::Model;
use crate::body::skin::Skin;
use bytemuck::{cast_slice, cast_slice_mut};
use pliant_plugin_api::abi;
use pliant_solver::{Nodes, Pool, Vec3};

/// Buffers of one embedding.
#[derive(Default)]
pub(super) struct Scratch {
    places: Vec<Vec3>,
    cells: Vec<u64>,
    corners: Vec<[Vec3; 8]>,
    now: Vec<Vec3>,
    rest: Vec<Vec3>,
}

impl Lattice {
    /// Corner positions or other vectors of a cell.
    pub fn corners(&self, cell: u32, field: &[Vec3]) -> [Vec3; 8] {
        self.region.cell_corners[cell as usize].map(|n| field[n as usize])
    }

    /// m, where the grid has an active node.
    pub fn grid_rest(&self, node: u32) -> Vec3 {
        self.region.node_rest[node as usize].into()
    }

    /// Surface points of an active cell.
    ///
    /// # Errors
    /// What the grid says.
    pub fn points(&self, cell: u32) -> Result<&[u32], LatticeError> {
        let (id, fragment) = (self.region.cell_id[cell as usize], self.region.cell_fragment[cell as usize]);
        if let Some(own) = self.fragments.points(id, fragment as usize) {
            return Ok(own);
        }
        let [begin, end] = self.region.cell_points[cell as usize];
        Ok(&self.grid.points(self.settings.level)?[begin as usize..end as usize])
    }

    /// The active cell, or part of one, that carries a rest place of the cell with this id.
    fn cell_at(&self, id: u64, place: Vec3) -> Option<usize> {
        let first = self.region.cell_id.partition_point(|c| *c < id);
        if self.region.cell_id.get(first) != Some(&id) {
            return None;
        }
        let fragment = self.fragments.fragment_at(id, place);
        (first..self.region.cell_id.len())
            .take_while(|c| self.region.cell_id[*c] == id)
            .find(|c| self.region.cell_fragment[*c] as usize == fragment)
    }

    /// The active cell, or part of one, that carries a rest place.
    ///
    /// # Errors
    /// What the grid says.
    pub fn cell_of(&self, place: Vec3) -> Result<Option<usize>, LatticeError> {
        let (mut id, mut weights) = ([abi::NO_CELL], [[0.0; 8]]);
        self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut weights)?;
        Ok(self.cell_at(id[0], place))
    }

    /// m, how far the corners of a cell are from where the grid has them.
    pub fn displacements(&self, cell: u32, nodes: &Nodes) -> [Vec3; 8] {
        self.region.cell_corners[cell as usize].map(|n| nodes.x[n as usize] - self.grid_rest(n))
    }

    /// Weights of rest places.
    ///
    /// # Errors
    /// What the grid says.
    pub fn weights_in(&mut self, places: &[Vec3], weights: &mut [[f64; 8]]) -> Result<(), LatticeError> {
        self.scratch.cells.resize(places.len(), 0);
        let cells = &mut self.scratch.cells[..places.len()];
        Ok(self.grid.weights(self.settings.level, cast_slice(places), cells, weights)?)
    }

    /// Where the nodes carry rest places of one cell.
    ///
    /// # Errors
    /// What the grid says.
    pub fn carry(
        &self,
        cell: u32,
        places: &[Vec3],
        weights: &[[f64; 8]],
        nodes: &Nodes,
        out: &mut Vec<Vec3>,
    ) -> Result<(), LatticeError> {
        out.clear();
        if self.grid.is_nonlinear() {
            let corners = vec![self.corners(cell, &nodes.x); places.len()];
            out.resize(places.len(), Vec3::zeros());
            return Ok(self.grid.place(
                self.settings.level,
                cast_slice(places),
                cast_slice(&corners),
                cast_slice_mut(out),
            )?);
        }
        let moved = self.displacements(cell, nodes);
        let carried =
            |(place, weights): (&Vec3, &[f64; 8])| weights.iter().zip(&moved).fold(*place, |sum, (w, u)| sum + *w * *u);
        out.extend(places.iter().zip(weights).map(carried));
        Ok(())
    }

    /// m, how far a rest place is from there when its nodes are at rest, by shapes that were kept.
    ///
    /// # Errors
    /// What the grid says.
    pub fn kept_at(&self, place: Vec3) -> Result<Vec3, LatticeError> {
        if self.kept.is_empty() {
            return Ok(Vec3::zeros());
        }
        let (mut id, mut weights) = ([abi::NO_CELL], [[0.0; 8]]);
        self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut weights)?;
        let Some(cell) = self.cell_at(id[0], place) else { return Ok(Vec3::zeros()) };
        let corners = self.region.cell_corners[cell].iter().zip(&weights[0]);
        Ok(corners.fold(Vec3::zeros(), |sum, (&n, w)| {
            let key = (self.region.node_id[n as usize], self.region.node_copy[n as usize]);
            self.kept.get(&key).map_or(sum, |kept| sum + *w * *kept)
        }))
    }

    /// m, how far the nodes carry a rest place; `None` where no active cell does.
    ///
    /// # Errors
    /// What the grid says.
    pub fn carried_by(&self, place: Vec3, nodes: &Nodes) -> Result<Option<Vec3>, LatticeError> {
        let (mut id, mut weights) = ([abi::NO_CELL], [[0.0; 8]]);
        self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut weights)?;
        match self.cell_at(id[0], place) {
            Some(_) => Ok(Some(self.embed_point(place, nodes)?.0 - place)),
            None => Ok(None),
        }
    }

    /// Samples of an active cell, or of the part of one.
    pub fn samples_of(&self, samples: &Samples, cell: u32) -> std::ops::Range<usize> {
        let id = self.region.cell_id[cell as usize];
        samples.of_cell(id, self.region.cell_fragment[cell as usize], self.fragments.has(id))
    }

    /// Whether a blade has come near any cell.
    pub fn has_cuts(&self) -> bool {
        self.fragments.ids().next().is_some()
    }

    /// Where the nodes carry one rest place, and where they would if they were at rest. A place that no active cell carries
    /// stays.
    ///
    /// # Errors
    /// What the grid says.
    pub fn embed_point(&self, place: Vec3, nodes: &Nodes) -> Result<(Vec3, Vec3), LatticeError> {
        let (mut id, mut weights) = ([abi::NO_CELL], [[0.0; 8]]);
        self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut weights)?;
        let Some(cell) = self.cell_at(id[0], place) else { return Ok((place, place)) };
        let at = |field: &[Vec3]| -> Result<Vec3, LatticeError> {
            if self.grid.is_nonlinear() {
                let (corners, mut out) = ([self.corners(cell as u32, field)], [[0.0; 3]]);
                self.grid.place(self.settings.level, &[place.into()], cast_slice(&corners), &mut out)?;
                return Ok(out[0].into());
            }
            let corners = self.region.cell_corners[cell].iter().zip(&weights[0]);
            Ok(corners.fold(place, |sum, (&n, w)| sum + *w * (field[n as usize] - self.grid_rest(n))))
        };
        Ok((at(&nodes.x)?, at(&nodes.rest)?))
    }

    /// Brings the points of one cell up to date.
    ///
    /// # Errors
    /// What the grid says.
    pub fn embed(&mut self, cell: u32, nodes: &Nodes, model: &Model, skin: &mut Skin) -> Result<(), LatticeError> {
        if self.grid.is_nonlinear() {
            return self.embed_nonlinear(cell, nodes, model, skin);
        }
        let first = self.set_weights(cell, model)?;
        // Displacements, not positions: a point whose nodes are at rest keeps its very bits.
        let corners = self.region.cell_corners[cell as usize];
        let moved = corners.map(|n| nodes.x[n as usize] - nodes.rest[n as usize]);
        for (i, &v) in self.points(cell)?.iter().enumerate() {
            let weights = &self.weights[first + i];
            let u: Vec3 = weights.iter().zip(&moved).map(|(w, u)| *w * *u).sum();
            skin.x[v as usize] = skin.settled[v as usize] + u;
            skin.pages.mark(v);
        }
        Ok(())
    }

    /// Brings every active point up to date.
    ///
    /// # Errors
    /// What the grid says.
    pub fn embed_all(
        &mut self,
        _pool: &Pool,
        nodes: &Nodes,
        model: &Model,
        skin: &mut Skin,
    ) -> Result<(), LatticeError> {
        (0..self.region.cell_id.len() as u32).try_for_each(|cell| {
            if self.points(cell)?.is_empty() { Ok(()) } else { self.embed(cell, nodes, model, skin) }
        })
    }

    /// Where the weights of a cell's points start; computed when first asked for.
    pub(super) fn set_weights(&mut self, cell: u32, model: &Model) -> Result<usize, LatticeError> {
        let known = self.weights_of[cell as usize];
        if known != NO_WEIGHTS {
            return Ok(known as usize);
        }
        let first = self.weights.len();
        let mut scratch = std::mem::take(&mut self.scratch);
        let points = self.points(cell)?;
        scratch.places.clear();
        scratch.places.extend(points.iter().map(|&v| self.bound_at(v, model.surface.points[v as usize])));
        scratch.cells.clear();
        scratch.cells.resize(points.len(), 0);
        self.weights.resize(first + scratch.places.len(), [0.0; 8]);
        let (places, cells) = (&scratch.places, &mut scratch.cells);
        self.grid.weights(self.settings.level, cast_slice(places), cells, &mut self.weights[first..])?;
        self.weights_of[cell as usize] = first as u32;
        self.scratch = scratch;
        Ok(first)
    }

    fn embed_nonlinear(
        &mut self,
        cell: u32,
        nodes: &Nodes,
        model: &Model,
        skin: &mut Skin,
    ) -> Result<(), LatticeError> {
        let mut s = std::mem::take(&mut self.scratch);
        let points = self.points(cell)?;
        s.places.clear();
        s.places.extend(points.iter().map(|&v| model.surface.points[v as usize]));
        s.now.resize(points.len(), Vec3::zeros());
        s.rest.resize(points.len(), Vec3::zeros());
        for (field, out) in [(&nodes.rest, &mut s.rest), (&nodes.x, &mut s.now)] {
            s.corners.clear();
            s.corners.resize(points.len(), self.corners(cell, field));
            self.grid.place(self.settings.level, cast_slice(&s.places), cast_slice(&s.corners), cast_slice_mut(out))?;
        }
        for (i, &v) in points.iter().enumerate() {
            let u = s.now[i] - s.rest[i];
            skin.x[v as usize] = skin.settled[v as usize] + u;
            skin.pages.mark(v);
        }
        self.scratch = s;
        Ok(())
    }

    /// Weighted nodes of rest places: `visit(place, node, weight)`. Places outside the active cells are passed over.
    ///
    /// # Errors
    /// What the grid says.
    pub fn stencils(
        &mut self,
        places: &[Vec3],
        weights: &mut Vec<[f64; 8]>,
        mut visit: impl FnMut(usize, u32, f64),
    ) -> Result<(), LatticeError> {
        let mut cells = std::mem::take(&mut self.scratch.cells);
        cells.clear();
        cells.resize(places.len(), abi::NO_CELL);
        weights.clear();
        weights.resize(places.len(), [0.0; 8]);
        let done = self.grid.weights(self.settings.level, cast_slice(places), &mut cells, weights);
        for (place, id) in cells.iter().enumerate() {
            let Some(cell) = self.cell_at(*id, places[place]) else { continue };
            for (node, weight) in self.region.cell_corners[cell].iter().zip(&weights[place]) {
                visit(place, *node, *weight);
            }
        }
        self.scratch.cells = cells;
        Ok(done?)
    }

    /// What loads (N) on rest places come to on the nodes, where the embedding is not linear: `visit(node, force)`.
    ///
    /// # Errors
    /// What the grid says.
    pub fn pull_back(
        &mut self,
        places: &[Vec3],
        loads: &[Vec3],
        nodes: &Nodes,
        mut visit: impl FnMut(u32, Vec3),
    ) -> Result<(), LatticeError> {
        for (place, load) in places.iter().zip(loads) {
            let (id, _) = self.grid.locate(self.settings.level, (*place).into())?;
            let Some(cell) = self.cell_at(id, *place) else { continue };
            let (corners, mut out) = ([self.corners(cell as u32, &nodes.x)], [[[0.0; 3]; 8]]);
            let (place, load) = ([(*place).into()], [(*load).into()]);
            self.grid.pull_back(self.settings.level, &place, cast_slice(&corners), &load, &mut out)?;
            for (node, f) in self.region.cell_corners[cell].iter().zip(out[0]) {
                visit(*node, f.into());
            }
        }
        Ok(())
    }
}
