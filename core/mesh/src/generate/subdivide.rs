//! Midpoint subdivision, for larger models of the same shape in benchmarks.

use std::fmt::Write;

use crate::Surface;

/// Splits every triangle into four at the midpoints of its edges.
///
/// Points keep their indices; the midpoint of edge e of [`Surface::edges`] is point n + e. Triangle t becomes 4 t, 4 t + 1 and 4 t + 2 at its corners and 4 t + 3 at its
/// centre.
pub fn subdivide(surface: &Surface) -> Surface {
    let first = surface.points.len() as u32;
    let mut points = surface.points.clone();
    let mut middle_of = vec![[0; 3]; surface.triangles.len()]; // new point on each side (m x 3)
    for (edge, (vertices, sides)) in surface.edges().iter().enumerate() {
        let [a, b] = vertices.map(|vertex| surface.point(vertex));
        points.push(a.lerp(&b, 0.5));
        for side in sides {
            middle_of[side.triangle as usize][usize::from(side.corner)] = first + edge as u32;
        }
    }
    let quarter =
        |(&[a, b, c], &[ab, bc, ca]): (&[u32; 3], &[u32; 3])| [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
    let triangles = surface.triangles.iter().zip(&middle_of).flat_map(quarter).collect();
    let face_of = surface.face_of.iter().flat_map(|&face| [face; 4]).collect();
    Surface { points, triangles, face_of }
}

/// The surface as OBJ text, `v` and `f` lines in the order of its points and triangles.
pub fn to_obj(surface: &Surface) -> Vec<u8> {
    let mut text = String::with_capacity(64 * surface.points.len() + 24 * surface.triangles.len());
    for point in &surface.points {
        _ = writeln!(text, "v {} {} {}", point.x, point.y, point.z); // a String takes everything
    }
    for [a, b, c] in surface.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + 1)) {
        _ = writeln!(text, "f {a} {b} {c}");
    }
    text.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec3;
    use crate::testing::document;
    use crate::{ObjDocument, check, generate};

    #[test]
    fn four_times_the_triangles_of_the_same_shape() {
        let coarse = Surface::from_document(&generate::cuboid(3, [1.0; 3]).unwrap());
        let fine = subdivide(&coarse);
        assert_eq!(fine.triangles.len(), 4 * coarse.triangles.len());
        assert_eq!(fine.face_of[4..8], [coarse.face_of[1]; 4]);
        assert!((fine.volume() - 1.0).abs() < 1e-14);
        let text = ObjDocument::parse(to_obj(&fine), "fine.obj".as_ref()).unwrap();
        let read = Surface::from_document(&text);
        assert_eq!((&read.points, &read.triangles), (&fine.points, &fine.triangles));
        assert_eq!(check(&read, &text), []);
    }

    #[test]
    fn an_open_triangle() {
        let fine = subdivide(&Surface::from_document(&document("v 0 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3\n")));
        assert_eq!(fine.points[3..], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]].map(Vec3::from));
        assert_eq!(fine.triangles, [[0, 3, 4], [3, 1, 5], [4, 5, 2], [3, 5, 4]]);
    }
}
