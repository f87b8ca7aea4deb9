//! Writing a document: its own bytes, with new coordinates of moved vertices.

use std::io::{BufWriter, Write};
use std::iter::zip;

use super::cursor::Cursor;
use super::normals::TurnedNormals;
use super::{Corner, ObjDocument, Patch, WriteError, number};
use crate::geometry::Vec3;

impl ObjDocument {
    /// Writes the document with `positions` (n x 3, file units) and, if given, `normals` (k x 3) into `out`.
    ///
    /// A row with unchanged values keeps its bytes. In other rows only the three coordinates are replaced; keyword, spacing, weight, colour, comment and line
    /// end stay.
    ///
    /// # Errors
    /// [`WriteError`] if the number of rows of an array differs from that of the document, a changed row is not finite (nothing is written then), or `out` fails.
    pub fn write(&self, positions: &[Vec3], normals: Option<&[Vec3]>, out: &mut impl Write) -> Result<(), WriteError> {
        let (parsed, positions) = (&self.parsed, self.with_welds(positions));
        let mut edits = edits("v", &parsed.position_at, &parsed.positions, &positions)?;
        if let Some(normals) = normals {
            edits.extend(self::edits("vn", &parsed.normal_at, &parsed.normals, normals)?);
            edits.sort_unstable_by_key(|&(at, _)| at);
        }
        let mut out = BufWriter::with_capacity(1 << 16, out);
        let file = Cursor::new(&self.bytes);
        let mut done = 0; // bytes of the document copied so far
        for (at, row) in edits {
            let mut line = file.moved_to(at as usize);
            line.token();
            for value in row.iter() {
                line.skip_blanks();
                out.write_all(&self.bytes[done..line.at()])?;
                number::write(*value, &mut out)?;
                line.token();
                done = line.at();
            }
        }
        out.write_all(&self.bytes[done..])?;
        Ok(out.flush()?)
    }
}

impl ObjDocument {
    /// Writes the document with its vertices at `deformed` (n x 3, file units). Normals rotate with the faces that refer to them; a row of normals whose corners
    /// rotate differently is duplicated: new rows follow the last one, and faces that use them come after them.
    ///
    /// # Errors
    /// As for [`ObjDocument::write`].
    pub fn write_deformed(&self, deformed: &[Vec3], out: &mut impl Write) -> Result<(), WriteError> {
        self.write_deformed_patched(deformed, Patch::default(), out)
    }

    /// Writes the document like [`ObjDocument::write_deformed`], with a patch, whose faces refer to the document's normals and which has none of its own.
    ///
    /// # Errors
    /// As for [`ObjDocument::write_deformed`].
    pub fn write_deformed_patched<'a>(
        &self,
        deformed: &[Vec3],
        patch: Patch<'a>,
        out: &mut impl Write,
    ) -> Result<(), WriteError> {
        if self.normals().is_empty() {
            return self.write_patched(deformed, None, &patch, out);
        }
        same_length("v", deformed, self.positions())?;
        let turned = TurnedNormals::new(self.normals(), &self.shaded_faces(), self.positions(), deformed);
        let mut patch: Patch<'_> = Patch { normals: &turned.added, ..patch };
        for corner in patch.faces.values_mut().flatten().flatten() {
            corner[2] = turned.moved.get(&[corner[0], corner[2]]).copied().unwrap_or(corner[2]);
        }
        if !turned.moved.is_empty() {
            for face in 0..self.face_count() {
                let corners = self.corners(face);
                let row = |c: &Corner| turned.moved.get(&[c.v, c.vn]).copied();
                if !patch.faces.contains_key(&(face as u32)) && corners.iter().any(|c| row(c).is_some()) {
                    let polygon = corners.iter().map(|c| [c.v, c.vt, row(c).unwrap_or(c.vn)]).collect();
                    patch.faces.insert(face as u32, vec![polygon]);
                }
            }
        }
        self.write_patched(deformed, Some(&turned.rows), &patch, out)
    }
}

/// Offset of the line and new values of every changed row.
pub(super) fn edits<'a>(
    entity: &'static str,
    at: &[u32],
    old: &[Vec3],
    new: &'a [Vec3],
) -> Result<Vec<(u32, &'a Vec3)>, WriteError> {
    same_length(entity, new, old)?;
    let mut edits = Vec::new();
    for (index, (old, new)) in zip(old, new).enumerate() {
        if same_bits(old, new) {
            continue;
        }
        if !new.iter().all(|value| value.is_finite()) {
            return Err(WriteError::NotFinite { entity, index: index + 1, value: (*new).into() });
        }
        edits.push((at[index], new));
    }
    Ok(edits)
}

pub(super) fn same_length(entity: &'static str, given: &[Vec3], own: &[Vec3]) -> Result<(), WriteError> {
    if given.len() != own.len() {
        return Err(WriteError::Length { entity, found: given.len(), expected: own.len() });
    }
    Ok(())
}

/// Whether two rows are bit-identical.
pub(super) fn same_bits(a: &Vec3, b: &Vec3) -> bool {
    a.map(f64::to_bits) == b.map(f64::to_bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{Random, document};

    fn written(document: &ObjDocument, positions: &[Vec3], normals: Option<&[Vec3]>) -> String {
        let mut out = Vec::new();
        document.write(positions, normals, &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn only_the_coordinates_that_changed_change() {
        let text = "# kept \\\r\n\tv  1.0\t2.50 -3e0  0.5 # w\r\n\
            v 1 0 0 .1 .2 .3\nvn 0 0 2.0\nv 0 \\\n 1\\\n0\nf  1//1 2 3\nv 9 9 9";
        let document = document(text);
        let mut positions = document.positions().to_vec();
        positions[0] = Vec3::new(1.0, -0.1, 1e-7);
        positions[2] = Vec3::new(0.0, 1.0, 1.0 / 3.0);
        positions[3] = Vec3::new(-0.0, 1e300, 5e-324);
        let expected = text
            .replace("1.0\t2.50 -3e0 ", "1\t-0.1 1e-7 ")
            .replace("1\\\n0", "1\\\n0.3333333333333333")
            .replace("9 9 9", "-0 1e300 5e-324");
        assert_eq!(written(&document, &positions, None), expected);
        let normals = [Vec3::new(0.6, 0.0, 0.8)];
        let expected = expected.replace("vn 0 0 2.0", "vn 0.6 0 0.8");
        assert_eq!(written(&document, &positions, Some(&normals)), expected);
    }

    #[test]
    fn refuses_what_does_not_fit_and_writes_nothing() {
        let document = document("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
        let mut out = Vec::new();
        let short = document.write(&[Vec3::zeros()], None, &mut out).unwrap_err();
        assert_eq!(short.to_string(), "1 v given; the document has 3");
        let mut positions = document.positions().to_vec();
        positions[1][2] = f64::NAN;
        let nan = document.write(&positions, None, &mut out).unwrap_err();
        assert_eq!(nan.to_string(), "v 2 is [1.0, 0.0, NaN]; allowed: finite numbers");
        assert!(document.write(document.positions(), Some(&[Vec3::zeros()]), &mut out).is_err());
        assert!(out.is_empty());
    }

    /// A random document of awkward lines, with four vertices and a face at least.
    fn awkward(random: &mut Random) -> String {
        let line_end = random.pick(&["\n", "\r\n", "\r"]);
        let lines = [
            "v 1e0 +2. -.3",
            "\tv\t0.10  00.20 3 ",
            "v 1 2 3 1.0",
            "v 1 2 3 .5 .5 .5 # red",
            "v 1\\\n2 \\\n 3",
            "vn 0 0 1",
            "vt .5 .5",
            "",
            "   ",
            "# v 1 2 3 \\",
            "o Ü\\\n b",
            "g a b",
            "s off",
            "unknown \\ line",
            "l 1 2",
            "f 1 2 3",
            "f 4\\\n3 2",
            "f -1 -2 -3 -4",
            "v 0.1000000000000000055511151231257827 1E+2 -0",
        ];
        let mut text = if random.below(2) == 0 { "\u{feff}".to_owned() } else { String::new() };
        text += "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n";
        for _ in 0..random.below(12) {
            text += random.pick(&lines);
            text += "\n";
        }
        text += random.pick(&["f 1 2 3", "v 7 8 9\n", "# end"]);
        text.replace('\n', line_end)
    }

    #[test]
    fn unedited_documents_come_back_byte_for_byte() {
        let mut random = Random(6);
        for _ in 0..5000 {
            let document = document(&awkward(&mut random));
            let back = written(&document, document.positions(), Some(document.normals()));
            assert_eq!(back.as_bytes(), document.bytes());
        }
    }

    /// After an edit the document reads back as the edited numbers, bit for bit, with its faces where they were.
    #[test]
    fn edited_documents_read_back_as_edited() {
        let mut random = Random(7);
        for _ in 0..5000 {
            let original = document(&awkward(&mut random));
            let mut positions = original.positions().to_vec();
            for _ in 0..random.below(4) {
                let vertex = random.below(positions.len() as u64) as usize;
                let scale = 10_f64.powi(random.below(40) as i32 - 20);
                positions[vertex][random.below(3) as usize] = (random.unit() - 0.5) * scale;
            }
            let edited = document(&written(&original, &positions, None));
            assert!(zip(edited.positions(), &positions).all(|(a, b)| same_bits(a, b)));
            assert_eq!(edited.parsed.corners, original.parsed.corners);
            assert_eq!(edited.parsed.face_line, original.parsed.face_line);
            let again = written(&edited, &positions, None);
            assert_eq!(again.as_bytes(), edited.bytes());
        }
    }
}
