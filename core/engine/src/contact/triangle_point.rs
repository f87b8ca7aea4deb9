//! A point of a surface in barycentric coordinates of a triangle.
//!
//! A triangle stays flat between its corners, whatever the cells under it do. Where triangles are larger than cells, the surface that is drawn
//! and felt is that of the triangles, so a contact point moves with the corners of its triangle and its load is distributed to them by the
//! transpose of that interpolation.

use crate::body::{Body, EmbeddedPoint, LatticeError, NOT_EMBEDDED, interpolate};
use pliant_solver::Vec3;

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrianglePoint {
    /// Index of the triangle.
    pub triangle: u32,
    /// Barycentric coordinates; they add up to 1.
    pub bary: Vec3,
    /// Position in the model as loaded, m. If it differs, a cut or an undo has replaced the triangle.
    rest: Vec3,
}

impl TrianglePoint {
    /// The point with the barycentric coordinates `bary` of a triangle whose corners are at `corners` (m) in the model as loaded.
    pub fn new(triangle: u32, bary: Vec3, corners: [Vec3; 3]) -> Self {
        Self { triangle, bary, rest: interpolate(corners, bary) }
    }

    /// Vertices of the triangle; `None` if it has been replaced or has failed.
    fn vertices(&self, body: &Body) -> Option<[u32; 3]> {
        if body.failed_triangles.contains(self.triangle) {
            return None;
        }
        let vertices = *body.model.surface.triangles.get(self.triangle as usize)?;
        (interpolate(corners_of(body, vertices), self.bary) == self.rest).then_some(vertices)
    }

    /// Current position of the point and its position with all nodes at rest, m; `None` if the triangle has been replaced.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn positions(&self, body: &mut Body) -> Result<Option<EmbeddedPoint>, LatticeError> {
        let Some(vertices) = self.vertices(body) else { return Ok(None) };
        let Body { discretization, model, skin, system, .. } = body;
        let Some(lattice) = discretization.lattice_mut() else { return Ok(None) };
        for v in vertices {
            let cell = skin.cell[v as usize];
            if cell != NOT_EMBEDDED {
                lattice.embed(cell, &system.nodes, model, skin)?;
            }
        }
        let settled = vertices.map(|v| skin.settled[v as usize]);
        let now = skin.point(model, self.triangle, self.bary);
        Ok(Some(EmbeddedPoint { now, settled: interpolate(settled, self.bary) }))
    }

    /// Corners of the triangle in the model as loaded, m, if its longest edge is longer than a cell's; otherwise `None`.
    pub fn coarse_corners(&self, body: &Body) -> Option<[Vec3; 3]> {
        let corners = corners_of(body, self.vertices(body)?);
        let [a, b, c] = corners;
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        (longest > body.discretization.edge()).then_some(corners)
    }
}

fn corners_of(body: &Body, vertices: [u32; 3]) -> [Vec3; 3] {
    vertices.map(|v| body.model.surface.points[v as usize])
}
