//! A closed surface without some of the tetrahedra around it: what is left of its triangles, and the faces of tetrahedra that bound what is left.
//!
//! Signs are exact, and a vertex is known by what meets in it, an edge and a triangle, so pieces have the same vertices along their common edges whatever rounding
//! does to positions. With nodes in general position, as [`jitter`] puts them, the result is closed.

mod crossings;
mod fill;
#[cfg(test)]
mod tests;

use crossings::Crossings;
use pliant_mesh::geometry::Vec3;
use std::collections::BTreeMap;

pub use crossings::Crossing;

/// Largest displacement of a node by [`jitter`], in edges of a cell.
const JITTER: f64 = 1e-7;

/// A surface and the faces at which tetrahedra that are left meet others that have gone.
pub struct Carving<'a> {
    /// Vertices of the surface as sides are judged by them, m (n x 3).
    pub points: &'a [Vec3],
    /// Triangles of the surface, counter-clockwise seen from outside (t x 3).
    pub triangles: &'a [[u32; 3]],
    /// Positions of the nodes, in general position, m (k x 3).
    pub nodes: &'a [Vec3],
    /// Nodes of the faces, counter-clockwise seen from the tetrahedron that has gone (f x 3).
    pub faces: &'a [[u32; 3]],
    /// Width of the boxes in which triangles and faces are looked for, m.
    pub spacing: f64,
}

/// A corner of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Corner {
    /// A vertex of the surface.
    Vertex(u32),
    /// A node inside of the surface.
    Node(u32),
    /// An edge and a triangle that cross, as an index of [`Carved::crossings`].
    Crossing(u32),
}

/// What is left of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// All of it.
    Whole,
    /// Some of it, as the pieces that are listed.
    Pieces,
    /// None of it: it has gone with the tetrahedra behind it.
    Nothing,
}

/// A surface without tetrahedra.
pub struct Carved {
    /// What is left of each triangle (t).
    pub left: Vec<Left>,
    /// Where edges and triangles cross.
    pub crossings: Vec<Crossing>,
    /// Pieces of triangles, counter-clockwise seen from outside, each with its triangle.
    pub pieces: Vec<(u32, [Corner; 3])>,
    /// Parts of faces inside of the surface, with the orientation of the faces, each with its face.
    pub faces: Vec<(u32, [Corner; 3])>,
    /// Number of triangles and faces around which signs contradict each other, as of a surface that is not closed: it may have holes there.
    pub doubtful: usize,
}

/// A position (m) beside a node's, by up to 1e-7 of `edge` (m), that follows from the id of the node alone.
pub fn jitter(position: Vec3, id: u64, edge: f64) -> Vec3 {
    let mut state = id;
    let mut next = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    position + 2.0 * JITTER * edge * Vec3::from_fn(|_, _| next())
}

impl Carving<'_> {
    /// Carves the surface. `is_inside` tells whether a node is inside of it, `is_gone` whether a triangle that no face crosses is in what has gone.
    pub fn carve(&self, is_inside: impl Fn(u32) -> bool, is_gone: impl Fn(u32) -> bool) -> Carved {
        let found = Crossings::find(self);
        let mut doubtful = found.doubtful;
        let gone = self.gone_vertices(&found, is_gone);
        let (mut left, mut pieces, mut faces) = (vec![Left::Whole; self.triangles.len()], Vec::new(), Vec::new());
        for (t, corners) in self.triangles.iter().enumerate() {
            let segments = found.of_triangle.get(&(t as u32)).map_or(&[][..], Vec::as_slice);
            let sides = [0, 1, 2].map(|i| found.on_side([corners[i], corners[(i + 1) % 3]]));
            if segments.is_empty() && sides.iter().all(Vec::is_empty) {
                if gone[corners[0] as usize] {
                    left[t] = Left::Nothing;
                }
                continue;
            }
            left[t] = Left::Pieces;
            let ends = corners.map(|v| (Corner::Vertex(v), !gone[v as usize]));
            let (border, is_sound) = outline(ends, sides, segments.iter().map(|[start, end]| [*end, *start]));
            doubtful += usize::from(!is_sound);
            let filled = self.fill(&found, &border, corners.map(|v| self.points[v as usize]));
            pieces.extend(filled.into_iter().map(|piece| (t as u32, piece)));
        }
        for (f, nodes) in self.faces.iter().enumerate() {
            let segments = found.of_face.get(&(f as u32)).map_or(&[][..], Vec::as_slice);
            let sides = [0, 1, 2].map(|i| found.on_edge([nodes[i], nodes[(i + 1) % 3]]));
            let ends = nodes.map(|n| (Corner::Node(n), is_inside(n)));
            let (border, is_sound) = outline(ends, sides, segments.iter().copied());
            doubtful += usize::from(!is_sound);
            let filled = self.fill(&found, &border, nodes.map(|n| self.nodes[n as usize]));
            faces.extend(filled.into_iter().map(|piece| (f as u32, piece)));
        }
        Carved { left, crossings: found.all, pieces, faces, doubtful }
    }

    /// Whether each vertex is in what has gone (n): by the faces that edges at it cross, or else as other vertices on the same side of all faces.
    fn gone_vertices(&self, found: &Crossings, is_gone: impl Fn(u32) -> bool) -> Vec<bool> {
        let mut gone: Vec<Option<bool>> = vec![None; self.points.len()];
        let mut others: Vec<Vec<u32>> = vec![Vec::new(); self.points.len()];
        for corners in self.triangles {
            for i in 0..3 {
                let edge = [corners[i], corners[(i + 1) % 3]];
                let side = found.on_side(edge);
                match (side.first(), side.last()) {
                    (Some((_, enters)), Some((_, leaves))) => {
                        gone[edge[0] as usize] = Some(*enters);
                        gone[edge[1] as usize] = Some(!*leaves);
                    }
                    _ => others[edge[0] as usize].push(edge[1]),
                }
            }
        }
        let spread = |from: u32, gone: &mut Vec<Option<bool>>| {
            let mut waiting = vec![from];
            while let Some(v) = waiting.pop() {
                for &other in &others[v as usize] {
                    if gone[other as usize].is_none() {
                        gone[other as usize] = gone[v as usize];
                        waiting.push(other);
                    }
                }
            }
        };
        let known: Vec<u32> = (0..gone.len() as u32).filter(|v| gone[*v as usize].is_some()).collect();
        known.into_iter().for_each(|v| spread(v, &mut gone));
        for (corners, t) in self.triangles.iter().zip(0..) {
            if gone[corners[0] as usize].is_none() {
                gone[corners[0] as usize] = Some(is_gone(t));
                spread(corners[0], &mut gone);
            }
        }
        gone.into_iter().map(|gone| gone.unwrap_or(false)).collect()
    }

    /// Triangles within directed edges, to whose left they are; `plane` are the corners of the triangle in whose plane they lie, m.
    fn fill(&self, found: &Crossings, border: &[[Corner; 2]], plane: [Vec3; 3]) -> Vec<[Corner; 3]> {
        let at = |corner: Corner| match corner {
            Corner::Vertex(v) => self.points[v as usize],
            Corner::Node(n) => self.nodes[n as usize],
            Corner::Crossing(c) => found.places[c as usize],
        };
        fill::fill(border, at, plane)
    }
}

/// Directed edges around a part of a triangle, to whose left it is: `segments` in it, and pieces of its sides. `ends` are its corners, each with whether it is in the part, `sides`
/// the crossings along each side, each with whether the part begins there. The second result tells whether signs agree.
fn outline(
    ends: [(Corner, bool); 3],
    sides: [Vec<(Corner, bool)>; 3],
    segments: impl Iterator<Item = [Corner; 2]>,
) -> (Vec<[Corner; 2]>, bool) {
    let mut edges: BTreeMap<[Corner; 2], i32> = BTreeMap::new();
    let mut add = |[from, to]: [Corner; 2]| {
        let [key, count] = if from < to { [[from, to], [from, to]] } else { [[to, from], [from, to]] };
        *edges.entry(key).or_default() += if count == key { 1 } else { -1 };
    };
    segments.for_each(&mut add);
    let mut is_sound = true;
    for i in 0..3 {
        let (mut at, mut is_in) = ends[i];
        for &(crossing, begins) in &sides[i] {
            is_sound &= is_in != begins;
            if !begins {
                add([at, crossing]);
            }
            (at, is_in) = (crossing, begins);
        }
        let (end, is_end_in) = ends[(i + 1) % 3];
        is_sound &= is_in == is_end_in;
        if is_in {
            add([at, end]);
        }
    }
    let directed = edges.into_iter().flat_map(|([low, high], count)| {
        let edge = if count > 0 { [low, high] } else { [high, low] };
        std::iter::repeat_n(edge, count.unsigned_abs() as usize)
    });
    (directed.collect(), is_sound)
}
