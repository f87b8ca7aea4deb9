//! Constrained Delaunay triangulation in a plane; the only user of the crate spade.

use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::record::NONE;

/// A triangle in the plane, with counter-clockwise corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlaneTriangle {
    pub corners: [u32; 3],
    /// Neighbours across its sides, first that from corner 0 to corner 1; `NONE` on the hull.
    pub neighbours: [u32; 3],
}

/// Constrained Delaunay triangulation of the hull of `points` with the edges `lines` (pairs of points). `None` if two points coincide, lines cross
/// or contain a point, or a coordinate is out of range.
pub(super) fn triangulate(
    points: &[[f64; 2]],
    lines: impl Iterator<Item = [u32; 2]> + Clone,
) -> Option<Vec<PlaneTriangle>> {
    let point = |&[x, y]: &[f64; 2]| Point2::new(flush_tiny(x), flush_tiny(y));
    let mut crossed = false;
    let plane = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(
        points.iter().map(point).collect(),
        lines.clone().map(|line| line.map(|end| end as usize)).collect(),
        |_| crossed = true,
    );
    let plane = plane.ok()?;
    let handle = |at: u32| FixedVertexHandle::from_index(at as usize);
    if crossed
        || plane.num_vertices() != points.len()
        || !lines.clone().all(|[a, b]| plane.exists_constraint(handle(a), handle(b)))
    {
        return None;
    }
    let triangles = plane.inner_faces().map(|face| {
        let sides = face.adjacent_edges();
        let neighbours = |side: spade::handles::DirectedEdgeHandle<'_, _, _, _, _>| {
            side.rev().face().as_inner().map_or(NONE, |face| face.index() as u32 - 1)
        };
        PlaneTriangle { corners: sides.map(|side| side.from().index() as u32), neighbours: sides.map(neighbours) }
    });
    Some(triangles.collect())
}

/// Replaces magnitudes below 1e-40, which spade refuses, by zero.
fn flush_tiny(value: f64) -> f64 {
    if value.abs() < 1e-40 { 0.0 } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.1], [0.0, 1.0]];

    #[test]
    fn keeps_to_its_lines() {
        for line in [[0, 2], [1, 3]] {
            let triangles = triangulate(&SQUARE, [line].into_iter()).unwrap();
            assert_eq!(triangles.len(), 2);
            assert!(triangles.iter().all(|flat| line.iter().all(|end| flat.corners.contains(end))));
            for (number, flat) in triangles.iter().enumerate() {
                let other = &triangles[1 - number];
                let side = flat.neighbours.iter().position(|&neighbours| neighbours != NONE).unwrap();
                let back = other.neighbours.iter().position(|&neighbours| neighbours == number as u32).unwrap();
                assert_eq!(flat.corners[side], other.corners[(back + 1) % 3]);
            }
        }
    }

    #[test]
    fn what_cannot_be_is_refused() {
        assert!(triangulate(&SQUARE, [[0, 2], [1, 3]].into_iter()).is_none(), "lines cross");
        let mut points = SQUARE.to_vec();
        points.push([0.5, 0.55]);
        assert!(triangulate(&points, [[0, 2]].into_iter()).is_none(), "a line over a point");
        points[4] = points[0];
        assert!(triangulate(&points, [].into_iter()).is_none(), "twice the same point");
        points[4] = [f64::NAN, 0.0];
        assert!(triangulate(&points, [].into_iter()).is_none());
        points[4] = [1e-300, 0.5];
        assert_eq!(triangulate(&points, [].into_iter()).unwrap().len(), 3);
    }
}
