//! The program's own catalogues and their scenes, or somebody else's.

use crate::outcome::Failure;
use std::collections::BTreeMap;
use std::path::Path;

/// Cases of accuracy.
pub const ACCURACY: &str = include_str!("cases/accuracy.toml");

/// What stability is asked of.
pub const STABILITY: &str = include_str!("cases/stability.toml");

/// What performance times.
pub const PERFORMANCE: &str = include_str!("cases/performance.toml");

/// Scenes by name, each a file that `pliant run` takes as it is.
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
    ("hertz", include_str!("../../../scenes/hertz.toml")),
];

/// A catalogue and what its scenes are read from.
pub struct Source {
    /// The catalogue.
    pub catalogue: String,
    own: BTreeMap<String, String>,
}

impl Source {
    /// The program's own, or a file with its scenes beside it.
    pub fn new(file: Option<&Path>, own: &str) -> Result<Self, Failure> {
        let Some(path) = file else { return Ok(Self { catalogue: own.to_owned(), own: BTreeMap::new() }) };
        let read =
            |path: &Path| std::fs::read_to_string(path).map_err(|e| Failure::input(format!("{}: {e}", path.display())));
        let mut scenes = BTreeMap::new();
        let folder = path.parent().unwrap_or(Path::new("."));
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        for entry in std::fs::read_dir(folder)?.flatten() {
            let (file, at) = (entry.file_name(), entry.path());
            if let Some(name) = file.to_string_lossy().strip_suffix(".toml").filter(|_| at != path) {
                scenes.insert(name.to_owned(), read(&at)?);
            }
        }
        Ok(Self { catalogue: read(path)?, own: scenes })
    }

    /// The text of a scene: a file beside the catalogue, or one of the program's own.
    pub fn scene(&self, name: &str) -> Option<&str> {
        let built_in = || SCENES.iter().find(|(known, _)| *known == name).map(|(_, text)| *text);
        self.own.get(name).map(String::as_str).or_else(built_in)
    }
}
