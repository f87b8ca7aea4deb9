//! All moving bodies of a session in one OBJ file: the present shape of a session, to be opened again.

use pliant_engine::session::Session;
use pliant_record::{AtomicFile, ModelShape};
use std::io::{self, Write};
use std::path::Path;

/// Writes every body that moves to one OBJ file, one after the other. A session of one body is written as [`pliant_record::write_model`] does.
///
/// # Errors
/// A file that cannot be created or written, and a vertex that cannot be written.
pub fn write_together(session: &Session, cap_material: &str, path: &Path) -> io::Result<()> {
    if let [body] = &session.bodies[..] {
        return pliant_record::write_model(body, cap_material, path);
    }
    let mut file = AtomicFile::create(path)?;
    let mut rows = RowCounts::default();
    for body in &session.bodies {
        let mut text = Vec::new();
        ModelShape::of(body).write(cap_material, &mut text)?;
        writeln!(file, "o {}", body.name.replace(char::is_whitespace, "_"))?;
        rows.append(&text, &mut file)?;
    }
    file.finish()
}

/// Numbers of `v`, `vt` and `vn` rows so far.
#[derive(Default)]
struct RowCounts([usize; 3]);

impl RowCounts {
    /// Appends an OBJ file, adding the rows written so far to its positive indices; negative ones count backwards and stay. A face that continues over
    /// several lines becomes one line, and comments behind faces are dropped.
    fn append(&mut self, text: &[u8], out: &mut impl Write) -> io::Result<()> {
        let offsets = self.0;
        // As the reader: without line feeds, carriage returns end the lines.
        let line_end = if text.contains(&b'\n') { b'\n' } else { b'\r' };
        let mut lines = text.split_inclusive(|byte| *byte == line_end);
        while let Some(line) = lines.next() {
            let mut statement = without_end(line).to_vec();
            let mut written = line.to_vec();
            while statement.last() == Some(&b'\\') && !statement.contains(&b'#') {
                let Some(next) = lines.next() else { break };
                statement.pop();
                statement.push(b' ');
                statement.extend_from_slice(without_end(next));
                written.extend_from_slice(next);
            }
            let data = statement.split(|byte| *byte == b'#').next().unwrap_or_default();
            let data = String::from_utf8_lossy(data);
            let mut words = data.split_whitespace();
            match words.next() {
                Some("v") => self.0[0] += 1,
                Some("vt") => self.0[1] += 1,
                Some("vn") => self.0[2] += 1,
                Some(keyword @ ("f" | "l" | "p")) => {
                    let shifted: Vec<String> = words.map(|corner| shift(corner, offsets)).collect();
                    writeln!(out, "{keyword} {}", shifted.join(" "))?;
                    continue;
                }
                _ => {}
            }
            out.write_all(&written)?;
        }
        if text.last().is_some_and(|last| *last != line_end) {
            out.write_all(b"\n")?;
        }
        Ok(())
    }
}

/// A line without what ends it.
fn without_end(line: &[u8]) -> &[u8] {
    let line = line.strip_suffix(b"\n").unwrap_or(line);
    line.strip_suffix(b"\r").unwrap_or(line)
}

/// A corner `v/vt/vn` whose positive indices are raised by the offsets.
fn shift(corner: &str, offsets: [usize; 3]) -> String {
    let index = |(text, offset): (&str, usize)| match text.parse::<i64>() {
        Ok(index) if index > 0 => (index + offset as i64).to_string(),
        _ => text.to_owned(),
    };
    corner.split('/').zip(offsets).map(index).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_of_a_second_file_count_on() {
        let one = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
        let two = b"v 0 0 1\nv 1 0 1\nv 0 1 1\nvn 0 0 1\ng other\nf 1//1 2//1 3//1\nf -3 -2 -1";
        let (mut rows, mut out) = (RowCounts::default(), Vec::new());
        rows.append(one, &mut out).unwrap();
        rows.append(two, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let faces: Vec<&str> = text.lines().filter(|line| line.starts_with('f')).collect();
        assert_eq!(faces, ["f 1/1 2/1 3/1", "f 4//1 5//1 6//1", "f -3 -2 -1"]);
        assert!(text.ends_with('\n') && text.contains("g other\n"));
    }

    #[test]
    fn faces_over_several_lines_and_comments_behind_faces_are_no_indices() {
        let one = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let two = b"v 0 0 \\\n1 # of three\nv 1 0 1\nv 0 1 1\nf 1 \\\n  2 \\\r\n3 # 1 2 3\n# f 1 2 \\\nf 3 2 1\n";
        let (mut rows, mut out) = (RowCounts::default(), Vec::new());
        rows.append(one, &mut out).unwrap();
        rows.append(two, &mut out).unwrap();
        let text = String::from_utf8(out.clone()).unwrap();
        let faces: Vec<&str> = text.lines().filter(|line| line.starts_with('f')).collect();
        assert_eq!(faces, ["f 4 5 6", "f 6 5 4"]);
        let model = pliant_mesh::obj::ObjDocument::parse(out, Path::new("both.obj")).unwrap();
        assert_eq!(model.positions().len(), 6);
    }
}
