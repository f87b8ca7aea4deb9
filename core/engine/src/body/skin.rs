//! Positions of the surface of a body, at rest and at present.

use pliant_mesh::geometry::{TriangleTree, closest_point};
use pliant_solver::Vec3;

use super::model::Model;
use super::pages::PageStamps;
use std::sync::Arc;

/// Value of [`Skin::cell`] for a vertex that lies in no active cell.
pub const NOT_EMBEDDED: u32 = u32::MAX;

/// Positions of the vertices of a body.
///
/// A vertex in an active cell is updated on demand: a step updates those near tools, a viewer all. Every other vertex is at its
/// settled position and costs nothing.
pub struct Skin {
    /// Present positions, m, as of the last update of each vertex (n x 3).
    pub x: Vec<Vec3>,
    /// Positions while the nodes are at rest, m (n x 3); shared with saved states, copied on change.
    pub settled: Arc<Vec<Vec3>>,
    /// Active cell in which each vertex is embedded, as an index in the region, or [`NOT_EMBEDDED`] (n).
    pub cell: Vec<u32>,
    /// Tree over the triangles at their settled positions; shared with other sessions, copied on change.
    pub tree: Arc<TriangleTree>,
    /// Pages of vertices that have moved, for viewers.
    pub pages: PageStamps,
}

/// Positions of a material point of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmbeddedPoint {
    /// Present position, m.
    pub now: Vec3,
    /// Position with all nodes at rest, m: in the present rest shape, which edits can change.
    pub settled: Vec3,
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct NearestTriangle {
    pub triangle: u32,
    /// Barycentric coordinates of the point.
    pub bary: Vec3,
}

/// The point of a surface nearest to `point` (m), with vertices at `x` (m, n x 3); of several triangles the one with the lowest number.
/// It is looked for within `radius` first, and then within `largest` (both in m); `None` where no triangle is within that.
pub(crate) fn nearest_triangle(
    tree: &TriangleTree,
    model: &Model,
    x: &[Vec3],
    point: Vec3,
    radius: f64,
    largest: f64,
) -> Option<NearestTriangle> {
    let within = |reach: f64| {
        let mut best: Option<(f64, u32, Vec3)> = None;
        tree.near_within(point, reach, |t| {
            let closest = closest_point(point, model.surface.triangles[t as usize].map(|v| x[v as usize]));
            let distance = (closest.point - point).norm();
            if distance <= reach && best.is_none_or(|(least, of, _)| (distance, t) < (least, of)) {
                best = Some((distance, t, closest.bary));
            }
            best.map_or(reach, |(least, ..)| least)
        });
        best.map(|(_, triangle, bary)| NearestTriangle { triangle, bary })
    };
    within(radius).or_else(|| within(largest))
}

impl Skin {
    /// The surface of a model at rest; `tree` is the tree over it.
    pub fn new(model: &Model, tree: Arc<TriangleTree>) -> Self {
        let settled = model.surface.points.clone();
        let (x, cell) = (settled.clone(), vec![NOT_EMBEDDED; settled.len()]);
        Self { x, cell, settled: Arc::new(settled), tree, pages: PageStamps::default() }
    }

    /// Adopts the vertices of a model that was cut, or whose cut was undone. `settled` (m) has the position of each at rest; vertices that
    /// existed before keep their present position. `moved` lists triangles that are new or have other corners, `removed` those that no
    /// longer exist.
    pub fn take_cut(&mut self, model: &Model, settled: Arc<Vec<Vec3>>, moved: &[u32], removed: std::ops::Range<u32>) {
        let known = self.x.len().min(settled.len());
        self.x.truncate(known);
        self.x.extend_from_slice(&settled[known..]);
        (known..settled.len()).for_each(|v| self.pages.mark(v as u32));
        self.cell.resize(settled.len(), NOT_EMBEDDED);
        self.settled = settled;
        let tree = Arc::make_mut(&mut self.tree);
        removed.for_each(|t| tree.remove(t));
        for &t in moved.iter().filter(|t| !model.is_lid(**t)) {
            tree.set(t, model.surface.triangles[t as usize].map(|v| self.settled[v as usize]));
        }
    }

    /// Moves a vertex to a place (m). Only what moves is marked: a surface at rest is neither copied nor drawn again.
    pub fn place(&mut self, vertex: u32, to: Vec3) {
        if self.x[vertex as usize] != to {
            self.x[vertex as usize] = to;
            self.pages.mark(vertex);
        }
    }

    /// Moves all vertices to their settled positions, embedded in no cell.
    pub fn settle(&mut self) {
        for (v, (x, settled)) in self.x.iter_mut().zip(self.settled.iter()).enumerate() {
            if x != settled {
                *x = *settled;
                self.pages.mark(v as u32);
            }
        }
        self.cell.fill(NOT_EMBEDDED);
    }

    /// Moves vertices that no triangle has, because others are in their place, to those.
    pub fn follow_welds(&mut self, welds: &[[u32; 2]]) {
        for &[vertex, place] in welds {
            self.place(vertex, self.x[place as usize]);
        }
    }

    /// Moves the vertices that no active node moves to their settled positions.
    pub fn settle_inactive(&mut self) {
        for (v, (x, settled)) in self.x.iter_mut().zip(self.settled.iter()).enumerate() {
            if self.cell[v] == NOT_EMBEDDED && x != settled {
                *x = *settled;
                self.pages.mark(v as u32);
            }
        }
    }

    /// Makes the present positions of the vertices that no active node moves their settled ones.
    pub fn keep_inactive(&mut self, model: &Model) {
        let is_moved = |v: &usize| self.cell[*v] == NOT_EMBEDDED && self.x[*v] != self.settled[*v];
        let moved: Vec<usize> = (0..self.x.len()).filter(is_moved).collect();
        let settled = Arc::make_mut(&mut self.settled);
        moved.iter().for_each(|v| settled[*v] = self.x[*v]);
        let mut triangles: Vec<u32> = moved.iter().flat_map(|v| model.around(*v as u32)).copied().collect();
        triangles.sort_unstable();
        triangles.dedup();
        Arc::make_mut(&mut self.tree).refit(&self.settled, &model.surface.triangles, &triangles);
    }

    /// Present corners of a triangle, m, as of their last update.
    pub fn corners(&self, model: &Model, triangle: u32) -> [Vec3; 3] {
        model.surface.triangles[triangle as usize].map(|v| self.x[v as usize])
    }

    /// Present position of the point of a triangle with barycentric coordinates `bary`, m.
    pub fn point(&self, model: &Model, triangle: u32, bary: Vec3) -> Vec3 {
        interpolate(self.corners(model, triangle), bary)
    }
}

/// The point of a triangle with barycentric coordinates `bary`: the sum of the corners weighted by them.
pub fn interpolate(corners: [Vec3; 3], bary: Vec3) -> Vec3 {
    bary[0] * corners[0] + bary[1] * corners[1] + bary[2] * corners[2]
}

/// Centroid of a triangle.
pub(super) fn centroid(corners: [Vec3; 3]) -> Vec3 {
    interpolate(corners, Vec3::repeat(1.0 / 3.0))
}
