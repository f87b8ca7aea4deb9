//! How a body's triangles look: what a viewer needs besides places.

use super::{Body, Model};
use pliant_cut::CutMesh;
use pliant_mesh::obj::Corner;

/// Stands for an absent row of texture coordinates or normals, and for an absent material.
pub const ABSENT: u32 = u32::MAX;
/// Material of the surface that a cut has made inside of a body.
pub const CAP: u32 = u32::MAX - 1;

/// A triangle as a viewer draws it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleLook {
    /// Vertices, counter-clockwise seen from outside.
    pub corners: [u32; 3],
    /// Texture coordinates of the corners; 0 where the file has none.
    pub texture: [[f32; 2]; 3],
    /// Row of the file's normals at each corner, or [`ABSENT`]: corners of one vertex with different rows form a hard edge.
    pub shading: [u32; 3],
    /// Face of the document it is a part of; triangles of one face have no visible edge between them. The number of faces for a
    /// cap.
    pub face: u32,
    /// Index into the document's materials, [`CAP`], or [`ABSENT`].
    pub material: u32,
}

impl Body {
    /// How a triangle looks; `None` for one that is not seen: a lid over a hole, or past the last.
    pub fn look(&self, triangle: u32) -> Option<TriangleLook> {
        self.model.look(triangle, self.cut.as_deref().filter(|mesh| mesh.depth() > 0))
    }
}

impl Model {
    /// How a triangle looks, by the mesh a blade has cut if it has; `None` as for [`Body::look`].
    pub fn look(&self, triangle: u32, cut: Option<&CutMesh>) -> Option<TriangleLook> {
        let document = &self.document;
        let corners = *self.surface.triangles.get(triangle as usize)?;
        if self.is_lid(triangle) {
            return None;
        }
        let face = self.surface.face_of[triangle as usize];
        let of_document = document.face(face as usize);
        let material = of_document.map_or(CAP, |face| face.attributes.material.unwrap_or(ABSENT));
        if let Some(mesh) = cut {
            let (texture, shading) = mesh.corner_rows(triangle);
            let place = |row: u32| mesh.texcoords().get(row as usize).map_or([0.0; 2], |at| at.map(|c| c as f32));
            return Some(TriangleLook { corners, texture: texture.map(place), shading, face, material });
        }
        let of_face = of_document.map_or(&[][..], |face| face.corners);
        let corner = |vertex: u32| of_face.iter().find(|corner| corner.v == vertex);
        let place = |corner: Option<&Corner>| {
            let row = corner.and_then(Corner::vt).and_then(|row| document.texcoords().get(row as usize));
            row.map_or([0.0; 2], |at| at.map(|c| c as f32))
        };
        let texture = corners.map(|vertex| place(corner(vertex)));
        let shading = corners.map(|vertex| corner(vertex).and_then(Corner::vn).unwrap_or(ABSENT));
        Some(TriangleLook { corners, texture, shading, face, material })
    }
}
