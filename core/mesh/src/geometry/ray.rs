//! Rays and triangles.

use super::Vec3;

/// Intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// Index of the triangle that is hit.
    pub triangle: u32,
    /// Parameter along the ray, in lengths of its direction.
    pub time: f64,
    /// Barycentric coordinates in the triangle: weights of its three corners, sum 1.
    pub bary: Vec3,
}

/// The first triangle a ray hits, from either side. Tests all triangles, which is faster than a tree for a single ray.
pub fn cast(points: &[Vec3], triangles: &[[u32; 3]], origin: Vec3, direction: Vec3) -> Option<RayHit> {
    let mut first: Option<RayHit> = None;
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some((time, bary)) = meet(corners.map(|v| points[v as usize]), origin, direction)
            && first.is_none_or(|f| time < f.time)
        {
            first = Some(RayHit { triangle: triangle as u32, time, bary });
        }
    }
    first
}

/// Tolerance of barycentric coordinates below zero, so that a ray through the common edge of two triangles does not miss both by rounding.
const EDGE_TOLERANCE: f64 = 1e-9;

/// Parameter and barycentric coordinates of the intersection of a ray with a triangle from either side (Möller and Trumbore 1997).
pub fn meet(corners: [Vec3; 3], origin: Vec3, direction: Vec3) -> Option<(f64, Vec3)> {
    let [a, b, c] = corners;
    let (ab, ac, d) = (b - a, c - a, direction);
    let p = d.cross(&ac);
    let det = ab.dot(&p);
    if det == 0.0 {
        return None;
    }
    let s = origin - a;
    let u = s.dot(&p) / det;
    let q = s.cross(&ab);
    let v = d.dot(&q) / det;
    let time = ac.dot(&q) / det;
    let inside = u >= -EDGE_TOLERANCE && v >= -EDGE_TOLERANCE && u + v <= 1.0 + EDGE_TOLERANCE && time >= 0.0;
    inside.then_some((time, Vec3::new(1.0 - u - v, u, v)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Surface, generate};

    #[test]
    fn a_ray_hits_a_sphere_in_front() {
        let surface = Surface::from_document(&generate::sphere(12, 0.05).unwrap());
        let hit =
            cast(&surface.points, &surface.triangles, Vec3::new(1.0, 0.001, 0.002), Vec3::new(-1.0, 0.0, 0.0)).unwrap();
        assert!((hit.time - 0.95).abs() < 1e-3 && (hit.bary.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(cast(&surface.points, &surface.triangles, Vec3::x(), Vec3::x()), None);
    }
}
