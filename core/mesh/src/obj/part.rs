//! Writing some faces of a document as a document of their own.

use std::io::{BufWriter, Write};

use super::cursor::Cursor;
use super::patch::face_line;
use super::{NONE, ObjDocument};

/// Number of each row among those that are kept, or [`NONE`].
struct KeptRows(Vec<u32>);

impl KeptRows {
    fn new(count: usize, used: impl Iterator<Item = u32>) -> Self {
        let mut rows = vec![NONE; count];
        used.filter(|row| *row != NONE).for_each(|row| rows[row as usize] = 0);
        rows.iter_mut().filter(|row| **row != NONE).enumerate().for_each(|(number, row)| *row = number as u32);
        Self(rows)
    }

    /// Number of a row of a corner.
    fn of(&self, row: u32) -> u32 {
        if row == NONE { NONE } else { self.0[row as usize] }
    }
}

impl ObjDocument {
    /// Row of each vertex (n) in the file that [`ObjDocument::write_faces`] writes; `u32::MAX` for a vertex that no kept face uses.
    pub fn kept_vertices(&self, is_kept: &[bool]) -> Vec<u32> {
        let kept = (0..self.face_count()).filter(|face| is_kept[*face]).flat_map(|face| self.corners(face));
        KeptRows::new(self.positions().len(), kept.map(|corner| corner.v)).0
    }

    /// Writes the faces for which `is_kept` (f) holds, with the `v`, `vt` and `vn` lines that they use. These, comments and material libraries keep
    /// their bytes and their order, faces their corners. Groups, objects, materials and smoothing stand before the first kept face they apply
    /// to. Elements that are no faces (`l`, `p`, curves) are left out.
    ///
    /// # Errors
    /// What `out` says.
    pub fn write_faces(&self, is_kept: &[bool], out: &mut impl Write) -> std::io::Result<()> {
        let kept = || (0..self.face_count()).filter(|face| is_kept[*face]).flat_map(|face| self.corners(face));
        let rows = [
            KeptRows::new(self.positions().len(), kept().map(|corner| corner.v)),
            KeptRows::new(self.texcoords().len(), kept().map(|corner| corner.vt)),
            KeptRows::new(self.normals().len(), kept().map(|corner| corner.vn)),
        ];
        let mut out = BufWriter::with_capacity(1 << 16, out);
        let (mut next_row, mut next_face) = ([0, 0, 0], 0);
        // Statements that apply to the next face, the last of each kind.
        let mut waiting: Vec<(&[u8], &[u8])> = Vec::new();
        let mut cursor = Cursor::new(&self.bytes);
        while cursor.next_line() {
            let from = cursor.at();
            let token = cursor.token();
            if token.starts_with(b"#") {
                cursor.skip_comment()
            } else {
                _ = cursor.rest()
            }
            let line = self.bytes[from..cursor.at()].trim_ascii_end();
            let kind = [&b"v"[..], b"vt", b"vn"].iter().position(|row| *row == token);
            match token {
                _ if kind.is_some() || token == b"mtllib" || token.starts_with(b"#") => {
                    let is_used = kind.is_none_or(|kind| {
                        next_row[kind] += 1;
                        rows[kind].0[next_row[kind] - 1] != NONE
                    });
                    if is_used {
                        out.write_all(line)?;
                        out.write_all(self.line_end())?;
                    }
                }
                b"g" | b"o" | b"usemtl" | b"s" => {
                    waiting.retain(|(kind, _)| *kind != token);
                    waiting.push((token, line));
                }
                b"f" => {
                    next_face += 1;
                    if !is_kept[next_face - 1] {
                        continue;
                    }
                    let corners = self.corners(next_face - 1).iter();
                    let mut corners: Vec<_> =
                        corners.map(|c| [rows[0].of(c.v), rows[1].of(c.vt), rows[2].of(c.vn)]).collect();
                    if self.is_turned_over(next_face as u32 - 1) {
                        corners[1..].reverse();
                    }
                    let face = face_line(&corners);
                    for line in waiting.drain(..).map(|(_, line)| line).chain([&face[..]]) {
                        out.write_all(line)?;
                        out.write_all(self.line_end())?;
                    }
                }
                _ => {}
            }
        }
        out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Surface;
    use crate::testing::{document, models};

    fn part(whole: &ObjDocument, is_kept: &[bool]) -> ObjDocument {
        let mut bytes = Vec::new();
        whole.write_faces(is_kept, &mut bytes).unwrap();
        document(std::str::from_utf8(&bytes).unwrap())
    }

    #[test]
    fn parts_of_models_have_all_faces_with_what_they_had() {
        for (round, model) in models(6, 3).into_iter().enumerate() {
            let whole = document(&model.text);
            let mut seen = 0;
            for side in 0..3 {
                let is_kept: Vec<bool> = (0..whole.face_count()).map(|face| (face / 5 + round) % 3 == side).collect();
                let part = part(&whole, &is_kept);
                let kept = whole.faces().zip(&is_kept).filter(|(_, is_kept)| **is_kept).map(|(face, _)| face);
                for (now, then) in part.faces().zip(kept) {
                    seen += 1;
                    assert_eq!(now.corners.len(), then.corners.len(), "{}", model.name);
                    for (now, then) in now.corners.iter().zip(then.corners) {
                        let place = |document: &ObjDocument, v: u32| document.positions()[v as usize];
                        assert_eq!(place(&part, now.v), place(&whole, then.v), "{}", model.name);
                        let texcoord = |document: &ObjDocument, c: &super::super::Corner| {
                            c.vt().map(|row| document.texcoords()[row as usize])
                        };
                        assert_eq!(texcoord(&part, now), texcoord(&whole, then), "{}", model.name);
                        let normal = |document: &ObjDocument, c: &super::super::Corner| {
                            c.vn().map(|row| document.normals()[row as usize])
                        };
                        assert_eq!(normal(&part, now), normal(&whole, then), "{}", model.name);
                    }
                    let name = |names: &[String], index: Option<u32>| index.map(|index| names[index as usize].clone());
                    let of = |document: &ObjDocument, face: &crate::Face<'_>| {
                        let at = face.attributes;
                        let names = [
                            name(document.groups(), at.group),
                            name(document.objects(), at.object),
                            name(document.materials(), at.material),
                        ];
                        (names, at.smoothing)
                    };
                    assert_eq!(of(&part, &now), of(&whole, &then), "{}", model.name);
                }
                // Nothing that no face uses.
                let mut used = vec![false; part.positions().len()];
                Surface::from_document(&part).triangles.iter().flatten().for_each(|v| used[*v as usize] = true);
                assert!(used.iter().all(|is_used| *is_used), "{}", model.name);
            }
            assert_eq!(seen, whole.face_count(), "{}", model.name);
        }
    }

    #[test]
    fn lines_that_are_kept_keep_their_bytes() {
        let text = "# hat\r\nmtllib a.mtl\r\nv 0 0 0 1 0 0\r\nv 9 9 9\r\nv 1 0  0\r\nv 0 1 0\r\no hat\r\ng rim\r\nf 1 2 3\r\ng top\r\nl 1 2\r\nf 1 -2 4";
        let mut bytes = Vec::new();
        document(text).write_faces(&[false, true], &mut bytes).unwrap();
        let expected = "# hat\r\nmtllib a.mtl\r\nv 0 0 0 1 0 0\r\nv 1 0  0\r\nv 0 1 0\r\no hat\r\ng top\r\nf 1 2 3\r\n";
        assert_eq!(std::str::from_utf8(&bytes).unwrap(), expected);
    }
}
