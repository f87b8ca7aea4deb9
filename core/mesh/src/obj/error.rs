//! Errors of OBJ files, with the line and the remedy.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Error of reading an OBJ file.
#[derive(Debug, Error)]
pub enum ObjError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// Path of the file.
        file: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A line of the file is invalid.
    #[error("{}:{line}: {problem}", file.display())]
    Line {
        /// The file, as named by the caller.
        file: PathBuf,
        /// Line, from 1; the last line if something is missing in the whole file.
        line: u32,
        /// What is wrong with the line, and what is allowed.
        problem: ObjProblem,
    },
}

/// Problem of a line. `entity` is the keyword of the line, `token` the text found, truncated to 40 characters.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[expect(missing_docs, reason = "each message reads its fields out")]
pub enum ObjProblem {
    /// A token is not a finite number.
    #[error("`{entity}`: `{token}` is not usable; allowed: a finite decimal number such as -1.5e-3")]
    Number { entity: &'static str, token: String },
    /// The line ends too early, as in a truncated file.
    #[error("`{entity}` has {found} numbers; allowed: {expected} (is the file cut short?)")]
    TooFew { entity: &'static str, found: usize, expected: usize },
    /// A weight of zero puts the vertex at infinity.
    #[error("`v` has the weight w = `{token}`; allowed: any finite w but 0")]
    ZeroWeight { token: String },
    /// A corner is not `v`, `v/vt`, `v//vn` or `v/vt/vn` with integers.
    #[error("`f` corner `{token}` is not usable; allowed: v, v/vt, v//vn or v/vt/vn with whole numbers")]
    Corner { token: String },
    /// An index is out of range. Positive indices may refer to later lines, negative ones to earlier lines only.
    #[error("`f` corner `{token}`: there is no such {entity}; allowed: {}", range(*count))]
    Index { entity: &'static str, token: String, count: usize },
    /// A face has fewer than 3 corners.
    #[error("`f` has {found} corners; allowed: 3 or more")]
    FewCorners { found: usize },
    /// A face has a vertex twice.
    #[error("`f` names vertex {vertex} twice; allowed: each vertex once in a face")]
    RepeatedVertex { vertex: usize },
    /// The file has NUL bytes.
    #[error("a NUL byte: this is a binary file or UTF-16 text; allowed: OBJ text in UTF-8 or Latin-1")]
    Nul,
    /// The file is too large for 32-bit offsets.
    #[error("the file has {bytes} bytes; allowed: less than {}", u32::MAX)]
    TooLarge { bytes: usize },
    /// The file is empty.
    #[error("the file is empty; allowed: one `v` and one `f` line at least")]
    Empty,
    /// The file has no `v` line.
    #[error("the file has no vertices; allowed: one `v` line at least")]
    NoVertices,
    /// The file has no `f` line.
    #[error("the file has {vertices} vertices but no faces; allowed: one `f` line at least")]
    NoFaces { vertices: usize },
}

/// Error of writing a document.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The number of rows of an array differs from that of the document.
    #[error("{found} {entity} given; the document has {expected}")]
    Length {
        /// Content of the array.
        entity: &'static str,
        /// Number of rows given.
        found: usize,
        /// Rows of the document.
        expected: usize,
    },
    /// A coordinate is not finite.
    #[error("{entity} {index} is {value:?}; allowed: finite numbers")]
    NotFinite {
        /// `v` or `vn`.
        entity: &'static str,
        /// Number of the row, from 1, as in the file.
        index: usize,
        /// The given coordinates.
        value: [f64; 3],
    },
    /// The file cannot be written; what the system says.
    #[error("cannot write: {0}")]
    Io(#[from] io::Error),
}

/// A token for messages, truncated.
pub(super) fn shorten(token: &[u8]) -> String {
    const MAX_CHARACTERS: usize = 40; // characters
    let text = String::from_utf8_lossy(&token[..token.len().min(4 * MAX_CHARACTERS)]);
    let mut short: String = text.chars().take(MAX_CHARACTERS).collect();
    if short.len() < token.len() && text.chars().count() > MAX_CHARACTERS {
        short.push('…');
    }
    short
}

fn range(count: usize) -> String {
    match count {
        0 => "none, as the file has none".into(),
        1 => "1 or -1".into(),
        _ => format!("1 to {count}, or -1 to -{count} counting back from this line"),
    }
}
