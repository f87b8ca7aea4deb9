//! The deformed model as a file.

use crate::atomic::{AtomicFile, error_at};
use pliant_engine::body::Body;
use pliant_mesh::obj::WriteError;
use pliant_mesh::{ObjDocument, Surface};
use std::io::{self, Write};
use std::path::Path;

/// Writes the OBJ document of a body with its deformed surface to a file. See [`write_model_to`].
///
/// # Errors
/// Fails for a vertex that cannot be written and with the error of the file system, each with the path.
pub fn write_model(body: &Body, cap_material: &str, path: &Path) -> io::Result<()> {
    let mut file = AtomicFile::create(path)?;
    write_model_to(body, cap_material, &mut file).map_err(|error| error_at(path, error))?;
    file.finish()
}

/// Writes the OBJ document of a body with its deformed surface. Lines of vertices that have not moved, and all other lines, stay byte for
/// byte; normals rotate with the faces around them. Faces of a sheet all of whose triangles are gone are left out, with vertices that no other uses. Faces that a cut has made inside of the body get the OBJ material `cap_material`.
///
/// # Errors
/// Fails for a vertex that cannot be written and with the errors of `out`.
pub fn write_model_to(body: &Body, cap_material: &str, out: &mut impl Write) -> io::Result<()> {
    if body.gone.is_empty() {
        return write_whole(body, cap_material, out);
    }
    let mut bytes = Vec::new();
    write_whole(body, cap_material, &mut bytes)?;
    let document = ObjDocument::parse(bytes, Path::new("model.obj")).map_err(io::Error::other)?;
    let written = Surface::from_document(&document);
    let mut is_kept = vec![false; document.face_count()];
    let of_face = written.face_of.iter().zip(0..);
    of_face.for_each(|(face, triangle)| is_kept[*face as usize] |= !body.gone.contains(triangle));
    document.write_faces(&is_kept, out)
}

/// Writes the document with all of its faces.
fn write_whole(body: &Body, cap_material: &str, out: &mut impl Write) -> io::Result<()> {
    let other = |error: WriteError| io::Error::other(error.to_string());
    let (model, skin) = (&body.model, &body.skin);
    let document = &model.document;
    if let Some(mesh) = body.cut.as_ref().filter(|mesh| mesh.depth() > 0) {
        return mesh.write(document, &skin.x, cap_material, out).map_err(other);
    }
    let points = model.placement.bring_back(document.positions(), &model.surface.points, &skin.x);
    document.write_deformed(&points, out).map_err(other)
}
