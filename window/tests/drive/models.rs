//! Models that are opened, and what their files hold.

use pliant_mesh::{ObjDocument, Surface};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A ball of radius 100 mm.
pub fn ball(folder: &Path) -> PathBuf {
    let path = folder.join("ball.obj");
    let document = pliant_mesh::generate::sphere(16, 0.1).unwrap();
    let points = document.positions().to_vec();
    document.write(&points, None, &mut std::fs::File::create(&path).unwrap()).unwrap();
    path
}

/// Two balls beside each other in one file, in parts of their own.
pub fn two_balls(folder: &Path) -> PathBuf {
    let path = folder.join("balls.obj");
    let ball = pliant_mesh::generate::sphere(16, 0.1).unwrap();
    let count = ball.positions().len();
    let mut text = String::new();
    for side in [-0.13, 0.13] {
        for p in ball.positions() {
            writeln!(text, "v {} {} {}", p[0] + side, p[1], p[2]).unwrap();
        }
    }
    for first in [1, 1 + count] {
        for corners in &Surface::from_document(&ball).triangles {
            let [a, b, c] = corners.map(|v| v as usize + first);
            writeln!(text, "f {a} {b} {c}").unwrap();
        }
    }
    std::fs::write(&path, text).unwrap();
    path
}

/// Connected parts of the faces of a file.
pub fn parts(file: Vec<u8>) -> u32 {
    let document = ObjDocument::parse(file, Path::new("saved.obj")).unwrap();
    Surface::from_document(&document).shells().iter().max().map_or(0, |last| last + 1)
}

/// Lines of vertices of a file.
pub fn vertices(file: &[u8]) -> usize {
    file.split(|byte| *byte == b'\n').filter(|line| line.starts_with(b"v ")).count()
}

/// How far (m) a vertex has moved at most among those on one side of the plane x = 0.
pub fn farthest(before: &[u8], after: &[u8], side: f64) -> f64 {
    let points = |file: &[u8]| -> Vec<[f64; 3]> {
        let text = String::from_utf8_lossy(file).into_owned();
        let numbers = |line: &str| line.split_whitespace().skip(1).map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
        text.lines().filter(|line| line.starts_with("v ")).map(|line| numbers(line)[..3].try_into().unwrap()).collect()
    };
    let pairs = points(before).into_iter().zip(points(after)).filter(|(a, _)| side * a[0] > 0.02);
    pairs.map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()).fold(0.0, f64::max)
}
