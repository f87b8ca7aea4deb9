//! A flat sheet of triangles, for materials of surfaces.

use super::Given;
use crate::abi;
use std::collections::BTreeMap;

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
    let mut rest = Vec::new();
    for j in 0..=squares[1] {
        for i in 0..=squares[0] {
            rest.push([f64::from(i) * h, f64::from(j) * h, 0.0]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..squares[1] {
        for i in 0..squares[0] {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Sheet::new(rest, &triangles)
}

impl Sheet {
    /// A flat sheet of triangles, each counter-clockwise, at places in the plane z = 0, m (n x 3).
    ///
    /// # Panics
    /// On an edge with more than two triangles.
    pub fn new(rest: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Self {
        let mut out = Self { rest, ..Self::default() };
        let n = out.rest.len();
        out.points.nodes = (0..n as u32).collect();
        out.points.measure = vec![0.0; n];
        let mut edges: BTreeMap<[u32; 2], Vec<[u32; 3]>> = BTreeMap::new();
        for &[a, b, c] in triangles {
            let [p, q, r] = [a, b, c].map(|n| out.rest[n as usize]);
            let area = 0.5 * ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]));
            for node in [a, b, c] {
                out.points.measure[node as usize] += area / 3.0;
                out.triangles.nodes.push(node);
                out.triangles.material.extend(&out.rest[node as usize][..2]);
            }
            for side in [[a, b, c], [b, c, a], [c, a, b]] {
                edges.entry([side[0].min(side[1]), side[0].max(side[1])]).or_default().push(side);
            }
        }
        for sides in edges.values() {
            assert!(sides.len() <= 2, "an edge of {} triangles", sides.len());
            // The corners of a side's triangle go round counter-clockwise, so it is to the left of the side.
            if let [[a, b, o], [_, _, p]] = sides[..] {
                out.hinges.nodes.extend([a, b, o, p]);
            }
        }
        out
    }

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
