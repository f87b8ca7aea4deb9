//! OBJ texts for tests.

use pliant_core::mesh::sample::sample;

/// A cube of quads with nothing else in the file: 14 lines.
pub const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// The sample elephant at its coarsest, 2080 quads with texture coordinates, normals, groups and materials; and on top what
/// else a file may hold.
///
/// # Panics
/// If there is no such sample.
pub fn elephant() -> String {
    let text = String::from_utf8(sample("elephant", 1).expect("a sample")).expect("text");
    let comment = "# kept: \t tabs, \u{e9}\u{df}\u{4e2d}, trailing blanks   \n\n# and a Windows path C:\\models\\\n";
    let unknown = "unknown keyword 1 2 3\nl 1 2\nmystery\n";
    format!("{comment}{}{unknown}", text.replacen("s 1\n", "s 1\n  \nusemtl skin # here\n", 1))
}

/// How many lines of a model are not what they were.
///
/// # Panics
/// If any of them is not of a vertex or a normal, or if its end or anything between its numbers changed.
pub fn moved_lines(before: &[u8], after: &[u8]) -> usize {
    let lines = |bytes: &[u8]| bytes.split(|b| *b == b'\n').map(<[u8]>::to_vec).collect::<Vec<_>>();
    let (before, after) = (lines(before), lines(after));
    assert_eq!(before.len(), after.len(), "lines");
    let blanks = |line: &[u8]| line.iter().filter(|b| b.is_ascii_whitespace()).copied().collect::<Vec<u8>>();
    let moved = before.iter().zip(&after).enumerate().filter(|(_, (a, b))| a != b);
    moved.fold(0, |count, (i, (a, b))| {
        let allowed = [b"v ", b"vn"].iter().any(|start| a.starts_with(*start) && b.starts_with(*start));
        assert!(allowed && blanks(a) == blanks(b), "line {}: {}", i + 1, String::from_utf8_lossy(b));
        count + 1
    })
}
