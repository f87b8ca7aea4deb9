//! Writing a document with changed and added faces.
//!
//! New rows follow all rows of the document, so no index in the file changes its meaning; a face that uses them comes after them, as most readers require. Faces
//! after the last row of the file are changed in place; those before it move behind it, and their group, object, material and smoothing are repeated.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write};

use super::cursor::Cursor;
use super::write::{edits, same_length};
use super::{NONE, ObjDocument, WriteError, number};
use crate::geometry::Vec3;

/// Changes of a document. Indices of new rows continue those of the document.
#[derive(Clone, Debug, Default)]
pub struct Patch<'a> {
    /// New `v` rows (file units).
    pub positions: &'a [Vec3],
    /// Red, green and blue of the new `v` rows, 0 to 1; empty if they have none.
    pub colours: &'a [[f64; 3]],
    /// New `vt` rows.
    pub texcoords: &'a [[f64; 2]],
    /// New `vn` rows.
    pub normals: &'a [Vec3],
    /// Replacements of faces, by index: polygons of rows of positions, texture coordinates and normals, from 0; `u32::MAX` for none.
    pub faces: BTreeMap<u32, Vec<Vec<[u32; 3]>>>,
    /// Added faces, with their own group and material.
    pub added: Vec<[[u32; 3]; 3]>,
    /// Name of that group and material.
    pub name: &'a str,
}

/// The lines with the attributes of a face: group, object, material, smoothing.
type State<'a> = [Option<&'a [u8]>; 4];

/// A range of the document and its replacement.
struct Edit {
    from: usize,
    to: usize,
    text: Vec<u8>,
}

impl ObjDocument {
    /// Writes the document like [`ObjDocument::write`], with a patch. An empty patch changes nothing.
    ///
    /// # Errors
    /// As for [`ObjDocument::write`].
    pub fn write_patched(
        &self,
        positions: &[Vec3],
        normals: Option<&[Vec3]>,
        patch: &Patch<'_>,
        out: &mut impl Write,
    ) -> Result<(), WriteError> {
        if patch.faces.is_empty() && patch.added.is_empty() {
            return self.write(positions, normals, out);
        }
        let patch = &*self.patch_of_file(patch);
        if let Some(at) = patch.positions.iter().position(|row| !row.iter().all(|value| value.is_finite())) {
            let index = positions.len() + at + 1;
            return Err(WriteError::NotFinite { entity: "v", index, value: patch.positions[at].into() });
        }
        let mut all = self.coordinates(positions, normals)?;
        all.extend(self.statements(patch)?);
        all.sort_by_key(|edit| edit.from);
        let mut out = BufWriter::with_capacity(1 << 16, out);
        let mut done = 0;
        for edit in all {
            out.write_all(&self.bytes[done..edit.from])?;
            out.write_all(&edit.text)?;
            done = edit.to;
        }
        out.write_all(&self.bytes[done..])?;
        self.write_added(patch, &mut out)?;
        Ok(out.flush()?)
    }

    /// Replacements of changed coordinates in the document's own rows.
    fn coordinates(&self, positions: &[Vec3], normals: Option<&[Vec3]>) -> Result<Vec<Edit>, WriteError> {
        let (parsed, positions) = (&self.parsed, self.with_welds(positions));
        let mut rows = edits("v", &parsed.position_at, &parsed.positions, &positions)?;
        if let Some(normals) = normals {
            same_length("vn", normals, &parsed.normals)?;
            rows.extend(edits("vn", &parsed.normal_at, &parsed.normals, normals)?);
        }
        let file = Cursor::new(&self.bytes);
        let mut found = Vec::with_capacity(3 * rows.len());
        for (at, row) in rows {
            let mut line = file.moved_to(at as usize);
            line.token();
            for value in row {
                line.skip_blanks();
                let from = line.at();
                let mut text = Vec::new();
                number::write(*value, &mut text)?;
                line.token();
                found.push(Edit { from, to: line.at(), text });
            }
        }
        Ok(found)
    }

    /// Replacements for new rows, changed faces, and negative indices that would count over the new rows.
    fn statements(&self, patch: &Patch<'_>) -> Result<Vec<Edit>, WriteError> {
        let last_row = self.last_row();
        let end = self.line_end();
        let mut cursor = Cursor::new(&self.bytes);
        let (mut state, mut state_there): (State<'_>, State<'_>) = ([None; 4], [None; 4]);
        let mut moved = Vec::new();
        let mut found = Vec::new();
        let mut face = 0;
        while cursor.next_line() {
            let from = cursor.at();
            let token = cursor.token();
            if token.starts_with(b"#") {
                cursor.skip_comment();
                continue;
            }
            cursor.rest();
            let (end_of_line, to) = (cursor.at(), self.before_return(cursor.at()));
            let line = &self.bytes[from..to];
            match token {
                b"g" => state[0] = Some(line),
                b"o" => state[1] = Some(line),
                b"usemtl" => state[2] = Some(line),
                b"s" => state[3] = Some(line),
                b"f" | b"l" | b"p" => {
                    let polygons = if token == b"f" { patch.faces.get(&face) } else { None };
                    face += u32::from(token == b"f");
                    match polygons {
                        Some(polygons) if from < last_row => {
                            moved.push((state, polygons));
                            let whole = end_of_line + usize::from(end_of_line < self.bytes.len());
                            found.push(Edit { from, to: whole, text: Vec::new() });
                        }
                        Some(polygons) => {
                            let lines: Vec<Vec<u8>> = polygons.iter().map(|polygon| face_line(polygon)).collect();
                            found.push(Edit { from, to, text: lines.join(end) });
                        }
                        None if from > last_row && line.contains(&b'-') => {
                            found.push(Edit { from, to, text: self.counted_forward(line) });
                        }
                        None => {}
                    }
                }
                _ => {}
            }
            if to <= last_row {
                state_there = state;
            }
        }
        found.push(Edit { from: last_row, to: last_row, text: rows(patch, end, state_there, &moved)? });
        Ok(found)
    }

    /// End of the last line with a row.
    fn last_row(&self) -> usize {
        let mut cursor = Cursor::new(&self.bytes);
        let mut last = 0;
        while cursor.next_line() {
            let token = cursor.token();
            if token.starts_with(b"#") {
                cursor.skip_comment();
                continue;
            }
            cursor.rest();
            if matches!(token, b"v" | b"vt" | b"vn") {
                last = self.before_return(cursor.at());
            }
        }
        last
    }

    /// End of a line's text, before the carriage return of a two-byte line end.
    fn before_return(&self, at: usize) -> usize {
        at - usize::from(at > 0 && self.bytes[at - 1] == b'\r')
    }

    /// A line after the last row with its negative indices replaced by positive ones.
    fn counted_forward(&self, line: &[u8]) -> Vec<u8> {
        let counts = [self.positions().len(), self.texcoords().len(), self.normals().len()];
        let mut words = Vec::new();
        for word in line.split(|byte| byte.is_ascii_whitespace()).filter(|word| !word.is_empty() && *word != b"\\") {
            let part = |(kind, part): (usize, &[u8])| {
                let value = std::str::from_utf8(part).ok().and_then(|text| text.parse::<i64>().ok());
                match value {
                    Some(value) if value < 0 => (counts[kind.min(2)] as i64 + value + 1).to_string().into_bytes(),
                    _ => part.to_vec(),
                }
            };
            let parts: Vec<Vec<u8>> = word.split(|&byte| byte == b'/').enumerate().map(part).collect();
            words.push(parts.join(&b'/'));
        }
        words.join(&b' ')
    }

    fn write_added(&self, patch: &Patch<'_>, out: &mut impl Write) -> Result<(), WriteError> {
        if patch.added.is_empty() {
            return Ok(());
        }
        let end = self.line_end();
        if !self.bytes.ends_with(end) {
            out.write_all(end)?;
        }
        let mut lines = vec![format!("g {}", patch.name).into_bytes(), format!("usemtl {}", patch.name).into_bytes()];
        lines.push(b"s off".to_vec());
        lines.extend(patch.added.iter().map(|triangle| face_line(triangle)));
        for line in lines {
            out.write_all(&line)?;
            out.write_all(end)?;
        }
        Ok(())
    }

    pub(super) fn line_end(&self) -> &'static [u8] {
        match self.bytes.iter().position(|&byte| byte == b'\n') {
            Some(at) if at > 0 && self.bytes[at - 1] == b'\r' => b"\r\n",
            None if self.bytes.contains(&b'\r') => b"\r",
            _ => b"\n",
        }
    }
}

/// The new rows, the faces moved behind them, and then the attributes in force at that point.
fn rows(
    patch: &Patch<'_>,
    end: &[u8],
    there: State<'_>,
    moved: &[(State<'_>, &Vec<Vec<[u32; 3]>>)],
) -> Result<Vec<u8>, WriteError> {
    let mut text = Vec::new();
    let mut row = |keyword: &str, values: &[f64]| -> Result<(), WriteError> {
        text.extend_from_slice(end);
        text.extend_from_slice(keyword.as_bytes());
        for &value in values {
            text.push(b' ');
            number::write(value, &mut text)?;
        }
        Ok(())
    };
    for (i, values) in patch.positions.iter().enumerate() {
        match patch.colours.get(i) {
            Some([red, green, blue]) => row("v", &[values.x, values.y, values.z, *red, *green, *blue])?,
            None => row("v", values.as_slice())?,
        }
    }
    patch.texcoords.iter().try_for_each(|values| row("vt", values))?;
    patch.normals.iter().try_for_each(|values| row("vn", values.as_slice()))?;
    let mut now = there;
    for (state, polygons) in moved {
        change_state(&mut text, end, &mut now, *state);
        for polygon in *polygons {
            text.extend_from_slice(end);
            text.extend(face_line(polygon));
        }
    }
    change_state(&mut text, end, &mut now, there);
    Ok(text)
}

fn change_state<'a>(text: &mut Vec<u8>, end: &[u8], now: &mut State<'a>, to: State<'a>) {
    const NOTHING: [&[u8]; 4] = [b"g default", b"", b"", b"s off"];
    for kind in [1, 0, 2, 3] {
        if now[kind] != to[kind] {
            let line = to[kind].unwrap_or(NOTHING[kind]);
            if !line.is_empty() {
                text.extend_from_slice(end);
                text.extend_from_slice(line);
            }
        }
    }
    *now = to;
}

pub(super) fn face_line(corners: &[[u32; 3]]) -> Vec<u8> {
    let mut line = b"f".to_vec();
    for &[v, vt, vn] in corners {
        let text = match (vt != NONE, vn != NONE) {
            (false, false) => format!(" {}", v + 1),
            (true, false) => format!(" {}/{}", v + 1, vt + 1),
            (false, true) => format!(" {}//{}", v + 1, vn + 1),
            (true, true) => format!(" {}/{}/{}", v + 1, vt + 1, vn + 1),
        };
        line.extend_from_slice(text.as_bytes());
    }
    line
}
