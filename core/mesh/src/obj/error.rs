//! What can be wrong with an OBJ file, said so that a person can find the line and mend it.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why there is no document.
#[derive(Debug, Error)]
pub enum ObjError {
    /// The file cannot be read at all.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file asked for.
        file: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// The file is read, and a line of it is not usable.
    #[error("{}:{line}: {problem}", file.display())]
    Line {
        /// The file, as named by the caller.
        file: PathBuf,
        /// From 1; the last line when something is missing from the whole file.
        line: u32,
        /// What is wrong there.
        problem: ObjProblem,
    },
}

/// What is wrong with a line. `entity` is the keyword of the line, `token` the text found, cut to 40 characters.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[expect(missing_docs, reason = "each message reads its fields out")]
pub enum ObjProblem {
    /// A number that is not finite, or no number at all.
    #[error("`{entity}`: `{token}` is not usable; allowed: a finite decimal number such as -1.5e-3")]
    Number { entity: &'static str, token: String },
    /// The line ends too early, as in a truncated file.
    #[error("`{entity}` has {found} numbers; allowed: {expected} (is the file cut short?)")]
    TooFew { entity: &'static str, found: usize, expected: usize },
    /// A weight of zero puts the vertex at infinity.
    #[error("`v` has the weight w = `{token}`; allowed: any finite w but 0")]
    ZeroWeight { token: String },
    /// A corner that is not `v`, `v/vt`, `v//vn` or `v/vt/vn` with whole numbers.
    #[error("`f` corner `{token}` is not usable; allowed: v, v/vt, v//vn or v/vt/vn with whole numbers")]
    Corner { token: String },
    /// An index that names nothing. Positive ones may point further down the file, negative ones only up.
    #[error("`f` corner `{token}`: there is no such {entity}; allowed: {}", range(*count))]
    Index { entity: &'static str, token: String, count: usize },
    /// A face without an area.
    #[error("`f` has {found} corners; allowed: 3 or more")]
    FewCorners { found: usize },
    /// A face that meets itself.
    #[error("`f` names vertex {vertex} twice; allowed: each vertex once in a face")]
    RepeatedVertex { vertex: usize },
    /// Bytes that no text has.
    #[error("a NUL byte: this is a binary file or UTF-16 text; allowed: OBJ text in UTF-8 or Latin-1")]
    Nul,
    /// Offsets would not fit.
    #[error("the file has {bytes} bytes; allowed: less than {}", u32::MAX)]
    TooLarge { bytes: usize },
    /// Nothing in it.
    #[error("the file is empty; allowed: one `v` and one `f` line at least")]
    Empty,
    /// No `v` line.
    #[error("the file has no vertices; allowed: one `v` line at least")]
    NoVertices,
    /// No `f` line.
    #[error("the file has {vertices} vertices but no faces; allowed: one `f` line at least")]
    NoFaces { vertices: usize },
}

/// Why a document was not written, or its normals not turned.
#[derive(Debug, Error)]
pub enum WriteError {
    /// An array does not belong to this document.
    #[error("{found} {entity} given; the document has {expected}")]
    Length {
        /// What the array holds.
        entity: &'static str,
        /// Number of rows given.
        found: usize,
        /// Rows of the document.
        expected: usize,
    },
    /// A coordinate that no OBJ reader takes.
    #[error("{entity} {index} is {value:?}; allowed: finite numbers")]
    NotFinite {
        /// `v` or `vn`.
        entity: &'static str,
        /// From 1, as in the file.
        index: usize,
        /// What was given.
        value: [f64; 3],
    },
    /// The system could not take the bytes.
    #[error("cannot write: {0}")]
    Io(#[from] io::Error),
}

/// The token as a message shows it.
pub(super) fn shorten(token: &[u8]) -> String {
    const MOST: usize = 40; // characters
    let text = String::from_utf8_lossy(&token[..token.len().min(4 * MOST)]);
    let mut short: String = text.chars().take(MOST).collect();
    if short.len() < token.len() && text.chars().count() > MOST {
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
