//! Lookup of the materials a document uses.
//!
//! Editing and writing only copy the `usemtl` lines, so missing materials are warnings, never errors.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::ObjDocument;

/// A material used by a `usemtl` line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialUse {
    /// As on the `usemtl` line.
    pub name: String,
    /// Whether a readable library defines it.
    pub found: bool,
    /// Diffuse colour (`Kd`): red, green, blue, 0 to 1.
    pub diffuse: Option<[f32; 3]>,
    /// Image of the diffuse colour (`map_Kd`); relative paths are relative to the library's folder.
    pub diffuse_texture: Option<PathBuf>,
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
    find_materials_in(document, document.name().parent().unwrap_or(Path::new("")))
}

/// As [`find_materials`], with the `mtllib` files in `folder`, for a document that is a copy of a file there.
pub fn find_materials_in(document: &ObjDocument, folder: &Path) -> (Vec<MaterialUse>, Vec<MaterialWarning>) {
    let mut warnings = Vec::new();
    let mut defined = BTreeMap::new();
    let mut libraries = 0;
    for library in document.libraries().iter().flat_map(|names| paths(folder, names)) {
        match tobj::load_mtl(&library) {
            Ok((materials, _)) => {
                libraries += 1;
                let beside = library.parent().unwrap_or(folder);
                defined.extend(materials.into_iter().map(|material| {
                    let texture = material.diffuse_texture.as_deref().map(|line| beside.join(file_of(line)));
                    (material.name, (material.diffuse.map(|colour| colour.map(|c| c as f32)), texture))
                }));
            }
            Err(error) => warnings.push(MaterialWarning::Library { library, reason: error.to_string() }),
        }
    }
    let uses = document.materials().iter().map(|name| {
        let Some((diffuse, diffuse_texture)) = defined.get(name).cloned() else {
            warnings.push(MaterialWarning::Material { name: name.clone(), libraries });
            return MaterialUse { name: name.clone(), ..MaterialUse::default() };
        };
        MaterialUse { name: name.clone(), found: true, diffuse, diffuse_texture }
    });
    (uses.collect(), warnings)
}

/// Candidate paths of an `mtllib` line. It may name several files, or one file whose name has unquoted blanks, so the whole line is tried first.
fn paths(folder: &Path, names: &str) -> Vec<PathBuf> {
    let whole = folder.join(names);
    if whole.is_file() { vec![whole] } else { names.split_whitespace().map(|name| folder.join(name)).collect() }
}

/// The file of a `map_Kd` line: all of it, for names may have blanks, or behind options such as `-s 1 1 1` its last word. Backslashes separate folders.
fn file_of(line: &str) -> PathBuf {
    let line = line.trim();
    let name = if line.starts_with('-') { line.split_whitespace().last().unwrap_or(line) } else { line };
    name.replace('\\', "/").into()
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
        assert_eq!(uses[2].diffuse, Some([0.0, 1.0, 0.0]));
        let library = |warning: &MaterialWarning| matches!(warning, MaterialWarning::Library { .. });
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(library(&warnings[0]) && warnings[0].to_string().contains("gone.mtl"));
        assert_eq!(warnings[1], MaterialWarning::Material { name: "blue".into(), libraries: 2 });
    }
    #[test]
    fn textures_are_found_beside_their_library_behind_options_and_with_blanks() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("looks")).unwrap();
        let library =
            "newmtl a\nmap_Kd red brick.png\nnewmtl b\nKd 1 1 1\nmap_Kd -s 2 2 1 tex\\wood.jpg\nnewmtl c\nKd 0 0 1\n";
        std::fs::write(folder.path().join("looks/m.mtl"), library).unwrap();
        let text =
            "mtllib looks/m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 3 2\nusemtl c\nf 2 3 1\n";
        let document = ObjDocument::parse(text.into(), Path::new("elsewhere/copy.obj")).unwrap();
        let (uses, warnings) = find_materials_in(&document, folder.path());
        assert!(warnings.is_empty(), "{warnings:?}");
        let textures: Vec<_> = uses.iter().map(|material| material.diffuse_texture.clone()).collect();
        let beside = |name: &str| Some(folder.path().join("looks").join(name));
        assert_eq!(textures, [beside("red brick.png"), beside("tex/wood.jpg"), None]);
    }
}
