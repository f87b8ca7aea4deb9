//! The deformed model as a file.

use super::atomic::{AtomicFile, with_path};
use crate::body::{Model, Skin};
use std::io;
use std::path::Path;

/// Writes the document of `model` with the surface of `skin` in it: lines of vertices that are where they were, and every
/// other line, come back byte for byte; normals turn with the faces around them.
///
/// # Errors
/// What the file system says, with the path.
pub fn write_model(model: &Model, skin: &Skin, path: &Path) -> io::Result<()> {
    let document = &model.document;
    let points = model.placement.bring_back(document.positions(), &model.surface.points, &skin.x);
    let other = |e: crate::mesh::obj::WriteError| with_path(path, io::Error::other(e.to_string()));
    let normals = if document.normals().is_empty() {
        None
    } else {
        Some(document.deformed_normals(document.positions(), &points).map_err(other)?)
    };
    let mut file = AtomicFile::create(path)?;
    document.write(&points, normals.as_deref(), &mut file).map_err(other)?;
    file.finish()
}
