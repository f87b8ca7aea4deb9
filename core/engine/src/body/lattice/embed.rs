//! How the surface follows the nodes, and how loads on it go back: by the transpose.

use super::smooth::{interpolate, weights};
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

    /// Adds to `out` where the nodes carry rest places of one cell, m. Slopes of the surface are those of the last
    /// [`Lattice::forget_slopes`].
    ///
    /// # Errors
    /// What the grid says.
    pub fn carry(
        &mut self,
        cell: u32,
        places: &[Vec3],
        trilinear: &[[f64; 8]],
        nodes: &Nodes,
        out: &mut Vec<Vec3>,
    ) -> Result<(), LatticeError> {
        if self.grid.is_nonlinear() {
            let corners = vec![self.corners(cell, &nodes.x); places.len()];
            let first = out.len();
            out.resize(first + places.len(), Vec3::zeros());
            return Ok(self.grid.place(
                self.settings.level,
                cast_slice(places),
                cast_slice(&corners),
                cast_slice_mut(&mut out[first..]),
            )?);
        }
        let places = places.iter().zip(trilinear);
        if let Some(smooth) = &mut self.smooth {
            let mut jets = smooth.moved_jets(&self.region, cell as usize, nodes);
            if !smooth.kept.is_empty() {
                jets = jets.plus(&smooth.kept_jets(&self.region, cell as usize));
            }
            out.extend(places.map(|(place, trilinear)| place + interpolate(&weights(trilinear), &jets)));
            return Ok(());
        }
        let moved = self.displacements(cell, nodes);
        let carried =
            |(place, weights): (&Vec3, &[f64; 8])| weights.iter().zip(&moved).fold(*place, |sum, (w, u)| sum + *w * *u);
        out.extend(places.map(carried));
        Ok(())
    }

    /// Declares slopes of the surface outdated: nodes have moved.
    pub fn forget_slopes(&mut self) {
        if let Some(smooth) = &mut self.smooth {
            smooth.forget();
        }
    }

    /// Adds to `out` what the points of an active cell move by where each node moves by what `field` (m, n x 3) says.
    ///
    /// # Errors
    /// What the grid says; not for a grid that is not linear.
    pub fn move_by(
        &mut self,
        cell: u32,
        field: &[Vec3],
        model: &Model,
        out: &mut Vec<Vec3>,
    ) -> Result<(), LatticeError> {
        let first = self.set_weights(cell, model)?;
        let weighed = &self.weights[first..first + self.points(cell)?.len()];
        if let Some(smooth) = &self.smooth {
            let jets = smooth.cell_jets(&self.region, cell as usize, |n| field[n as usize]);
            out.extend(weighed.iter().map(|trilinear| interpolate(&weights(trilinear), &jets)));
            return Ok(());
        }
        let corners = self.corners(cell, field);
        out.extend(weighed.iter().map(|weights| weights.iter().zip(&corners).map(|(w, u)| *w * *u).sum::<Vec3>()));
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
        let (mut id, mut trilinear) = ([abi::NO_CELL], [[0.0; 8]]);
        self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut trilinear)?;
        let Some(cell) = self.cell_at(id[0], place) else { return Ok(Vec3::zeros()) };
        if let Some(smooth) = &self.smooth {
            return Ok(interpolate(&weights(&trilinear[0]), &smooth.kept_jets(&self.region, cell)));
        }
        let corners = self.region.cell_corners[cell].iter().zip(&trilinear[0]);
        Ok(corners.fold(Vec3::zeros(), |sum, (&n, w)| {
            let key = (self.region.node_id[n as usize], self.region.node_copy[n as usize]);
            self.kept.get(&key).map_or(sum, |kept| sum + *w * kept.moved)
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
        let (mut id, mut trilinear) = ([abi::NO_CELL], [[0.0; 8]]);
        self.grid.weights(self.settings.level, &[place.into()], &mut id, &mut trilinear)?;
        let Some(cell) = self.cell_at(id[0], place) else { return Ok((place, place)) };
        if let Some(smooth) = &self.smooth {
            let weights = weights(&trilinear[0]);
            let kept = smooth.kept_jets(&self.region, cell);
            let moved = |n: u32| nodes.x[n as usize] - nodes.rest[n as usize];
            let moved = interpolate(&weights, &smooth.cell_jets(&self.region, cell, moved));
            let settled = place + interpolate(&weights, &kept);
            return Ok((settled + moved, settled));
        }
        let at = |field: &[Vec3]| -> Result<Vec3, LatticeError> {
            if self.grid.is_nonlinear() {
                let (corners, mut out) = ([self.corners(cell as u32, field)], [[0.0; 3]]);
                self.grid.place(self.settings.level, &[place.into()], cast_slice(&corners), &mut out)?;
                return Ok(out[0].into());
            }
            let corners = self.region.cell_corners[cell].iter().zip(&trilinear[0]);
            Ok(corners.fold(place, |sum, (&n, w)| sum + *w * (field[n as usize] - self.grid_rest(n))))
        };
        Ok((at(&nodes.x)?, at(&nodes.rest)?))
    }

    /// Brings the points of one cell up to date.
    ///
    /// # Errors
    /// What the grid says.
    pub fn embed(&mut self, cell: u32, nodes: &Nodes, model: &Model, skin: &mut Skin) -> Result<(), LatticeError> {
        self.forget_slopes();
        self.embed_cell(cell, nodes, model, skin)
    }

    /// [`Lattice::embed`] with the slopes of the surface as of the last [`Lattice::forget_slopes`], for several cells in a row.
    ///
    /// # Errors
    /// What the grid says.
    pub fn embed_cell(&mut self, cell: u32, nodes: &Nodes, model: &Model, skin: &mut Skin) -> Result<(), LatticeError> {
        if self.grid.is_nonlinear() {
            return self.embed_nonlinear(cell, nodes, model, skin);
        }
        let first = self.set_weights(cell, model)?;
        if let Some(smooth) = &mut self.smooth {
            let jets = smooth.moved_jets(&self.region, cell as usize, nodes);
            let is_still = jets.is_zero();
            for (i, &v) in self.points(cell)?.iter().enumerate() {
                // A point whose nodes are at rest keeps its very bits.
                let u = if is_still { Vec3::zeros() } else { interpolate(&weights(&self.weights[first + i]), &jets) };
                skin.x[v as usize] = skin.settled[v as usize] + u;
                skin.pages.mark(v);
            }
            return Ok(());
        }
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
        self.forget_slopes();
        (0..self.region.cell_id.len() as u32).try_for_each(|cell| {
            if self.points(cell)?.is_empty() { Ok(()) } else { self.embed_cell(cell, nodes, model, skin) }
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

    /// The active cells of rest places, `None` beside all of them, and the trilinear weights there.
    ///
    /// # Errors
    /// What the grid says.
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
        let done = self.grid.weights(self.settings.level, cast_slice(places), &mut ids, weights);
        cells.clear();
        cells.extend(ids.iter().zip(places).map(|(id, place)| self.cell_at(*id, *place).map(|cell| cell as u32)));
        self.scratch.cells = ids;
        Ok(done?)
    }

    /// What forces (N) at places that [`Lattice::find`] has found come to on the nodes, by the transpose of the embedding:
    /// `visit(node, force)`. Places beside all cells are passed over.
    pub fn spread(
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

    /// Visits the nodes that carry a place which [`Lattice::find`] has found, each with its share of the diagonal of a stiffness there.
    pub fn visit_stiffness_shares(&mut self, cell: u32, trilinear: &[f64; 8], mut visit: impl FnMut(u32, f64)) {
        if let Some(smooth) = &mut self.smooth {
            return smooth.visit_stiffness_shares(&self.region, cell as usize, &weights(trilinear), visit);
        }
        self.region.cell_corners[cell as usize].iter().zip(trilinear).for_each(|(node, w)| visit(*node, *w));
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
