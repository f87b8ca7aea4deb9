//! Models as programs write them whose vertices belong to one patch: in pieces that lie together.

use crate::ObjDocument;
use std::collections::HashMap;
use std::fmt::Write;

/// A document in pieces.
pub struct Apart {
    /// The OBJ file.
    pub text: String,
    /// The vertex of the whole document that each vertex is a copy of.
    pub copy_of: Vec<u32>,
}

/// A document with a copy of each vertex for each of its patches; `patch_of` numbers the patch of a face. The `v` lines of the whole have to be of one line each.
pub fn apart(whole: &ObjDocument, patch_of: impl Fn(usize) -> usize) -> Apart {
    let text = String::from_utf8_lossy(whole.bytes());
    let is = |line: &str, keyword: &str| line.split_whitespace().next() == Some(keyword);
    let rows: Vec<&str> = text.lines().filter(|line| is(line, "v")).collect();
    let (mut out, mut faces, mut copy_of) = (String::new(), Vec::new(), Vec::new());
    let mut copies: HashMap<(usize, u32), usize> = HashMap::new();
    for (index, face) in whole.faces().enumerate() {
        let mut line = "f".to_owned();
        for corner in face.corners {
            let next = copies.len();
            let row = *copies.entry((patch_of(index), corner.v)).or_insert(next);
            if row == next {
                writeln!(out, "{}", rows[corner.v as usize]).unwrap();
                copy_of.push(corner.v);
            }
            let row = row + 1;
            match (corner.vt().map(|vt| vt + 1), corner.vn().map(|vn| vn + 1)) {
                (Some(vt), Some(vn)) => write!(line, " {row}/{vt}/{vn}"),
                (Some(vt), None) => write!(line, " {row}/{vt}"),
                (None, Some(vn)) => write!(line, " {row}//{vn}"),
                (None, None) => write!(line, " {row}"),
            }
            .unwrap();
        }
        faces.push(line);
    }
    let mut faces = faces.into_iter();
    for line in text.lines().filter(|line| !is(line, "v")) {
        match is(line, "f") {
            true => writeln!(out, "{}", faces.next().unwrap_or_default()).unwrap(),
            false => writeln!(out, "{line}").unwrap(),
        }
    }
    Apart { text: out, copy_of }
}
