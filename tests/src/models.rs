//! OBJ texts for tests.

use crate::{Bench, root};
use pliant_mesh::sample::sample;
use pliant_mesh::testing::{Random, scan};
use spade::{DelaunayTriangulation, Point2, Triangulation};
use std::fmt::Write;
use std::path::PathBuf;

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

/// A scan to measure with: the Stanford bunny where it is, else a scan of as many triangles made here, in `bench`. Its name and file.
pub fn bunny(bench: &Bench) -> (&'static str, PathBuf) {
    let bunny = root().join("../shared/meshes/stanford-bunny.obj");
    if bunny.is_file() {
        return ("the bunny", bunny);
    }
    ("a scan made here (no ../shared/meshes/stanford-bunny.obj)", bench.write("scan.obj", scan(0, 69_451, 5, 1).text))
}

/// How many lines of a model are not what they were. Normals that were parted stand behind the last row; faces name them.
///
/// # Panics
/// If any of them is not of a vertex or a normal, or of a face that names another normal; or if its end or anything between its numbers
/// changed.
pub fn moved_lines(before: &[u8], after: &[u8]) -> usize {
    let lines = |bytes: &[u8]| bytes.split(|b| *b == b'\n').map(<[u8]>::to_vec).collect::<Vec<_>>();
    let (before, mut after) = (lines(before), lines(after));
    let is_row = |line: &Vec<u8>| [&b"v "[..], b"vt ", b"vn "].iter().any(|start| line.starts_with(start));
    let last = before.iter().rposition(is_row).expect("a vertex");
    let added: Vec<_> = after.drain(last + 1..last + 1 + (after.len() - before.len())).collect();
    assert!(added.iter().all(|line| line.starts_with(b"vn ")), "normals alone are added");
    let blanks = |line: &[u8]| line.iter().filter(|b| b.is_ascii_whitespace()).copied().collect::<Vec<u8>>();
    let moved = before.iter().zip(&after).enumerate().filter(|(_, (a, b))| a != b);
    moved.fold(0, |count, (i, (a, b))| {
        let allowed = [b"v ", b"vn"]
            .iter()
            .any(|start| a.trim_ascii_start().starts_with(*start) && b.trim_ascii_start().starts_with(*start));
        let allowed = allowed || without_normals(a).is_some_and(|face| Some(face) == without_normals(b));
        assert!(
            allowed && blanks(a) == blanks(b),
            "line {}: {:?}, was {:?}",
            i + 1,
            String::from_utf8_lossy(b),
            String::from_utf8_lossy(a)
        );
        count + 1
    })
}

/// The corners of a face without the rows of their normals; `None` for another line.
fn without_normals(line: &[u8]) -> Option<Vec<Vec<u8>>> {
    let words = line.strip_prefix(b"f ")?.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    Some(words.map(|word| word.split(|b| *b == b'/').take(2).collect::<Vec<_>>().join(&b'/')).collect())
}

/// A square sheet with `n` vertices a side and edges of `size` (m), as OBJ text: vertices lie scattered about a grid, and triangles are
/// Delaunay's, so that they have more and fewer neighbours than six, as in a garment. Vertices go row by row, or `shuffled` in no order.
///
/// # Panics
/// If it has less than two vertices a side.
pub fn scattered(n: u32, size: f64, shuffled: bool) -> String {
    let (last, mut random) = (n - 1, Random(1));
    let mut places = Vec::new();
    for (row, column) in (0..n).flat_map(|row| (0..n).map(move |column| (row, column))) {
        // Up to two fifths of a cell away, on the border along it.
        let mut moved = |at: u32| {
            let away = 0.4 * random.signed();
            size / f64::from(last) * (f64::from(at) + if at == 0 || at == last { 0.0 } else { away })
        };
        places.push(Point2::new(moved(column), moved(row)));
    }
    if shuffled {
        random.shuffle(&mut places);
    }
    let mut text: String = places.iter().map(|p| format!("v {} {} 0\n", p.x, p.y)).collect();
    let mesh = DelaunayTriangulation::<Point2<f64>>::bulk_load_stable(places).expect("places are numbers");
    for face in mesh.inner_faces() {
        let [a, b, c] = face.vertices().map(|v| v.index() + 1);
        _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}
