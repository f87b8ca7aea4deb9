//! Whether the materials a document names can be found.
//!
//! The materials themselves travel as `usemtl` bytes; nothing here is needed to edit or to write. So what is missing
//! is a warning, never an error.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::ObjDocument;

/// A material some `usemtl` line names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MaterialUse {
    /// As on the `usemtl` line.
    pub name: String,
    /// Whether a readable library defines it.
    pub found: bool,
}

/// What a viewer of this document will miss.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MaterialWarning {
    /// A library is not there or not readable.
    #[error("material library {}: {reason}", library.display())]
    Library {
        /// Where it was looked for.
        library: PathBuf,
        /// What the reader says.
        reason: String,
    },
    /// No readable library defines a material in use.
    #[error("material `{name}` is in none of the {libraries} readable material libraries")]
    Material {
        /// As on the `usemtl` line.
        name: String,
        /// How many libraries were read.
        libraries: usize,
    },
}

/// Every material in use, in the order of [`ObjDocument::materials`], and what is missing. Reads the `mtllib` files
/// beside the document.
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

/// `mtllib` may name several files, and writers put names with blanks there unquoted: the whole line goes first.
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
