//! A place on a triangle of a surface, and how it follows the triangle's corners.
//!
//! Between its corners a triangle is flat, whatever the cells under it do. Where triangles are coarse against the cells the surface that is
//! seen and felt is theirs, so a contact on one is carried by its corners, and its load goes to them: by the transpose.

use crate::body::{Body, LatticeError, NOT_CARRIED, interpolate};
use pliant_solver::Vec3;

/// A place on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnTriangle {
    /// Index of the triangle.
    pub triangle: u32,
    /// Weights of its corners, sum 1.
    pub bary: Vec3,
    /// Where that is in the model as it was given, m: tells whether the triangle is still the same after a cut or an undo.
    place: Vec3,
}

impl OnTriangle {
    /// A place on a triangle whose corners were at `corners`, m, in the model as it was given.
    pub fn new(triangle: u32, bary: Vec3, corners: [Vec3; 3]) -> Self {
        Self { triangle, bary, place: interpolate(corners, bary) }
    }

    /// Vertices of the triangle; `None` once it is another one.
    fn vertices(&self, body: &Body) -> Option<[u32; 3]> {
        let vertices = *body.model.surface.triangles.get(self.triangle as usize)?;
        (interpolate(corners_of(body, vertices), self.bary) == self.place).then_some(vertices)
    }

    /// Where its corners carry the place, and where they would if all nodes were at rest, m; `None` once the triangle is another one.
    ///
    /// # Errors
    /// A grid that fails.
    pub fn carry(&self, body: &mut Body) -> Result<Option<(Vec3, Vec3)>, LatticeError> {
        let Some(vertices) = self.vertices(body) else { return Ok(None) };
        let Body { discretization, model, skin, system, .. } = body;
        let Some(lattice) = discretization.lattice_mut() else { return Ok(None) };
        for v in vertices {
            let cell = skin.cell[v as usize];
            if cell != NOT_CARRIED {
                lattice.embed(cell, &system.nodes, model, skin)?;
            }
        }
        let settled = vertices.map(|v| skin.settled[v as usize]);
        Ok(Some((skin.point(model, self.triangle, self.bary), interpolate(settled, self.bary))))
    }

    /// Corners of a triangle that is wider than a cell, m, in the model as it was given; `None` for a finer one.
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
