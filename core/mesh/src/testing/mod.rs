//! What tests share: random numbers, small documents, and models as people bring them.

mod apart;
mod attributes;
mod images;
mod models;
mod random;
mod shape;
pub mod tet_data;
pub mod tetrahedra;

pub use apart::{Apart, apart};
pub use images::{grey_png, png, png_bytes};
pub use models::{TestModel, models, scan};
pub use random::Random;

use crate::ObjDocument;
use std::path::{Path, PathBuf};

/// Parses `text` as the file `test.obj`.
pub fn document(text: &str) -> ObjDocument {
    ObjDocument::parse(text.as_bytes().to_vec(), Path::new("test.obj")).unwrap()
}

/// A document without some of its faces.
pub fn without(whole: &ObjDocument, faces: &[usize]) -> ObjDocument {
    let mut face = 0;
    let text = String::from_utf8(whole.bytes().to_vec()).unwrap();
    let keep = |line: &&str| {
        face += usize::from(line.starts_with("f "));
        !(line.starts_with("f ") && faces.contains(&(face - 1)))
    };
    document(&text.lines().filter(keep).collect::<Vec<_>>().join("\n"))
}

/// The OBJ files of `../shared/meshes`, seen from the root of the repository. Tests that need them are ignored by default.
///
/// # Panics
/// If the folder is not there or holds no model.
pub fn shared_models() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes");
    let entries = folder.read_dir().unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut models: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    models.retain(|path| path.extension().is_some_and(|ext| ext == "obj"));
    models.sort();
    assert!(!models.is_empty(), "no models in {}", folder.display());
    models
}
