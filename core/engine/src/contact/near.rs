//! What of a surface a tool may touch.
//!
//! A tool whose features are large against the cells of the grid meets samples; a smaller tool meets triangles, of which it can reach
//! few. Both are looked up through the cells that carry them: a point lies in the hull of its cell's eight corners, so a
//! cell whose box is out of reach holds none that is within. What is settled and not carried is found in the tree.

use super::on_triangle::OnTriangle;
use crate::body::Samples;
use crate::body::{Body, LatticeError, NOT_CARRIED, interpolate};
use crate::shape::OrientedShape;
use nalgebra::Matrix3;
use pliant_mesh::geometry::{Closest, closest_point};
use pliant_plugin_api::abi;
use pliant_solver::Vec3;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Index of its body.
    pub body: u32,
    /// Where it is, m.
    pub point: Vec3,
    /// Its place in the model as it was given, m.
    pub rest: Vec3,
    /// Normal there, in the rest shape; of no particular length
    pub normal: Vec3,
    /// Distance from the centre of the search, m.
    pub distance: f64,
    /// Area of a sample, m^2; 0 for a point of a triangle.
    pub area: f64,
    /// The triangle it is on; `None` for a sample.
    pub on: Option<OnTriangle>,
}

/// What is looked for: points within `margin` of a shape, or of a point.
#[derive(Clone, Copy)]
pub struct Query<'a> {
    /// Centre of the shape, m.
    pub centre: Vec3,
    /// Distance from the shape, m, that is near.
    pub margin: f64,
    /// The shape; `None` for the centre alone.
    pub shape: Option<&'a OrientedShape>,
    /// How far nodes may have moved since the last query, m.
    pub moved: f64,
}

impl Query<'_> {
    /// Radius of a ball around the centre that holds everything near, m.
    pub fn reach(&self) -> f64 {
        self.shape.map_or(self.margin, |shape| shape.shape().bounding_radius() + self.margin)
    }

    /// Whether a point at a distance from the centre, m, is near.
    fn is_near(&self, point: Vec3, distance: f64) -> bool {
        let beyond =
            |shape: &OrientedShape| !shape.shape().is_round() && shape.distance(point - self.centre) > self.margin;
        distance <= self.reach() && !self.shape.is_some_and(beyond)
    }

    /// The point of a triangle nearest to the shape.
    fn closest(&self, corners: [Vec3; 3]) -> Closest {
        match self.shape {
            Some(shape) => shape.closest_on_triangle(self.centre, corners),
            None => closest_point(self.centre, corners),
        }
    }

    /// From a point towards the shape.
    fn towards(&self, point: Vec3) -> Vec3 {
        match self.shape {
            Some(shape) => shape.towards(point - self.centre),
            None => self.centre - point,
        }
    }
}

/// The search in one body, with its buffers.
#[derive(Default)]
pub struct NearSurface {
    candidates: Vec<u32>,
    /// Cells a tool may reach soon, and how much motion, m, the list still stands for.
    cells: Vec<u32>,
    slack: f64,
    centre: Vec3,
    /// +1 if the tool is on the side the normals point to, -1 on the other, 0 while it touches nothing
    side: f64,
    /// Weights of the samples of each listed cell, and where they start.
    weights: Vec<[f64; 8]>,
    weights_of: Vec<usize>,
    carried: Vec<Vec3>,
}

/// Edges may have grown by this before a triangle could slip through between its vertices.
const STRETCH: f64 = 1.5;

impl NearSurface {
    /// The cells of the body have changed.
    pub fn forget(&mut self) {
        self.slack = -1.0;
    }

    /// The tool touches nothing, and may come to any side of the surface.
    pub fn leave(&mut self) {
        self.side = 0.0;
    }

    /// Lists the cells that a query may find something in, unless the last list still holds. Returns whether the list is new.
    fn list_cells(&mut self, query: &Query<'_>, body: &Body, edges: bool) -> bool {
        let (centre, reach, moved) = (query.centre, query.reach(), query.moved);
        let shift = centre - self.centre;
        self.slack -= moved + shift.norm();
        self.centre = centre;
        if self.slack >= 0.0 {
            return false;
        }
        let Some(lattice) = body.discretization.lattice() else { return false };
        self.slack = lattice.edge();
        self.cells.clear();
        let region = lattice.region();
        for cell in 0..region.cell_id.len() as u32 {
            if u32::from(region.cell_state[cell as usize]) != abi::CELL_SURFACE {
                continue;
            }
            let longest = if edges { STRETCH * lattice.longest_edge(cell) } else { 0.0 };
            let reach = reach + self.slack + longest;
            let corners = lattice.corners(cell, &body.system.nodes.x);
            let apart: f64 = (0..3)
                .map(|i| {
                    let low = corners.iter().fold(f64::INFINITY, |m, c| m.min(c[i]));
                    let high = corners.iter().fold(f64::NEG_INFINITY, |m, c| m.max(c[i]));
                    (low - centre[i]).max(centre[i] - high).max(0.0).powi(2)
                })
                .sum();
            if apart <= reach * reach {
                self.cells.push(cell);
            }
        }
        true
    }

    /// Adds the samples of body number `index` that are near and face the tool.
    ///
    /// # Errors
    /// A grid that fails.
    pub fn samples(
        &mut self,
        index: u32,
        body: &mut Body,
        samples: &Samples,
        query: &Query<'_>,
        out: &mut Vec<Near>,
    ) -> Result<(), LatticeError> {
        if self.list_cells(query, body, false) {
            self.interpolate(body, samples)?;
        }
        let Some(lattice) = body.discretization.lattice() else { return Ok(()) };
        let first = out.len();
        let mut closest = (f64::INFINITY, 0.0);
        let side = self.side;
        for (&cell, &begin) in self.cells.iter().zip(&self.weights_of) {
            let range = lattice.samples_of(samples, cell);
            if range.is_empty() {
                continue;
            }
            let moved = lattice.displacements(cell, &body.system.nodes);
            let turn = normal_turn(&moved, lattice.edge());
            let weights = &self.weights[begin..begin + range.len()];
            lattice.carry(cell, &samples.place[range.clone()], weights, &body.system.nodes, &mut self.carried)?;
            for (i, s) in range.enumerate() {
                let point = self.carried[i];
                let distance = (query.centre - point).norm();
                if !query.is_near(point, distance) {
                    continue;
                }
                let facing = (turn * samples.normal[s]).dot(&query.towards(point));
                if distance < closest.0 {
                    closest = (distance, facing.signum());
                }
                let area = if facing >= 0.0 { samples.area[s] } else { -samples.area[s] };
                let (rest, normal) = (samples.place[s], samples.normal[s]);
                out.push(Near { body: index, point, rest, normal, distance, area, on: None });
            }
        }
        self.side = if side == 0.0 { closest.1 } else { side };
        let side = self.side;
        let mut kept = first;
        for i in first..out.len() {
            if out[i].area * side > 0.0 {
                out[kept] = Near { area: out[i].area.abs(), ..out[i] };
                kept += 1;
            }
        }
        out.truncate(kept);
        Ok(())
    }

    /// Computes the interpolation weights of the samples of each listed cell.
    fn interpolate(&mut self, body: &mut Body, samples: &Samples) -> Result<(), LatticeError> {
        self.weights.clear();
        self.weights_of.clear();
        let Some(lattice) = body.discretization.lattice_mut() else { return Ok(()) };
        for &cell in &self.cells {
            let range = lattice.samples_of(samples, cell);
            let begin = self.weights.len();
            self.weights_of.push(begin);
            self.weights.resize(begin + range.len(), [0.0; 8]);
            lattice.weights_in(&samples.place[range], &mut self.weights[begin..])?;
        }
        Ok(())
    }

    /// Adds the nearest point of each near triangle of body number `index`.
    ///
    /// # Errors
    /// A grid that fails.
    pub fn triangles(
        &mut self,
        index: u32,
        body: &mut Body,
        query: &Query<'_>,
        out: &mut Vec<Near>,
    ) -> Result<(), LatticeError> {
        let fresh = self.list_cells(query, body, true);
        let (centre, reach, moved) = (query.centre, query.reach(), query.moved);
        let Body { discretization, model, skin, system, .. } = body;
        let Some(lattice) = discretization.lattice_mut() else { return Ok(()) };
        if fresh || moved > 0.0 {
            self.cells.iter().try_for_each(|&cell| lattice.embed(cell, &system.nodes, model, skin))?;
        }
        self.candidates.clear();
        let candidates = &mut self.candidates;
        skin.tree.near(centre, reach, |t| candidates.push(t));
        for &cell in &self.cells {
            for &v in lattice.points(cell)? {
                let d = skin.x[v as usize] - centre;
                if d.norm_squared() <= (reach + STRETCH * model.longest_edge(v)).powi(2) {
                    candidates.extend_from_slice(model.around(v));
                }
            }
        }
        candidates.sort_unstable();
        candidates.dedup();
        for &triangle in candidates.iter() {
            let vertices = model.surface.triangles[triangle as usize];
            for v in vertices {
                let cell = skin.cell[v as usize];
                if cell != NOT_CARRIED && !self.cells.contains(&cell) {
                    lattice.embed(cell, &system.nodes, model, skin)?;
                    self.cells.push(cell);
                }
            }
            let found = query.closest(skin.corners(model, triangle));
            let d = found.point - centre;
            let distance = d.norm();
            if query.is_near(found.point, distance) {
                let corners = vertices.map(|v| model.surface.points[v as usize]);
                let (rest, normal) = (interpolate(corners, found.bary), normal_of(corners));
                let on = Some(OnTriangle::new(triangle, found.bary, corners));
                let rest = if lattice.has_cuts() { inward(rest, normal, lattice.edge()) } else { rest };
                out.push(Near { body: index, point: found.point, rest, normal, distance, area: 0.0, on });
            }
        }
        Ok(())
    }
}

/// A place of the surface, moved in just far enough to tell on which side of a cut it is.
pub fn inward(rest: Vec3, normal: Vec3, edge: f64) -> Vec3 {
    let length = normal.norm();
    if length > 0.0 { rest - 1e-6 * edge / length * normal } else { rest }
}

/// Normal of a triangle, as long as twice its area.
pub fn normal_of(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    (b - a).cross(&(c - a))
}

/// How normals of the rest shape are turned in a cell with these displacements of its corners: the cofactors of its mean
/// deformation gradient.
fn normal_turn(moved: &[Vec3; 8], edge: f64) -> Matrix3<f64> {
    let mut f = Matrix3::identity();
    for (corner, u) in moved.iter().enumerate() {
        for axis in 0..3 {
            let sign = if corner >> axis & 1 == 1 { 0.25 } else { -0.25 };
            for i in 0..3 {
                f[(i, axis)] += sign * u[i] / edge;
            }
        }
    }
    let column = |i: usize| f.column(i).into_owned();
    let [a, b, c] = [column(0), column(1), column(2)];
    Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}
