//! The text of a scene, and errors with the line and column in it.

use super::text::SceneText;
use pliant_mesh::ObjDocument;
use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The text a scene came from.
#[derive(Clone, Debug)]
pub struct Source {
    /// Path of the scene file.
    pub path: PathBuf,
    /// Text of the file, with `--set` applied.
    pub text: SceneText,
    /// Whether `--set` changed the text; line numbers may then differ from the file's.
    pub changed: bool,
    /// Models that the caller provides instead of files, by the value of a body's `mesh`.
    pub documents: BTreeMap<String, ObjDocument>,
    /// Factors of vertices that the caller supplies instead of files, by the value of a field's `csv`.
    pub factors: BTreeMap<String, Vec<f64>>,
}

/// An error in a scene: file, line, value found, what is allowed.
#[derive(Debug, Error)]
pub struct SceneError {
    path: PathBuf,
    /// Line, from 1; 0 for an error of the file as a whole.
    line: usize,
    /// Column in characters, from 1.
    column: usize,
    /// Text of the line.
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
        // Only part of a long line is shown.
        let first = self.column.saturating_sub(BEFORE + 1);
        let shown: String = self.excerpt.chars().skip(first).take(BEFORE + AFTER).collect();
        write!(f, "\n  {:>4} | {shown}\n       | {:>width$}", self.line, "^", width = self.column - first)
    }
}

/// Characters of a line that are shown before an error.
const BEFORE: usize = 80;
/// Characters of a line that are shown from the error on.
const AFTER: usize = 40;

impl SceneError {
    /// Line, from 1; 0 for an error of the file as a whole.
    pub fn line(&self) -> usize {
        self.line
    }

    /// File, line and column as text, `scene.toml:12:3`; the file alone for an error of the file as a whole.
    pub fn place(&self) -> String {
        match self.line {
            0 => self.path.display().to_string(),
            line => format!("{}:{line}:{}", self.path.display(), self.column),
        }
    }

    /// The message without file, line and column.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl Source {
    /// A scene with this text, read from `path`.
    pub fn new(path: impl Into<PathBuf>, text: impl Into<SceneText>) -> Self {
        let (documents, factors) = (BTreeMap::new(), BTreeMap::new());
        Self { path: path.into(), text: text.into(), changed: false, documents, factors }
    }

    /// An error at a span of the text, in bytes. The span 0..0 is that of a default, which is not in the text: an error of the file as a whole.
    pub fn error(&self, span: Range<usize>, message: impl Into<String>) -> SceneError {
        let (path, mut message) = (self.path.clone(), message.into());
        if self.changed {
            message.push_str(" (as --set leaves the scene)");
        }
        if span == (0..0) {
            return SceneError { path, line: 0, column: 0, excerpt: String::new(), message };
        }
        let at = (0..=span.start.min(self.text.len())).rev().find(|&i| self.text.is_char_boundary(i)).unwrap_or(0);
        let (line, start) = self.text.line_of(at);
        let excerpt: String = self.text[start..].lines().next().unwrap_or_default().chars().take(160).collect();
        let column = self.text[start..at].chars().count() + 1;
        SceneError { path, line, column, excerpt, message }
    }

    /// An error of the file as a whole.
    pub fn whole(&self, message: impl Into<String>) -> SceneError {
        self.error(0..0, message)
    }

    /// The folder to which paths in the scene are relative.
    pub fn folder(&self) -> &Path {
        self.path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
    }
}
