//! Appearance of the triangles of a body, for viewers: texture coordinates, normals, faces and materials of the file.

use super::{Body, Model};
use pliant_cut::CutMesh;
use pliant_mesh::geometry::closest_point;
use pliant_mesh::obj::Corner;

/// Value of a row of normals or of a material that the file does not give.
pub const ABSENT: u32 = u32::MAX;
/// Material of caps, the surface that a cut has made inside of a body.
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
    /// Face of the document that the triangle is a part of; a viewer draws no edge between triangles of one face. The number of faces
    /// for a cap.
    pub face: u32,
    /// Index into the document's materials, [`CAP`], or [`ABSENT`].
    pub material: u32,
}

impl Body {
    /// Appearance of a triangle; `None` for a lid and for a triangle that has failed, which are not drawn, and for a number past the last triangle.
    pub fn look(&self, triangle: u32) -> Option<TriangleLook> {
        if self.failed_triangles.contains(triangle) {
            return None;
        }
        let mesh = self.cut.as_deref().filter(|mesh| mesh.depth() > 0);
        let look = self.model.look(triangle, mesh)?;
        match self.failed_triangles.exposed().piece_of(triangle) {
            Some(of) => Some(self.model.look_of_piece(look.corners, &self.model.look(of, mesh)?)),
            None => Some(look),
        }
    }
}

impl Model {
    /// Appearance of a piece with these corners of a triangle with appearance `of`: texture coordinates are interpolated, normals of the file are at its own corners alone.
    fn look_of_piece(&self, corners: [u32; 3], of: &TriangleLook) -> TriangleLook {
        let at = |v: u32| self.surface.points[v as usize];
        let of_corner = |v: u32| of.corners.iter().position(|corner| *corner == v);
        let texture = corners.map(|v| {
            let bary = closest_point(at(v), of.corners.map(at)).bary;
            [0, 1].map(|axis| (0..3).map(|i| bary[i] * f64::from(of.texture[i][axis])).sum::<f64>() as f32)
        });
        let shading = corners.map(|v| of_corner(v).map_or(ABSENT, |corner| of.shading[corner]));
        TriangleLook { corners, texture, shading, ..*of }
    }

    /// Appearance of a triangle, from the mesh `cut` if a blade has cut it; `None` as for [`Body::look`].
    pub fn look(&self, triangle: u32, cut: Option<&CutMesh>) -> Option<TriangleLook> {
        let document = &self.document;
        let corners = *self.surface.triangles.get(triangle as usize)?;
        if self.is_lid(triangle) {
            return None;
        }
        let face = self.surface.face_of[triangle as usize];
        let document_face = document.face(face as usize);
        let material = match document_face {
            Some(_) if self.is_cap_face(face) => CAP,
            Some(face) => face.attributes.material.unwrap_or(ABSENT),
            None => CAP,
        };
        // Faces that have come to light are not the cut mesh's.
        if let Some(mesh) = cut.filter(|mesh| (triangle as usize) < mesh.surface().triangles.len()) {
            let (texture, shading) = mesh.corner_rows(triangle);
            let texcoord = |row: u32| mesh.texcoords().get(row as usize).map_or([0.0; 2], |uv| uv.map(|c| c as f32));
            return Some(TriangleLook { corners, texture: texture.map(texcoord), shading, face, material });
        }
        let face_corners = document_face.map_or(&[][..], |face| face.corners);
        let corner = |vertex: u32| face_corners.iter().find(|corner| corner.v == vertex);
        let texcoord = |corner: Option<&Corner>| {
            let row = corner.and_then(Corner::vt).and_then(|row| document.texcoords().get(row as usize));
            row.map_or([0.0; 2], |uv| uv.map(|c| c as f32))
        };
        let texture = corners.map(|vertex| texcoord(corner(vertex)));
        let shading = corners.map(|vertex| corner(vertex).and_then(Corner::vn).unwrap_or(ABSENT));
        Some(TriangleLook { corners, texture, shading, face, material })
    }
}
