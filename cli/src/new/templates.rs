//! The files of a new project: their paths in the project and their contents.

use crate::args::{Language, NewKind};

/// The C header of the plugin interface.
const HEADER: &str = include_str!("../../../plugin-api/include/pliant.h");
/// A scene that uses the plugin.
const SCENE: &str = include_str!("../../templates/scene.toml.txt");
/// Build results and outputs, for `.gitignore`.
const IGNORE: &str = "/target\n/out\n*.so\n*.dylib\n*.dll\n";

/// The end of the source file of a C or C++ plugin, the same for all kinds: parameters, instances and the entry of the library.
const TAIL: &str = include_str!("../../templates/tail.c.txt");

/// Path and content of each file, both with placeholders (`@NAME@` and so on).
pub fn files(kind: NewKind, language: Language) -> Vec<(&'static str, String)> {
    let mut files = vec![("scene.toml", SCENE.to_owned()), (".gitignore", IGNORE.to_owned())];
    if language == Language::Rust {
        let plugin = match kind {
            NewKind::Material => include_str!("../../templates/material.rs.txt"),
            NewKind::Grid => include_str!("../../templates/grid.rs.txt"),
            NewKind::Device => include_str!("../../templates/device.rs.txt"),
            NewKind::ContactLaw => include_str!("../../templates/contact-law.rs.txt"),
        };
        files.push(("src/lib.rs", plugin.to_owned()));
        files.push(("rustfmt.toml", "max_width = 120\nuse_small_heuristics = \"Max\"\n".to_owned()));
        files.push(("Cargo.toml", include_str!("../../templates/Cargo.toml.txt").to_owned()));
        files.push(("README.md", include_str!("../../templates/README.rust.txt").to_owned()));
        files.push(("tests/conformance.rs", include_str!("../../templates/conformance.rs.txt").to_owned()));
        if kind == NewKind::Material {
            files.push(("tests/physics.rs", include_str!("../../templates/physics.rs.txt").to_owned()));
        }
        return files;
    }
    let plugin = match kind {
        NewKind::Material => include_str!("../../templates/material.c.txt"),
        NewKind::Grid => include_str!("../../templates/grid.c.txt"),
        NewKind::Device => include_str!("../../templates/device.c.txt"),
        NewKind::ContactLaw => include_str!("../../templates/contact-law.c.txt"),
    };
    files.push(("src/@SNAKE@.@EXT@", format!("{plugin}{TAIL}")));
    files.push(("include/pliant.h", HEADER.to_owned()));
    files.push(("tests/count-malloc.c", include_str!("../../templates/count-malloc.c.txt").to_owned()));
    files.push(("Makefile", include_str!("../../templates/Makefile.txt").to_owned()));
    files.push(("README.md", include_str!("../../templates/README.c.txt").to_owned()));
    files
}
