//! A bounding volume hierarchy over the triangles of a surface, by parry, and ray queries.
//!
//! parry uses glam and this project nalgebra; this is the only file that converts. The boxes are those of the settled surface and are refitted only when a
//! shape is kept. Deformed triangles are found through the cells of the grid instead, so no step refits (1.8 ms for all of 70,000 triangles).

use super::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use std::cell::Cell;

/// A bounding volume hierarchy over triangles.
#[derive(Clone)]
pub struct TriangleTree {
    bvh: Bvh,
}

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

/// Converts a vector to parry's type.
fn to_parry(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn bounds(points: &[Vec3], triangle: [u32; 3]) -> Aabb {
    let [a, b, c] = triangle.map(|v| points[v as usize]);
    Aabb::new(to_parry(a.inf(&b).inf(&c)), to_parry(a.sup(&b).sup(&c)))
}

impl TriangleTree {
    /// Builds the tree of all `triangles`.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let leaves: Vec<Aabb> = triangles.iter().map(|t| bounds(points, *t)).collect();
        Self { bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves) }
    }

    /// Calls `visit` with every triangle whose box intersects the box around `centre` with the half-size `reach` (both in m).
    pub fn near(&self, centre: Vec3, reach: f64, mut visit: impl FnMut(u32)) {
        let (centre, half) = (to_parry(centre), Vector::from([reach; 3]));
        let query = Aabb::new(centre - half, centre + half);
        self.bvh.intersect_aabb(&query).for_each(&mut visit);
    }

    /// Calls `visit` with every triangle whose box comes within a distance (m) of `centre`, and possibly with others. The distance is `reach` at first, and what
    /// `visit` returned last after that, so a search for the closest triangle visits few.
    pub fn near_within(&self, centre: Vec3, reach: f64, mut visit: impl FnMut(u32) -> f64) {
        const SPARE: f64 = 1e-12;
        let centre = to_parry(centre);
        let spare = SPARE * centre.length();
        let within = Cell::new(reach);
        let leaves = self.bvh.leaves(|node| {
            let outside = (node.mins() - centre).max(centre - node.maxs()).max(Vector::ZERO);
            outside.length() <= (1.0 + SPARE) * within.get() + spare
        });
        leaves.for_each(|triangle| within.set(visit(triangle)));
    }

    /// Updates the boxes of the triangles `changed` and of their parents.
    pub fn refit(&mut self, points: &[Vec3], triangles: &[[u32; 3]], changed: &[u32]) {
        for &t in changed {
            self.bvh.insert_or_update_partially(bounds(points, triangles[t as usize]), t, 0.0);
        }
        self.bvh.refit_partial(&[], changed);
    }

    /// Inserts a triangle, or updates its box.
    pub fn set(&mut self, triangle: u32, corners: [Vec3; 3]) {
        self.bvh.insert(bounds(&corners, [0, 1, 2]), triangle);
    }

    /// Removes a triangle.
    pub fn remove(&mut self, triangle: u32) {
        self.bvh.remove(triangle);
    }

    /// Calls `visit` with every triangle whose box comes within `margin` (m) of the triangle `facet`. A box is excluded if the plane of the facet, a plane through
    /// one of its sides, or its bounding box separates the two, so a long thin facet does not visit everything in its bounding box.
    pub fn near_facet(&self, facet: [Vec3; 3], margin: f64, mut visit: impl FnMut(u32)) {
        let [a, b, c] = facet.map(to_parry);
        let normal = (b - a).cross(c - a);
        let axes = [normal, normal.cross(b - a), normal.cross(c - b), normal.cross(a - c)];
        let slabs = axes.map(|axis| {
            let reach = [a, b, c].map(|corner| axis.dot(corner));
            let low = reach[0].min(reach[1]).min(reach[2]);
            let high = reach[0].max(reach[1]).max(reach[2]);
            (axis, axis.abs(), 0.5 * (low + high), 0.5 * (high - low) + margin * axis.length())
        });
        let own = bounds(&facet, [0, 1, 2]);
        let (low, high) = (own.mins - Vector::from([margin; 3]), own.maxs + Vector::from([margin; 3]));
        let leaves = self.bvh.leaves(|node| {
            let (min, max) = (node.mins(), node.maxs());
            let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
            min.cmple(high).all()
                && max.cmpge(low).all()
                && slabs.iter().all(|(axis, size, at, reach)| (axis.dot(middle) - at).abs() <= reach + size.dot(half))
        });
        leaves.for_each(&mut visit);
    }

    /// Calls `visit` with every triangle whose box intersects the segment, and possibly a few others. Uses separating axes with a tolerance, because parry's ray
    /// test misses flat boxes by rounding.
    pub fn along(&self, from: Vec3, to: Vec3, mut visit: impl FnMut(u32)) {
        const SPARE: f64 = 1e-12;
        let (from, to) = (to_parry(from), to_parry(to));
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let size = half.abs();
        let spare = SPARE * (size.length() + middle.abs().length());
        let leaves = self.bvh.leaves(|node| {
            let (min, max) = (node.mins(), node.maxs());
            let (away, reach) = (middle - 0.5 * (min + max), 0.5 * (max - min) + Vector::from([spare; 3]));
            let turn = half.cross(away).abs();
            away.abs().cmple(size + reach).all()
                && turn.x <= reach.y * size.z + reach.z * size.y
                && turn.y <= reach.x * size.z + reach.z * size.x
                && turn.z <= reach.x * size.y + reach.y * size.x
        });
        leaves.for_each(&mut visit);
    }
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
    fn rays_and_boxes_find_the_same_triangles_as_looking_at_all() {
        let surface = Surface::from_document(&generate::sphere(12, 0.05).unwrap());
        let tree = TriangleTree::new(&surface.points, &surface.triangles);
        let mut found = Vec::new();
        tree.near(Vec3::new(0.05, 0.0, 0.0), 0.01, |t| found.push(t));
        found.sort_unstable();
        let touches = |t: &[u32; 3]| {
            (0..3).all(|i| {
                let of = t.map(|v| surface.points[v as usize][i] - [0.05, 0.0, 0.0][i]);
                of.iter().any(|c| *c <= 0.01) && of.iter().any(|c| *c >= -0.01)
            })
        };
        let all: Vec<u32> =
            (0..surface.triangles.len() as u32).filter(|&t| touches(&surface.triangles[t as usize])).collect();
        assert!(!all.is_empty() && found == all);
        let hit =
            cast(&surface.points, &surface.triangles, Vec3::new(1.0, 0.001, 0.002), Vec3::new(-1.0, 0.0, 0.0)).unwrap();
        assert!((hit.time - 0.95).abs() < 1e-3 && (hit.bary.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(cast(&surface.points, &surface.triangles, Vec3::x(), Vec3::x()), None);
    }

    #[test]
    fn a_refitted_triangle_is_found_where_it_went() {
        let mut surface = Surface::from_document(&generate::sphere(6, 0.05).unwrap());
        let mut tree = TriangleTree::new(&surface.points, &surface.triangles);
        for v in surface.triangles[7] {
            surface.points[v as usize][0] += 1.0;
        }
        let changed: Vec<u32> = (0..surface.triangles.len() as u32).collect();
        tree.refit(&surface.points, &surface.triangles, &changed);
        let mut found = false;
        let centre = surface.points[surface.triangles[7][0] as usize];
        tree.near(centre, 1e-4, |t| found |= t == 7);
        assert!(found);
    }

    #[test]
    fn the_closest_triangle_is_found_among_few() {
        for cells in [1, 3, 20, 60] {
            let surface = Surface::from_document(&generate::sphere(cells, 0.05).unwrap());
            let tree = TriangleTree::new(&surface.points, &surface.triangles);
            for i in 0..200 {
                let way = [0.7, 1.3, 2.9].map(|k| (k * f64::from(i)).sin());
                let from = 5e-4 * f64::from(i) * Vec3::from(way);
                let distance = |t: u32| {
                    let corners = surface.triangles[t as usize].map(|v| surface.points[v as usize]);
                    (super::super::closest_point(from, corners).point - from).norm()
                };
                let all = (0..surface.triangles.len() as u32).map(distance).fold(f64::INFINITY, f64::min);
                for reach in [0.5 * all, all, 2.0 * all, f64::MAX] {
                    let (mut found, mut visits) = (f64::INFINITY, 0);
                    tree.near_within(from, reach, |t| {
                        visits += 1;
                        found = found.min(distance(t));
                        found.min(reach)
                    });
                    assert!(reach < all || found == all, "{cells} {i} {reach}: {found} {all}");
                    // From the middle all triangles are equally close.
                    let share = f64::from(visits) / surface.triangles.len() as f64;
                    assert!(cells < 60 || from.norm() < 0.02 || share < 0.1, "{cells} {i}: {share} visited");
                }
            }
        }
    }
}
