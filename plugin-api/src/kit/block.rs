//! A block of cubic cells, the shape of most closed forms.

use super::ElementList;
use crate::{CELL_TETRAHEDRA, abi};

/// Nodes, points, links and tetrahedra of a block.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Rest positions, m (n x 3), x fastest.
    pub rest: Vec<[f64; 3]>,
    /// One point per node, with its share of the volume, m^3.
    pub points: ElementList,
    /// Links with boundary weights, in the order of a grid: in strips of two rows of lower nodes; within a strip family by family,
    /// direction by direction.
    pub links: ElementList,
    /// Five tetrahedra per cell, cells x fastest.
    pub tetrahedra: ElementList,
}

/// Family and direction, in cells, of the links from a node.
const DIRECTIONS: [(u32, [i64; 3]); 16] = [
    (abi::STRUCTURAL, [1, 0, 0]),
    (abi::STRUCTURAL, [0, 1, 0]),
    (abi::STRUCTURAL, [0, 0, 1]),
    (abi::SHEAR, [1, 1, 0]),
    (abi::SHEAR, [-1, 1, 0]),
    (abi::SHEAR, [1, 0, 1]),
    (abi::SHEAR, [-1, 0, 1]),
    (abi::SHEAR, [0, 1, 1]),
    (abi::SHEAR, [0, -1, 1]),
    (abi::FLEXION, [2, 0, 0]),
    (abi::FLEXION, [0, 2, 0]),
    (abi::FLEXION, [0, 0, 2]),
    (abi::BODY_DIAGONAL, [1, 1, 1]),
    (abi::BODY_DIAGONAL, [-1, 1, 1]),
    (abi::BODY_DIAGONAL, [1, -1, 1]),
    (abi::BODY_DIAGONAL, [-1, -1, 1]),
];

/// Rows of lower nodes in a strip of links.
const STRIP_ROWS: usize = 2;

/// A block of `cells` cubic cells along x, y, z with edge `h` (m) and links of the given `families`.
pub fn block(cells: [u32; 3], h: f64, families: u32) -> Block {
    let count = cells.map(|c| i64::from(c) + 1);
    let is_node = |p: [i64; 3]| (0..3).all(|a| (0..count[a]).contains(&p[a]));
    let node = |p: [i64; 3]| (p[0] + count[0] * (p[1] + count[1] * p[2])) as u32;
    let mut out = Block::default();
    for p in lattice(count) {
        out.rest.push(p.map(|c| c as f64 * h));
        let on_faces = (0..3).filter(|&a| p[a] == 0 || p[a] == count[a] - 1).count();
        out.points.nodes.push(node(p));
        out.points.measure.push(h * h * h / f64::from(1 << on_faces));
    }
    let strips = (0..count[2]).flat_map(|z| (0..count[1]).step_by(STRIP_ROWS).map(move |y| [y, z]));
    for [y, z] in strips {
        for (family, d) in DIRECTIONS.into_iter().filter(|(family, _)| family & families != 0) {
            for p in lattice([count[0], count[1].min(y + STRIP_ROWS as i64) - y, 1]).map(|p| [p[0], y + p[1], z]) {
                let q = [p[0] + d[0], p[1] + d[1], p[2] + d[2]];
                if !is_node(q) {
                    continue;
                }
                let along_faces = (0..3).filter(|&a| d[a] == 0 && (p[a] == 0 || p[a] == count[a] - 1)).count();
                out.links.nodes.extend([node(p), node(q)]);
                out.links.family.push(family);
                out.links.measure.push(1.0 / f64::from(1 << along_faces));
            }
        }
    }
    for p in lattice(cells.map(i64::from)) {
        let corner = |c: u8| node([p[0] + i64::from(c & 1), p[1] + i64::from(c >> 1 & 1), p[2] + i64::from(c >> 2)]);
        for tetrahedron in CELL_TETRAHEDRA[(p[0] + p[1] + p[2]) as usize & 1] {
            out.tetrahedra.nodes.extend(tetrahedron.map(corner));
        }
    }
    out
}

/// All index triples below `count`, x fastest.
fn lattice(count: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (0..count[2]).flat_map(move |z| (0..count[1]).flat_map(move |y| (0..count[0]).map(move |x| [x, y, z])))
}

impl Block {
    /// The elements of a kind ([`abi::POINT`], ...), for [`super::Body::new`]; none for triangles and hinges.
    pub fn elements(&self, kind: u32) -> ElementList {
        match kind {
            abi::POINT => self.points.clone(),
            abi::LINK => self.links.clone(),
            abi::TETRAHEDRON => self.tetrahedra.clone(),
            _ => ElementList::default(),
        }
    }
}
