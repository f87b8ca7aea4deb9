//! A flat sheet of triangles, for materials of surfaces.

use super::Given;
use crate::abi;

/// Nodes, points, triangles and hinges of a sheet in the plane z = 0.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// m (n x 3), x fastest
    pub rest: Vec<[f64; 3]>,
    /// One per node, with its share of the area, m^2.
    pub points: Given,
    /// Two a square; material coordinates are x and y.
    pub triangles: Given,
    /// One per edge inside: its ends a, b, then the corner to the left of a to b, and the one to the right.
    pub hinges: Given,
}

/// A sheet of `squares` squares with edge `h` (m), each cut along a diagonal.
pub fn sheet(squares: [u32; 2], h: f64) -> Sheet {
    let along = squares[0] + 1;
    let number = |i: u32, j: u32| i + along * j;
    let mut out = Sheet::default();
    for j in 0..=squares[1] {
        for i in 0..=squares[0] {
            out.rest.push([f64::from(i) * h, f64::from(j) * h, 0.0]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..squares[1] {
        for i in 0..squares[0] {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    out.points.nodes = (0..out.rest.len() as u32).collect();
    out.points.measure = vec![0.0; out.rest.len()];
    for t in &triangles {
        for &n in t {
            out.points.measure[n as usize] += h * h / 6.0;
            out.triangles.nodes.push(n);
            out.triangles.material.extend(&out.rest[n as usize][..2]);
        }
    }
    for (s, t) in triangles.iter().enumerate() {
        for u in &triangles[s + 1..] {
            // The sides of t go round counter-clockwise, so t is to the left of each.
            let side = (0..3).map(|i| [t[i], t[(i + 1) % 3]]).find(|side| side.iter().all(|n| u.contains(n)));
            if let Some([a, b]) = side {
                let opposite = |t: &[u32; 3]| t.iter().copied().find(|n| *n != a && *n != b).unwrap_or(a);
                out.hinges.nodes.extend([a, b, opposite(t), opposite(u)]);
            }
        }
    }
    out
}

impl Sheet {
    /// The elements of a kind, as [`super::Body::new`] wants them.
    pub fn given(&self, kind: u32) -> Given {
        match kind {
            abi::POINT => self.points.clone(),
            abi::TRIANGLE => self.triangles.clone(),
            abi::HINGE => self.hinges.clone(),
            _ => Given::default(),
        }
    }
}
