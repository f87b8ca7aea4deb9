//! Reading a scene file, and saying where something in it is wrong.

use super::schema::Scene;
use super::set;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The version of the format this program reads.
const FORMAT: u32 = 1;

/// The text a scene came from.
#[derive(Clone, Debug)]
pub struct Source {
    /// The file.
    pub path: PathBuf,
    /// Its text, after `--set`.
    pub text: String,
    /// Whether `--set` changed it: lines may then have other numbers than in the file.
    pub changed: bool,
}

/// Something wrong with a scene: file, line, what was found, what is allowed.
#[derive(Debug, Error)]
pub struct SceneError {
    path: PathBuf,
    /// 1-based; 0: the whole file
    line: usize,
    column: usize,
    /// The line itself.
    excerpt: String,
    message: String,
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.line == 0 {
            return write!(f, "{}: {}", self.path.display(), self.message);
        }
        write!(f, "{}:{}:{}: {}", self.path.display(), self.line, self.column, self.message)?;
        if self.excerpt.trim().is_empty() {
            return Ok(());
        }
        write!(f, "\n  {:>4} | {}\n       | {:>width$}", self.line, self.excerpt, "^", width = self.column)
    }
}

impl SceneError {
    /// 1-based line, 0 for the whole file.
    pub fn line(&self) -> usize {
        self.line
    }
}

impl Source {
    /// An error at a span of the text. An empty span at the start is a default that stands nowhere.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> SceneError {
        let (path, mut message) = (self.path.clone(), message.into());
        if self.changed {
            message.push_str(" (as --set leaves the scene)");
        }
        if span == (0..0) {
            return SceneError { path, line: 0, column: 0, excerpt: String::new(), message };
        }
        let at = (0..=span.start.min(self.text.len())).rev().find(|&i| self.text.is_char_boundary(i)).unwrap_or(0);
        let before = &self.text[..at];
        let start = before.rfind('\n').map_or(0, |i| i + 1);
        let excerpt: String = self.text[start..].lines().next().unwrap_or_default().chars().take(160).collect();
        let column = self.text[start..at].chars().count() + 1;
        SceneError { path, line: before.matches('\n').count() + 1, column, excerpt, message }
    }

    /// An error about the scene as a whole.
    pub fn whole(&self, message: impl Into<String>) -> SceneError {
        self.error(0..0, message)
    }

    /// The folder paths in the scene are relative to.
    pub fn folder(&self) -> &Path {
        self.path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
    }
}

/// Reads a scene, with `set` (path, value) put in the place of what the file says.
///
/// # Errors
/// A file that cannot be read, is not TOML, or says something a scene cannot.
pub fn load(path: &Path, set: &[(String, String)]) -> Result<(Scene, Source), SceneError> {
    let mut source = Source { path: path.to_path_buf(), text: String::new(), changed: false };
    let bytes = std::fs::read(path).map_err(|e| source.whole(format!("cannot be read: {e}")))?;
    if let Err(error) = std::str::from_utf8(&bytes) {
        source.text = String::from_utf8_lossy(&bytes).into_owned();
        // As far as it is valid, the text is the same.
        let at = error.valid_up_to();
        return Err(source.error(at..at + 1, "not UTF-8 text; allowed is a TOML file in UTF-8"));
    }
    let text = String::from_utf8(bytes).expect("just looked");
    source.text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
    parse(source, set)
}

/// The same from a text that stood in `path`.
///
/// # Errors
/// A text that is not TOML, or says something a scene cannot.
pub fn load_text(path: &Path, text: String, set: &[(String, String)]) -> Result<(Scene, Source), SceneError> {
    parse(Source { path: path.to_path_buf(), text, changed: false }, set)
}

fn parse(mut source: Source, set: &[(String, String)]) -> Result<(Scene, Source), SceneError> {
    if !set.is_empty() {
        source.text = set::apply(&source, set)?;
        source.changed = true;
    }
    let scene: Scene = toml::from_str(&source.text).map_err(|e| source.error(place(&e), plain(e.message())))?;
    if *scene.format.get_ref() != FORMAT {
        let text = format!("format {}; allowed is {FORMAT}, the one this program reads", scene.format.get_ref());
        return Err(source.error(scene.format.span(), text));
    }
    Ok((scene, source))
}

/// Where the parser stopped: what is wrong with the first character is at the first line, what is missing nowhere.
fn place(error: &toml::de::Error) -> Range<usize> {
    let span = error.span().unwrap_or(0..0);
    let missing = error.message().starts_with("missing field");
    if span == (0..0) && !missing { 0..1 } else { span }
}

/// What the parser says, on one line and without the names of Rust's types.
fn plain(message: &str) -> String {
    let message = message.trim().replace('\n', " ");
    if message.contains("wanted string or table") {
        return "wrong type; allowed is a text".into();
    }
    message.replace("expected u32", "expected a whole number, 0 or more").replace("expected f64", "expected a number")
}
