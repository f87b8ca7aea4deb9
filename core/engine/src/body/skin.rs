//! Where the surface is.

use pliant_mesh::geometry::TriangleTree;
use pliant_solver::Vec3;

use super::model::Model;
use super::pages::PageStamps;
use std::sync::Arc;

/// The cell of a vertex that no cell of the region carries.
pub const NOT_CARRIED: u32 = u32::MAX;

/// Current positions of the surface.
///
/// A vertex in a cell of the region follows its nodes, but only when asked: a step needs those near the tools, a picture
/// needs all. Every other vertex is settled and costs nothing.
pub struct Skin {
    /// m, as of the last embedding of each vertex (n x 3)
    pub x: Vec<Vec3>,
    /// Where each vertex is when its nodes are at rest (n x 3); shared with what can be undone, copied when it changes, m.
    pub settled: Arc<Vec<Vec3>>,
    /// Place in the region of the cell that carries each vertex, or [`NOT_CARRIED`] (n)
    pub cell: Vec<u32>,
    /// Over the settled surface; copied when it changes, if other sessions have it too.
    pub tree: Arc<TriangleTree>,
    /// Which vertices have moved, for viewers.
    pub pages: PageStamps,
}

impl Skin {
    /// At rest; `tree` is the one over the model's surface as it was handed in.
    pub fn new(model: &Model, tree: Arc<TriangleTree>) -> Self {
        let settled = model.surface.points.clone();
        let (x, cell) = (settled.clone(), vec![NOT_CARRIED; settled.len()]);
        Self { x, cell, settled: Arc::new(settled), tree, pages: PageStamps::default() }
    }

    /// Has as many vertices as `settled`, which is where those of the model are now at rest; those that were there stand
    /// where they stood. `moved` are the triangles that are new or elsewhere, `gone` those that are no more.
    pub fn take_cut(&mut self, model: &Model, settled: Arc<Vec<Vec3>>, moved: &[u32], gone: std::ops::Range<u32>) {
        let known = self.x.len().min(settled.len());
        self.x.truncate(known);
        self.x.extend_from_slice(&settled[known..]);
        (known..settled.len()).for_each(|v| self.pages.mark(v as u32));
        self.cell.resize(settled.len(), NOT_CARRIED);
        self.settled = settled;
        let tree = Arc::make_mut(&mut self.tree);
        gone.for_each(|t| tree.remove(t));
        for &t in moved.iter().filter(|t| !model.is_lid(**t)) {
            tree.set(t, model.surface.triangles[t as usize].map(|v| self.settled[v as usize]));
        }
    }

    /// Forgets which cells carry it, and stands at rest.
    pub fn settle(&mut self) {
        for (v, (x, settled)) in self.x.iter_mut().zip(self.settled.iter()).enumerate() {
            if x != settled {
                *x = *settled;
                self.pages.mark(v as u32);
            }
        }
        self.cell.fill(NOT_CARRIED);
    }

    /// Corners of a triangle as of their last embedding.
    pub fn corners(&self, model: &Model, triangle: u32) -> [Vec3; 3] {
        model.surface.triangles[triangle as usize].map(|v| self.x[v as usize])
    }

    /// A point of a triangle as of its last embedding.
    pub fn point(&self, model: &Model, triangle: u32, bary: Vec3) -> Vec3 {
        interpolate(self.corners(model, triangle), bary)
    }
}

/// `sum b x`
pub fn interpolate(corners: [Vec3; 3], bary: Vec3) -> Vec3 {
    bary[0] * corners[0] + bary[1] * corners[1] + bary[2] * corners[2]
}
