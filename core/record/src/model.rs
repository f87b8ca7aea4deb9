//! The deformed model as a file.

use crate::atomic::{AtomicFile, error_at};
use pliant_engine::body::Body;
use std::io;
use std::path::Path;

/// Writes the OBJ document of a body with its deformed surface. Lines of vertices that have not moved, and all other lines, stay byte for
/// byte; normals turn with the faces around them. Faces that a cut has made inside the body get the material `cap_material`.
///
/// # Errors
/// What the file system says, with the path.
pub fn write_model(body: &Body, cap_material: &str, path: &Path) -> io::Result<()> {
    let (model, skin) = (&body.model, &body.skin);
    let document = &model.document;
    if let Some(mesh) = body.cut.as_ref().filter(|mesh| mesh.depth() > 0) {
        let mut file = AtomicFile::create(path)?;
        let at_path = |e: pliant_mesh::obj::WriteError| error_at(path, io::Error::other(e.to_string()));
        mesh.write(document, &skin.x, None, cap_material, &mut file).map_err(at_path)?;
        return file.finish();
    }
    let points = model.placement.bring_back(document.positions(), &model.surface.points, &skin.x);
    let at_path = |e: pliant_mesh::obj::WriteError| error_at(path, io::Error::other(e.to_string()));
    let normals = if document.normals().is_empty() {
        None
    } else {
        Some(document.deformed_normals(document.positions(), &points).map_err(at_path)?)
    };
    let mut file = AtomicFile::create(path)?;
    document.write(&points, normals.as_deref(), &mut file).map_err(at_path)?;
    file.finish()
}
