//! The parts of a deformed model, each as a file of its own.

use crate::model::write_model_to;
use pliant_engine::body::Body;
use pliant_mesh::{ObjDocument, Surface};
use std::io;
use std::path::Path;

/// A model that hangs together in parts: faces of a part share vertices or are stitched, faces of two parts are not.
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
    /// Those of [`write_model_to`].
    pub(crate) fn of(body: &Body, cap_material: &str, name: &Path) -> io::Result<Self> {
        let mut bytes = Vec::new();
        write_model_to(body, cap_material, &mut bytes)?;
        let document = ObjDocument::parse(bytes, name).map_err(io::Error::other)?;
        let surface = Surface::from_document(&document);
        let mut part_of = vec![0; document.face_count()];
        let shells = surface.joined_shells(&body.joined_vertices());
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
