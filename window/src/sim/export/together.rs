//! All bodies of a session in one OBJ file: the present shape of a session, to be opened again.

use pliant_engine::session::Session;
use pliant_record::{AtomicFile, ModelShape};
use std::io::{self, Write};
use std::path::Path;

/// Writes every body that moves to one OBJ file, one after the other. A session of one body is written as [`pliant_record::write_model`] does.
///
/// # Errors
/// What the file system says, with the path, and a vertex that cannot be written.
pub fn write_together(session: &Session, cap_material: &str, path: &Path) -> io::Result<()> {
    if let [body] = &session.bodies[..] {
        return pliant_record::write_model(body, cap_material, path);
    }
    let mut file = AtomicFile::create(path)?;
    let mut rows = Rows::default();
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
struct Rows([usize; 3]);

impl Rows {
    /// Appends an OBJ file whose indices count from the rows so far on. Indices that count backwards stay.
    fn append(&mut self, text: &[u8], out: &mut impl Write) -> io::Result<()> {
        let before = self.0;
        for line in text.split_inclusive(|byte| *byte == b'\n') {
            let words = line.trim_ascii();
            let keyword = words.split(u8::is_ascii_whitespace).next().unwrap_or_default();
            match keyword {
                b"v" => self.0[0] += 1,
                b"vt" => self.0[1] += 1,
                b"vn" => self.0[2] += 1,
                b"f" | b"l" | b"p" => {
                    let words = String::from_utf8_lossy(words);
                    let shifted: Vec<String> =
                        words.split_whitespace().skip(1).map(|corner| shift(corner, before)).collect();
                    writeln!(out, "{} {}", String::from_utf8_lossy(keyword), shifted.join(" "))?;
                    continue;
                }
                _ => {}
            }
            out.write_all(line)?;
        }
        if text.last().is_some_and(|last| *last != b'\n') {
            out.write_all(b"\n")?;
        }
        Ok(())
    }
}

/// A corner `v/vt/vn` whose indices are raised by the numbers of rows before them.
fn shift(corner: &str, before: [usize; 3]) -> String {
    let index = |(text, before): (&str, usize)| match text.parse::<i64>() {
        Ok(index) if index > 0 => (index + before as i64).to_string(),
        _ => text.to_owned(),
    };
    corner.split('/').zip(before).map(index).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_of_a_second_file_count_on() {
        let one = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";
        let two = b"v 0 0 1\nv 1 0 1\nv 0 1 1\nvn 0 0 1\ng other\nf 1//1 2//1 3//1\nf -3 -2 -1";
        let (mut rows, mut out) = (Rows::default(), Vec::new());
        rows.append(one, &mut out).unwrap();
        rows.append(two, &mut out).unwrap();
        let text = String::from_utf8(out).unwrap();
        let faces: Vec<&str> = text.lines().filter(|line| line.starts_with('f')).collect();
        assert_eq!(faces, ["f 1/1 2/1 3/1", "f 4//1 5//1 6//1", "f -3 -2 -1"]);
        assert!(text.ends_with('\n') && text.contains("g other\n"));
    }
}
