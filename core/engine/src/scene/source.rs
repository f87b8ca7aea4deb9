//! The text of a scene, and saying where something in it is wrong.

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
    /// Its text, after `--set`.
    pub text: String,
    /// Whether `--set` changed it: lines may then have other numbers than in the file.
    pub changed: bool,
    /// Models that the program hands over instead of files: a body has one if its `mesh` is the key.
    pub documents: BTreeMap<String, ObjDocument>,
    /// Factors of vertices that the program hands over instead of files: a field has them if its `csv` is the key.
    pub factors: BTreeMap<String, Vec<f64>>,
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
        // Of a long line what is around the place.
        let first = self.column.saturating_sub(BEFORE + 1);
        let shown: String = self.excerpt.chars().skip(first).take(BEFORE + AFTER).collect();
        write!(f, "\n  {:>4} | {shown}\n       | {:>width$}", self.line, "^", width = self.column - first)
    }
}

/// Characters of a line shown before and after the place of an error.
const BEFORE: usize = 80;
const AFTER: usize = 40;

impl SceneError {
    /// 1-based line, 0 for the whole file.
    pub fn line(&self) -> usize {
        self.line
    }

    /// File, and line and column unless the whole file is wrong: `scene.toml:12:3`.
    pub fn place(&self) -> String {
        match self.line {
            0 => self.path.display().to_string(),
            line => format!("{}:{line}:{}", self.path.display(), self.column),
        }
    }

    /// What is wrong there, without the place.
    pub fn message(&self) -> &str {
        &self.message
    }
}

impl Source {
    /// The text of the scene that stands in `path`.
    pub fn new(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        let (documents, factors) = (BTreeMap::new(), BTreeMap::new());
        Self { path: path.into(), text: text.into(), changed: false, documents, factors }
    }

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
