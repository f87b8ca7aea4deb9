//! The deformed model as a file.

use super::atomic::{AtomicFile, with_path};
use pliant_engine::body::Body;
use std::io;
use std::path::Path;

/// Writes the document of a body with its surface as it is now: lines of vertices that are where they were, and every other
/// line, come back byte for byte; normals turn with the faces around them. Faces inside of a body that a blade has made get
/// the material `cap`.
///
/// # Errors
/// What the file system says, with the path.
pub fn write_model(body: &Body, cap: &str, path: &Path) -> io::Result<()> {
    let (model, skin) = (&body.model, &body.skin);
    let document = &model.document;
    if let Some(mesh) = body.cut.as_ref().filter(|mesh| mesh.depth() > 0) {
        let mut file = AtomicFile::create(path)?;
        let other = |e: pliant_mesh::obj::WriteError| with_path(path, io::Error::other(e.to_string()));
        mesh.write(document, &skin.x, None, cap, &mut file).map_err(other)?;
        return file.finish();
    }
    let points = model.placement.bring_back(document.positions(), &model.surface.points, &skin.x);
    let other = |e: pliant_mesh::obj::WriteError| with_path(path, io::Error::other(e.to_string()));
    let normals = if document.normals().is_empty() {
        None
    } else {
        Some(document.deformed_normals(document.positions(), &points).map_err(other)?)
    };
    let mut file = AtomicFile::create(path)?;
    document.write(&points, normals.as_deref(), &mut file).map_err(other)?;
    file.finish()
}
