//! The parts of a deformed model, each as a file of its own.

use crate::model::{ModelShape, NO_ROW, WrittenModel};
use pliant_engine::body::Body;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::{ObjDocument, Surface};
use std::io;
use std::path::Path;

/// A model in connected parts: faces of a part share vertices or are stitched, faces of two parts are not.
pub(crate) struct ModelParts {
    /// The whole model, as its own file has it.
    document: ObjDocument,
    /// Part of each face (f), counted in the order of their first faces.
    part_of: Vec<u32>,
}

impl ModelParts {
    /// The parts of a body as it is now. Faces that a cut has made get the material `cap_material`; `name` is the file of the whole.
    ///
    /// # Errors
    /// Those of [`ModelShape::write`].
    pub(crate) fn of(body: &Body, cap_material: &str, name: &Path) -> io::Result<Self> {
        let WrittenModel { bytes, row_of } = ModelShape::of(body).written(cap_material)?;
        let mut document = ObjDocument::parse(bytes, name).map_err(io::Error::other)?;
        let welds = body.model.document.welds().iter().map(|pair| pair.map(|vertex| row_of[vertex as usize]));
        document.weld(&welds.filter(|pair| !pair.contains(&NO_ROW)).collect::<Vec<_>>());
        let mut surface = Surface::from_document(&document);
        // Vertices that the file does not have follow its rows: a stitch may hold two faces together by such a vertex.
        let rows = surface.points.len();
        surface.points.resize(rows + row_of.len(), Vec3::zeros());
        let row = |vertex: u32| match row_of[vertex as usize] {
            NO_ROW => rows as u32 + vertex,
            row => row,
        };
        let joined: Vec<_> = body.joined_vertices().into_iter().map(|pair| pair.map(row)).collect();
        let mut part_of = vec![0; document.face_count()];
        let shells = surface.joined_shells(&joined, |_| false);
        surface.face_of.iter().zip(shells).for_each(|(face, part)| part_of[*face as usize] = part);
        Ok(Self { document, part_of })
    }

    /// Number of parts, at least 1.
    pub(crate) fn count(&self) -> u32 {
        self.part_of.iter().max().map_or(1, |last| last + 1)
    }

    /// Writes a part by its number.
    ///
    /// # Errors
    /// What `out` says.
    pub(crate) fn write(&self, part: u32, out: &mut impl io::Write) -> io::Result<()> {
        let is_kept: Vec<bool> = self.part_of.iter().map(|of| *of == part).collect();
        self.document.write_faces(&is_kept, out)
    }
}
