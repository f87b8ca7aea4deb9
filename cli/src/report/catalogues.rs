//! The program's own catalogues and their scenes, or those of a file.

use crate::outcome::Failure;
use pliant_mesh::read::read_text;
use std::collections::BTreeMap;
use std::path::Path;

/// Catalogue of the accuracy report.
pub const ACCURACY: &str = include_str!("cases/accuracy.toml");

/// Catalogue of the stability report.
pub const STABILITY: &str = include_str!("cases/stability.toml");

/// Catalogue of the performance report.
pub const PERFORMANCE: &str = include_str!("cases/performance.toml");

/// Scenes of the program by name, each a file that `pliant run` takes as it is.
const SCENES: &[(&str, &str)] = &[
    ("hanging-strip", include_str!("cases/hanging-strip.toml")),
    ("catenary", include_str!("cases/catenary.toml")),
    ("cantilever", include_str!("cases/cantilever.toml")),
    ("stretched-sheet", include_str!("cases/stretched-sheet.toml")),
    ("buckled-strip", include_str!("cases/buckled-strip.toml")),
    ("falling-strip", include_str!("cases/falling-strip.toml")),
    ("pendulum", include_str!("cases/pendulum.toml")),
    ("taut-strip", include_str!("cases/taut-strip.toml")),
    ("hanging-bar", include_str!("cases/hanging-bar.toml")),
    ("hung-sheet", include_str!("cases/hung-sheet.toml")),
    ("hung-block", include_str!("cases/hung-block.toml")),
    ("graded-strip", include_str!("cases/graded-strip.toml")),
    ("pressed-sheet", include_str!("cases/pressed-sheet.toml")),
    ("pressed-cloth", include_str!("cases/pressed-cloth.toml")),
    ("struck-sheet", include_str!("cases/struck-sheet.toml")),
    ("touched-block", include_str!("cases/touched-block.toml")),
    ("grab-twist", include_str!("cases/grab-twist.toml")),
    ("grab-bend", include_str!("cases/grab-bend.toml")),
    ("hertz", include_str!("../../../scenes/hertz.toml")),
];

/// A catalogue and its scenes.
pub struct CatalogueFiles {
    /// Text of the catalogue.
    pub catalogue: String,
    /// Texts of the scenes beside the catalogue, by name.
    scenes: BTreeMap<String, String>,
}

impl CatalogueFiles {
    /// Reads the catalogue in `file` and the scenes beside it; without a file it is `built_in`.
    pub fn read(file: Option<&Path>, built_in: &str) -> Result<Self, Failure> {
        let Some(path) = file else { return Ok(Self { catalogue: built_in.to_owned(), scenes: BTreeMap::new() }) };
        let read = |path: &Path| read_text(path).map_err(|e| Failure::input(format!("{}: {e}", path.display())));
        let mut scenes = BTreeMap::new();
        let folder = path.parent().unwrap_or(Path::new("."));
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        for entry in std::fs::read_dir(folder)?.flatten() {
            let (file, at) = (entry.file_name(), entry.path());
            if let Some(name) = file.to_string_lossy().strip_suffix(".toml").filter(|_| at != path) {
                scenes.insert(name.to_owned(), read(&at)?);
            }
        }
        Ok(Self { catalogue: read(path)?, scenes })
    }

    /// Text of a scene: of a file beside the catalogue, or of the program.
    pub fn scene(&self, name: &str) -> Option<&str> {
        let built_in = || SCENES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
        self.scenes.get(name).map(String::as_str).or_else(built_in)
    }
}
