//! Triangle surfaces with shared vertices: points, triangles, bounds and edges.

use super::disjoint_sets::DisjointSets;
use super::edges::{EdgeTable, Side};
use super::triangulate::{split_otherwise, triangulate};
use super::{ObjDocument, Placement};
use crate::geometry::Vec3;

/// Number of the shell of a triangle that is left out of [`Surface::joined_shells`].
pub const NO_SHELL: u32 = u32::MAX;

/// Points and triangles. Points have the indices of the document's vertices, including unused ones.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Points (n x 3), in file units, or in m after placement.
    pub points: Vec<Vec3>,
    /// Corners of each triangle, counter-clockwise seen from outside (m x 3).
    pub triangles: Vec<[u32; 3]>,
    /// Index of the document's face of each triangle (m).
    pub face_of: Vec<u32>,
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lower corner, in the units of the points.
    pub min: Vec3,
    /// Upper corner, in the units of the points.
    pub max: Vec3,
}

impl Bounds {
    /// Length of the longest edge, in units of the points.
    pub fn longest_edge(&self) -> f64 {
        (self.max - self.min).max()
    }

    /// Centre of the box, in units of the points.
    pub fn centre(&self) -> Vec3 {
        self.min.lerp(&self.max, 0.5)
    }
}

impl Surface {
    /// Triangulates the document's faces, in the order of the file.
    ///
    /// A quad is split along its shorter interior diagonal, a larger polygon by ear clipping in its plane; a polygon without area becomes a fan. A face with f
    /// corners always has f - 2 triangles.
    pub fn from_document(document: &ObjDocument) -> Self {
        let points = document.positions().to_vec();
        let mut surface = Self { points, ..Self::default() };
        let (mut polygon, mut pieces) = (Vec::new(), Vec::new());
        for (index, face) in document.faces().enumerate() {
            if let [a, b, c] = face.corners {
                surface.triangles.push([a.v, b.v, c.v]);
            } else {
                polygon.clear();
                polygon.extend(face.corners.iter().map(|corner| surface.point(corner.v)));
                pieces.clear();
                triangulate(&polygon, &mut pieces);
                surface.triangles.extend(pieces.iter().map(|piece| piece.map(|corner| face.corners[corner].v)));
            }
            surface.face_of.resize(surface.triangles.len(), index as u32);
        }
        surface.part_twins(document);
        surface
    }

    /// The same triangles with placed points, m.
    pub fn placed(&self, placement: &Placement) -> Self {
        let points = self.points.iter().map(|&point| placement.apply(point)).collect();
        Self { points, ..self.clone() }
    }

    /// Bounding box of the points of triangles; zeros for a surface without triangles.
    pub fn bounds(&self) -> Bounds {
        let mut used = self.triangles.iter().flatten().map(|&vertex| self.point(vertex));
        let first = used.next().unwrap_or_default();
        let (min, max) = used.fold((first, first), |(min, max), point| (min.inf(&point), max.sup(&point)));
        Bounds { min, max }
    }

    /// Area of each triangle, in squared units of the points (m).
    pub fn areas(&self) -> Vec<f64> {
        self.triangles.iter().map(|triangle| 0.5 * self.cross(triangle).norm()).collect()
    }

    /// Unit normal of each point, the area-weighted mean of its triangles (n x 3); zero if all of them are degenerate.
    pub fn vertex_normals(&self) -> Vec<Vec3> {
        let mut sums = vec![Vec3::zeros(); self.points.len()];
        for triangle in &self.triangles {
            let cross = self.cross(triangle);
            triangle.iter().for_each(|&vertex| sums[vertex as usize] += cross);
        }
        sums.iter().map(|sum| sum.try_normalize(0.0).unwrap_or_default()).collect()
    }

    /// Enclosed volume, in cubed units of the points; negative for inward normals, meaningless for an open surface.
    pub fn volume(&self) -> f64 {
        let origin = self.bounds().centre(); // avoids cancellation for models far from the origin
        let cone = |t: &[u32; 3]| (self.point(t[0]) - origin).dot(&self.cross(t)) / 6.0;
        self.triangles.iter().map(cone).sum()
    }

    /// The edge table of the triangles.
    pub fn edges(&self) -> EdgeTable {
        EdgeTable::new(&self.triangles)
    }

    /// Connected component of each triangle (m), numbered in the order of their first triangles. Triangles that share a vertex are connected.
    pub fn shells(&self) -> Vec<u32> {
        self.joined_shells(&[], |_| false)
    }

    /// As [`Surface::shells`], with pairs of vertices that count as one, as where a seam joins two pieces, and without the triangles for which
    /// `has_failed` holds: they connect nothing, and their number is [`NO_SHELL`].
    ///
    /// # Panics
    /// If a pair has a vertex that is not there.
    pub fn joined_shells(&self, joined: &[[u32; 2]], has_failed: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut connected = DisjointSets::new(self.points.len());
        for (&[a, b, c], triangle) in self.triangles.iter().zip(0..) {
            [b, c].into_iter().filter(|_| !has_failed(triangle)).for_each(|other| connected.unite(a, other));
        }
        joined.iter().for_each(|[a, b]| connected.unite(*a, *b));
        let mut number = vec![NO_SHELL; self.points.len()];
        let mut count = 0;
        let shell_of = |(corners, triangle): (&[u32; 3], u32)| {
            if has_failed(triangle) {
                return NO_SHELL;
            }
            let shell = &mut number[connected.find(corners[0]) as usize];
            if *shell == NO_SHELL {
                *shell = count;
                count += 1;
            }
            *shell
        };
        self.triangles.iter().zip(0..).map(shell_of).collect()
    }

    /// Two quads with two common edges may both be split into a triangle of the same three vertices, which would coincide although the quads do not. Such quads
    /// are split along their other diagonal.
    fn part_twins(&mut self, document: &ObjDocument) {
        let mut faces_at = vec![0_u32; self.points.len()];
        document.faces().flat_map(|face| face.corners).for_each(|corner| faces_at[corner.v as usize] += 1);
        // The common vertex of such quads has no other face.
        let mut halves = Vec::new();
        for (index, pair) in self.face_of.windows(2).enumerate().filter(|(_, pair)| pair[0] == pair[1]) {
            for (half, other) in [(index, index + 1), (index + 1, index)] {
                let [mut key, other] = [half, other].map(|index| self.triangles[index]);
                if key.iter().any(|vertex| faces_at[*vertex as usize] == 2 && !other.contains(vertex)) {
                    key.sort_unstable();
                    halves.push((key, index, pair[0]));
                }
            }
        }
        halves.sort_unstable();
        let twins = halves.windows(2).filter(|pair| pair[0].0 == pair[1].0 && pair[0].2 != pair[1].2);
        for &(_, first, face) in twins.flatten() {
            let Some([a, b, c, d]) = document.face(face as usize).and_then(|face| face.corners.as_array()) else {
                continue;
            };
            let quad = [a.v, b.v, c.v, d.v];
            let half = self.triangles[first].map(|vertex| quad.iter().position(|&v| v == vertex).unwrap_or(0));
            if let Some(split) = split_otherwise(&quad.map(|vertex| self.point(vertex)), half) {
                self.triangles[first..first + 2].copy_from_slice(&split.map(|piece| piece.map(|corner| quad[corner])));
            }
        }
    }

    /// First and last vertex of a side of a triangle.
    pub(super) fn ends(&self, side: Side) -> [u32; 2] {
        let triangle = self.triangles[side.triangle as usize];
        [0, 1].map(|step| triangle[(side.corner as usize + step) % 3])
    }

    pub(super) fn point(&self, vertex: u32) -> Vec3 {
        self.points[vertex as usize]
    }

    /// Normal of a triangle; its length is twice the area.
    pub(super) fn cross(&self, triangle: &[u32; 3]) -> Vec3 {
        let [a, b, c] = triangle.map(|vertex| self.point(vertex));
        (b - a).cross(&(c - a))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::Kind;
    use crate::testing::document;

    /// A unit tetrahedron at the origin and a separate triangle far away.
    const TWO_SHELLS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 0 0\nv 6 0 0\nv 5 2 0\nv 99 99 99\n\
        f 1 3 2\nf 1 2 4\nf 5 6 7\nf 1 4 3\nf 2 3 4\n";

    #[test]
    fn measures() {
        let mut surface = Surface::from_document(&document(TWO_SHELLS));
        assert_eq!(surface.shells(), [0, 0, 1, 0, 0]);
        assert_eq!(surface.face_of, [0, 1, 2, 3, 4]);
        assert_eq!(surface.areas()[..4], [0.5, 0.5, 1.0, 0.5]);
        assert_eq!(
            surface.bounds(),
            Bounds { min: Vec3::zeros(), max: Vec3::new(6.0, 2.0, 1.0) },
            "the unused vertex is left out"
        );
        assert_eq!(surface.vertex_normals()[4], Vec3::z());
        assert_eq!(surface.vertex_normals()[7], Vec3::zeros());
        surface.triangles.remove(2);
        assert!((surface.volume() - 1.0 / 6.0).abs() < 1e-15);
        surface.points.iter_mut().for_each(|point| point[0] += 1e6);
        assert!((surface.volume() - 1.0 / 6.0).abs() < 1e-9);
    }

    #[test]
    fn quads_that_share_two_edges_do_not_share_a_triangle() {
        // Two squares bent along 1-2-3, whose default diagonals would both separate vertex 2.
        let text = "v 0 0 0\nv 0.9 -0.1 0\nv 1 1 0\nv 0 1.4 0.9\nv 0 1.4 -0.9\nf 1 2 3 4\nf 3 2 1 5\n";
        let document = document(text);
        let surface = Surface::from_document(&document);
        assert_eq!(surface.triangles, [[0, 1, 3], [1, 2, 3], [2, 1, 4], [1, 0, 4]]);
        assert!(crate::check(&surface, &document).iter().all(|finding| finding.kind == Kind::Border));
    }

    #[test]
    fn a_surface_of_nothing_is_harmless() {
        let surface = Surface::default();
        assert_eq!(surface.bounds().longest_edge(), 0.0);
        assert_eq!((surface.volume(), surface.shells().len()), (0.0, 0));
    }
}
