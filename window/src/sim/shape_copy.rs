//! A copy of the shape of a session, so that it is written while the session goes on.
//!
//! A model of a million triangles takes seconds to write, its positions milliseconds to copy. The text of the file is copied once.

use pliant_engine::body::FailedTriangles;
use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::{ObjDocument, Placement};
use pliant_record::ModelShape;
use std::io;
use std::path::Path;
use std::sync::Arc;

/// The shape of the first body of a session that has not been cut.
pub(super) struct ShapeCopy {
    document: Arc<ObjDocument>,
    placement: Placement,
    /// m, vertices at rest in the file (n x 3)
    original: Vec<Vec3>,
    /// m, vertices now (n x 3)
    present: Vec<Vec3>,
    /// Triangles that have torn.
    failed_triangles: FailedTriangles,
    /// Whether it is a part of a body that was split.
    is_part: bool,
}

impl ShapeCopy {
    /// Copies the shape; `known` is the document of an earlier copy. `None` for a session of several bodies, and after a cut: then the mesh
    /// of the cut is needed too, which goes on changing.
    pub fn take(session: &Session, known: Option<&Arc<ObjDocument>>) -> Option<Self> {
        let [body] = &session.bodies[..] else { return None };
        if body.cut.as_ref().is_some_and(|mesh| mesh.depth() > 0) {
            return None;
        }
        let (model, present) = (&body.model, body.skin.x.clone());
        let document = known.map_or_else(|| Arc::new(model.document.clone()), Arc::clone);
        let (original, failed_triangles) = (model.surface.points.clone(), body.failed_triangles.clone());
        Some(Self {
            document,
            placement: model.placement,
            original,
            present,
            failed_triangles,
            is_part: model.is_part(),
        })
    }

    /// The document, for the next copy.
    pub fn document(&self) -> &Arc<ObjDocument> {
        &self.document
    }

    /// Writes the OBJ, as [`pliant_record::write_model`] does.
    ///
    /// # Errors
    /// What the file system says, and a vertex that cannot be written.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let Self { document, placement, original, present, failed_triangles, is_part } = self;
        let shape = ModelShape {
            document,
            placement: *placement,
            original,
            present,
            failed_triangles,
            cut: None,
            is_part: *is_part,
        };
        // Without a cut no face has its material.
        shape.write_file("", path)
    }
}
