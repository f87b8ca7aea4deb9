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
        let (path, message) = (self.path.clone(), message.into());
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
    let whole =
        |message: String| SceneError { path: path.to_path_buf(), line: 0, column: 0, excerpt: String::new(), message };
    let bytes = std::fs::read(path).map_err(|e| whole(format!("cannot be read: {e}")))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
        whole(format!("line {line} is not UTF-8 text; a scene is a TOML file"))
    })?;
    let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
    let mut source = Source { path: path.to_path_buf(), text };
    if !set.is_empty() {
        source.text = set::apply(&source, set)?;
    }
    let scene: Scene = toml::from_str(&source.text)
        .map_err(|e| source.error(e.span().unwrap_or(0..0), e.message().trim().replace('\n', " ")))?;
    if *scene.format.get_ref() != FORMAT {
        let found = scene.format.get_ref();
        return Err(source.error(scene.format.span(), format!("format {found}; this program reads format {FORMAT}")));
    }
    Ok((scene, source))
}
