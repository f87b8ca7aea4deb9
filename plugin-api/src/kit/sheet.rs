//! A flat sheet of triangles, the test body for materials of surfaces.

use super::ElementList;
use crate::abi;
use std::collections::BTreeMap;

/// Nodes, points, triangles and hinges of a sheet in the plane z = 0.
#[derive(Clone, Debug, Default)]
pub struct Sheet {
    /// Rest positions, m (n x 3), x fastest.
    pub rest: Vec<[f64; 3]>,
    /// One point per node, with its share of the area, m^2.
    pub points: ElementList,
    /// Triangles, counter-clockwise; material coordinates are x and y.
    pub triangles: ElementList,
    /// One hinge per interior edge: its ends a, b, then the vertex to the left of a to b, and the one to the right.
    pub hinges: ElementList,
}

/// A sheet of `squares` squares along x and y with edge `h` (m), each cut into two triangles along a diagonal.
pub fn sheet(squares: [u32; 2], h: f64) -> Sheet {
    let row = squares[0] + 1;
    let node = |i: u32, j: u32| i + row * j;
    let mut rest = Vec::new();
    for j in 0..=squares[1] {
        for i in 0..=squares[0] {
            rest.push([f64::from(i) * h, f64::from(j) * h, 0.0]);
        }
    }
    let mut triangles = Vec::new();
    for j in 0..squares[1] {
        for i in 0..squares[0] {
            let [a, b, c, d] = [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Sheet::new(rest, &triangles)
}

impl Sheet {
    /// A flat sheet of counter-clockwise triangles, from positions in the plane z = 0, m (n x 3).
    ///
    /// # Panics
    /// On an edge with more than two triangles.
    pub fn new(rest: Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Self {
        let mut out = Self { rest, ..Self::default() };
        let n = out.rest.len();
        out.points.nodes = (0..n as u32).collect();
        out.points.measure = vec![0.0; n];
        // Each triangle's directed sides, with the opposite vertex, by the edge they lie on.
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
            // Triangles are counter-clockwise, so the opposite vertex lies to the left of a directed side.
            if let [[a, b, left], [_, _, right]] = sides[..] {
                out.hinges.nodes.extend([a, b, left, right]);
            }
        }
        out
    }

    /// The elements of a kind ([`abi::POINT`], ...), for [`super::Body::new`]; none for links and tetrahedra.
    pub fn elements(&self, kind: u32) -> ElementList {
        match kind {
            abi::POINT => self.points.clone(),
            abi::TRIANGLE => self.triangles.clone(),
            abi::HINGE => self.hinges.clone(),
            _ => ElementList::default(),
        }
    }
}
