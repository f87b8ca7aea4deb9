//! Proximity search: the points of a surface that a tool may touch.
//!
//! A tool whose features are larger than the cells of the grid is tested against samples of the surface, a smaller one against triangles, of
//! which few are in its reach. Both are found through the cells that embed them: each has a bounding box of
//! all it may embed, and one whose box is out of reach has no point in reach. Parts of the surface that no active cell embeds are at rest and found in
//! the triangle tree.

use super::triangle_point::TrianglePoint;
use crate::body::{Body, LatticeError, Model, NOT_EMBEDDED, NodeBounds, Samples, Skin, interpolate};
use crate::shape::OrientedShape;
use nalgebra::Matrix3;
use pliant_mesh::geometry::{Closest, closest_point};
use pliant_plugin_api::abi;
use pliant_solver::Vec3;

/// A point of a surface near a tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Index of its body.
    pub body: u32,
    /// Current position, m.
    pub point: Vec3,
    /// Position in the model as loaded, m.
    pub rest: Vec3,
    /// Normal in the rest shape, not normalised.
    pub normal: Vec3,
    /// Distance from the centre of the search, m.
    pub distance: f64,
    /// Area of a sample, m^2; 0 for a point of a triangle.
    pub area: f64,
    /// Stiffness of the elastic layer at a sample, relative to that of its body; 1 for a point of a triangle.
    pub layer_factor: f64,
    /// The triangle it is on; `None` for a sample.
    pub triangle: Option<TrianglePoint>,
    /// Number of the sample among those of its body; 0 for a point of a triangle.
    pub sample: u32,
}

/// A query for surface points within `margin` of a shape, or of a point.
#[derive(Clone, Copy)]
pub struct Query<'a> {
    /// Centre of the shape, m.
    pub centre: Vec3,
    /// Largest distance from the shape, m.
    pub margin: f64,
    /// The shape; `None` to measure the distance from the centre.
    pub shape: Option<&'a OrientedShape>,
    /// Largest displacement of a node since the last query, m.
    pub moved: f64,
    /// Whether no node has moved since the last query.
    pub is_repeated: bool,
}

impl Query<'_> {
    /// Radius of a ball around the centre that contains every point within the margin, m.
    pub fn reach(&self) -> f64 {
        self.shape.map_or(self.margin, |shape| shape.shape().bounding_radius() + self.margin)
    }

    /// Whether a point, whose distance from the centre (m) is given, is within the margin.
    fn is_near(&self, point: Vec3, distance: f64) -> bool {
        let beyond =
            |shape: &OrientedShape| !shape.shape().is_round() && shape.distance(point - self.centre) > self.margin;
        distance <= self.reach() && !self.shape.is_some_and(beyond)
    }

    /// The point of a triangle closest to the shape.
    fn closest(&self, corners: [Vec3; 3]) -> Closest {
        match self.shape {
            Some(shape) => shape.closest_on_triangle(self.centre, corners),
            None => closest_point(self.centre, corners),
        }
    }

    /// A vector from a point towards the shape, not normalised.
    fn towards(&self, point: Vec3) -> Vec3 {
        match self.shape {
            Some(shape) => shape.towards(point - self.centre),
            None => self.centre - point,
        }
    }
}

/// The proximity search of one tool in one body, with its buffers.
#[derive(Default)]
pub struct ProximitySearch {
    /// Triangles to be tested (buffer).
    candidates: Vec<u32>,
    /// Cells the tool may reach, valid until the motion uses up `slack`.
    cells: Vec<u32>,
    /// Motion of tool and nodes for which `cells` is still valid, m; negative if it is outdated.
    slack: f64,
    /// Centre of the last query, m.
    centre: Vec3,
    /// +1 if the tool is on the outer side of the surface, -1 if on the inner side, 0 without contact.
    side: f64,
    /// Interpolation weights of the samples of the listed cells, cell by cell.
    weights: Vec<[f64; 8]>,
    /// Index in `weights` of the first sample of each listed cell.
    weights_of: Vec<usize>,
    /// Current positions of the samples of the listed cells, m, cell by cell.
    carried: Vec<Vec3>,
    /// Cofactors of the deformation gradient of each listed cell, which turn normals.
    turns: Vec<Matrix3<f64>>,
    /// Bounds of the nodes' displacements (buffer).
    bounds: NodeBounds,
}

/// [`depth_on_side`] of the surface of the file.
pub const SKIN_DEPTH: f64 = 1e-6;
/// The same of a cut surface, which is beside the path of the blade by less than that once it was refined.
const CAP_DEPTH: f64 = 0.05;
/// Stretch of edges, relative to the rest shape, that the search allows for: a triangle whose edges grow more could be missed between its
/// vertices.
const STRETCH: f64 = 1.5;

impl ProximitySearch {
    /// Invalidates the list of cells, as after a change of the body's cells.
    pub fn invalidate(&mut self) {
        self.slack = -1.0;
    }

    /// Ends the contact, so that the tool may next touch either side of the surface.
    pub fn leave(&mut self) {
        self.side = 0.0;
    }

    /// Lists the surface cells in reach of a query if the list is outdated, with a margin for the length of edges if `edges` is set. Returns
    /// whether the list is new.
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
        self.bounds.list(lattice, &body.system.nodes);
        // A cut makes surface in cells inside of the body too.
        let has_cuts = lattice.has_cuts();
        for cell in 0..region.cell_id.len() as u32 {
            let is_surface = u32::from(region.cell_state[cell as usize]) == abi::CELL_SURFACE;
            let is_cut = has_cuts && lattice.is_cut(region.cell_id[cell as usize]);
            if !is_surface && !is_cut {
                continue;
            }
            let longest = if edges { STRETCH * lattice.longest_edge(cell) } else { 0.0 };
            let reach = reach + self.slack + longest;
            let [low, high] = self.bounds.of_cell(cell, lattice, &body.system.nodes);
            let apart: f64 = (0..3).map(|i| (low[i] - centre[i]).max(centre[i] - high[i]).max(0.0).powi(2)).sum();
            if apart <= reach * reach {
                self.cells.push(cell);
            }
        }
        true
    }

    /// Adds the samples of body number `index` to `out` that are within the margin and face the tool.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn samples(
        &mut self,
        index: u32,
        body: &mut Body,
        samples: &Samples,
        query: &Query<'_>,
        out: &mut Vec<SurfacePoint>,
    ) -> Result<(), LatticeError> {
        let is_new = self.list_cells(query, body, false);
        if is_new {
            self.interpolate(body, samples)?;
        }
        if is_new || !query.is_repeated {
            self.place(body, samples)?;
        }
        let Some(lattice) = body.discretization.lattice() else { return Ok(()) };
        let first = out.len();
        let mut closest = (f64::INFINITY, 0.0);
        let side = self.side;
        for (at, &cell) in self.cells.iter().enumerate() {
            let (turn, begin) = (self.turns[at], self.weights_of[at]);
            let layer_factor = body.layer_factor(lattice, cell);
            for (i, s) in lattice.samples_of(samples, cell).enumerate() {
                let point = self.carried[begin + i];
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
                out.push(SurfacePoint {
                    body: index,
                    point,
                    rest,
                    normal,
                    distance,
                    area,
                    layer_factor,
                    triangle: None,
                    sample: s as u32,
                });
            }
        }
        self.side = if side == 0.0 { closest.1 } else { side };
        let side = self.side;
        let mut kept = first;
        for i in first..out.len() {
            if out[i].area * side > 0.0 {
                out[kept] = SurfacePoint { area: out[i].area.abs(), ..out[i] };
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
            lattice.weights_in(cell, &samples.place[range], &mut self.weights[begin..])?;
        }
        Ok(())
    }

    /// Computes the current positions of the samples of the listed cells.
    fn place(&mut self, body: &mut Body, samples: &Samples) -> Result<(), LatticeError> {
        self.carried.clear();
        self.turns.clear();
        let nodes = &body.system.nodes;
        let Some(lattice) = body.discretization.lattice_mut() else { return Ok(()) };
        lattice.forget_jets();
        for (&cell, &begin) in self.cells.iter().zip(&self.weights_of) {
            let range = lattice.samples_of(samples, cell);
            if range.is_empty() {
                self.turns.push(Matrix3::identity());
                continue;
            }
            self.turns.push(lattice.normal_turn(cell, nodes));
            let weights = &self.weights[begin..begin + range.len()];
            lattice.embed_places(cell, &samples.place[range], weights, nodes, &mut self.carried)?;
        }
        Ok(())
    }

    /// Adds the closest point of each triangle of body number `index` within the margin to `out`.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn triangles(
        &mut self,
        index: u32,
        body: &mut Body,
        query: &Query<'_>,
        out: &mut Vec<SurfacePoint>,
    ) -> Result<(), LatticeError> {
        let fresh = self.list_cells(query, body, true);
        let (centre, reach, moved) = (query.centre, query.reach(), query.moved);
        let Body { discretization, model, skin, system, failed_triangles, .. } = body;
        let Some(lattice) = discretization.lattice_mut() else { return Ok(()) };
        if fresh || moved > 0.0 {
            lattice.forget_jets();
            self.cells.iter().try_for_each(|&cell| lattice.embed_cell(cell, &system.nodes, model, skin))?;
        }
        self.candidates.clear();
        let candidates = &mut self.candidates;
        skin.tree.near(centre, reach, |t| candidates.push(t));
        let mut look_around = |v: u32, skin: &Skin| {
            let d = skin.x[v as usize] - centre;
            if d.norm_squared() <= (reach + STRETCH * model.longest_edge(v)).powi(2) {
                candidates.extend_from_slice(model.around(v));
            }
        };
        for &cell in &self.cells {
            lattice.points(cell)?.iter().for_each(|v| look_around(*v, skin));
        }
        failed_triangles.exposed().vertices().for_each(|v| look_around(v, skin));
        candidates.sort_unstable();
        candidates.dedup();
        candidates.retain(|t| !failed_triangles.contains(*t));
        for &triangle in candidates.iter() {
            let vertices = model.surface.triangles[triangle as usize];
            for v in vertices {
                let cell = skin.cell[v as usize];
                if cell != NOT_EMBEDDED && !self.cells.contains(&cell) {
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
                let depth = depth_on_side(model, triangle) * lattice.edge();
                let triangle = Some(TrianglePoint::new(triangle, found.bary, corners));
                let rest =
                    if lattice.has_cuts() || lattice.has_failed_cells() { inward(rest, normal, depth) } else { rest };
                out.push(SurfacePoint {
                    body: index,
                    point: found.point,
                    rest,
                    normal,
                    distance,
                    area: 0.0,
                    layer_factor: 1.0,
                    triangle,
                    sample: 0,
                });
            }
        }
        Ok(())
    }
}

/// How far a point of a triangle is moved inwards to lie strictly on one side of all cuts, in cell edges.
pub fn depth_on_side(model: &Model, triangle: u32) -> f64 {
    if model.is_cap(triangle) { CAP_DEPTH } else { SKIN_DEPTH }
}

/// Moves a surface point inwards by `depth`. `rest` and `depth` are in m.
pub fn inward(rest: Vec3, normal: Vec3, depth: f64) -> Vec3 {
    let length = normal.norm();
    if length > 0.0 { rest - depth / length * normal } else { rest }
}

/// Normal of a triangle; its length is twice the area, m^2.
pub fn normal_of(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    (b - a).cross(&(c - a))
}
