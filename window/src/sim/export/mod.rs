//! Writing models: OBJ as it came with what has moved, STL for printers, GLB for viewers and game engines.

mod glb;
mod stl;
mod together;

use glb::write_glb;
use pliant_engine::session::Session;
use pliant_record::write_model;
use std::io;
use std::path::{Path, PathBuf};
use stl::write_stl;
pub use together::write_together;

/// A format of model files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelFormat {
    /// OBJ in the units of its own file; lines of what has not moved stay byte for byte.
    Obj,
    /// Binary STL in millimetres.
    Stl,
    /// Binary glTF in metres, with materials and textures.
    Glb,
}

impl ModelFormat {
    /// The format that the ending of a path asks for.
    pub fn of(path: &Path) -> Self {
        let is = |ending: &str| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(ending));
        if is("stl") {
            Self::Stl
        } else if is("glb") {
            Self::Glb
        } else {
            Self::Obj
        }
    }
}

/// Writes every body that moves, in the format of the path's ending: one GLB with all of them, or else the first to `path` and others beside it with
/// their names added. `materials`: folder of the `mtllib` files, if not that of each model. Gives a sentence for each material or texture that a GLB
/// lacks.
///
/// # Errors
/// What the file system says, with the path; and a GLB of more than 4 GiB.
pub fn write_bodies(
    session: &Session,
    cap_material: &str,
    materials: Option<&Path>,
    path: &Path,
) -> io::Result<Vec<String>> {
    let format = ModelFormat::of(path);
    if format == ModelFormat::Glb {
        return write_glb(session, cap_material, materials, path);
    }
    for (index, body) in session.bodies.iter().enumerate() {
        let file = if index == 0 { path.to_path_buf() } else { beside(path, &body.name) };
        if format == ModelFormat::Stl { write_stl(body, &file)? } else { write_model(body, cap_material, &file)? }
    }
    Ok(Vec::new())
}

/// The file of another body of the same scene.
fn beside(path: &Path, name: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}-{name}.{ending}"))
}
