//! Lookup of the materials a document uses.
//!
//! Editing and writing only copy the `usemtl` lines, so missing materials are warnings, never errors.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::ObjDocument;

/// A material used by a `usemtl` line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaterialUse {
    /// As on the `usemtl` line.
    pub name: String,
    /// Whether a readable library defines it.
    pub found: bool,
}

/// A missing library or material.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MaterialWarning {
    /// A library cannot be read.
    #[error("material library {}: {reason}", library.display())]
    Library {
        /// Path of the library.
        library: PathBuf,
        /// Error of the reader.
        reason: String,
    },
    /// No readable library defines a used material.
    #[error("material `{name}` is in none of the {libraries} readable material libraries")]
    Material {
        /// Name on the `usemtl` line.
        name: String,
        /// Number of libraries that were read.
        libraries: usize,
    },
}

/// All used materials, in the order of [`ObjDocument::materials`], and the missing ones. Reads the `mtllib` files in the folder of the document.
pub fn find_materials(document: &ObjDocument) -> (Vec<MaterialUse>, Vec<MaterialWarning>) {
    let folder = document.name().parent().unwrap_or(Path::new(""));
    let mut warnings = Vec::new();
    let mut defined = BTreeSet::new();
    let mut libraries = 0;
    for library in document.libraries().iter().flat_map(|names| paths(folder, names)) {
        match tobj::load_mtl(&library) {
            Ok((materials, _)) => {
                libraries += 1;
                defined.extend(materials.into_iter().map(|material| material.name));
            }
            Err(error) => warnings.push(MaterialWarning::Library { library, reason: error.to_string() }),
        }
    }
    let uses = document.materials().iter().map(|name| {
        let found = defined.contains(name);
        if !found {
            warnings.push(MaterialWarning::Material { name: name.clone(), libraries });
        }
        MaterialUse { name: name.clone(), found }
    });
    (uses.collect(), warnings)
}

/// Candidate paths of an `mtllib` line. It may name several files, or one file whose name has unquoted blanks, so the whole line is tried first.
fn paths(folder: &Path, names: &str) -> Vec<PathBuf> {
    let whole = folder.join(names);
    if whole.is_file() { vec![whole] } else { names.split_whitespace().map(|name| folder.join(name)).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_libraries_and_materials_are_warnings() {
        let folder = tempfile::tempdir().unwrap();
        let text = "mtllib two words.mtl\nmtllib a.mtl gone.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n\
            usemtl red\nf 1 2 3\nusemtl blue\nf 1 3 2\nusemtl green\nf 2 3 1\n";
        std::fs::write(folder.path().join("two words.mtl"), "newmtl red\nKd 1 0 0\n").unwrap();
        std::fs::write(folder.path().join("a.mtl"), "newmtl green\nKd 0 1 0\n").unwrap();
        let document = ObjDocument::parse(text.into(), &folder.path().join("model.obj")).unwrap();
        let (uses, warnings) = find_materials(&document);
        let found: Vec<_> = uses.iter().map(|material| (material.name.as_str(), material.found)).collect();
        assert_eq!(found, [("red", true), ("blue", false), ("green", true)]);
        let library = |warning: &MaterialWarning| matches!(warning, MaterialWarning::Library { .. });
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(library(&warnings[0]) && warnings[0].to_string().contains("gone.mtl"));
        assert_eq!(warnings[1], MaterialWarning::Material { name: "blue".into(), libraries: 2 });
    }
}
