//! A bounding volume hierarchy over the triangles of a surface, by parry.
//!
//! A leaf holds up to four triangles that are near each other (`groups`), and the box of each is kept, so queries find exactly what a leaf for each triangle
//! would find, at a quarter of the nodes. parry uses glam and this project nalgebra; this is the only file that converts. The boxes are those of the
//! settled surface and are refitted only when a shape is kept. Deformed triangles are found through the cells of the grid instead, so no step refits
//! (1.8 ms for all of 70,000 triangles).

use super::Vec3;
use super::groups::{GROUP, groups};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};
use std::cell::Cell;

/// A bounding volume hierarchy over triangles.
#[derive(Clone)]
pub struct TriangleTree {
    /// Its leaves are groups of triangles.
    bvh: Bvh,
    /// Box of each triangle; inverted for one that was removed or never set.
    boxes: Vec<Aabb>,
    /// Triangles by group, [`GROUP`] each.
    members: Vec<u32>,
    /// Place of each triangle in `members`.
    place: Vec<u32>,
    /// Number of `members`, from the first, that [`TriangleTree::new`] or [`TriangleTree::regroup`] has grouped.
    grouped: usize,
}

/// Converts a vector to parry's type.
fn to_parry(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

fn bounds(points: &[Vec3], triangle: [u32; 3]) -> Aabb {
    let [a, b, c] = triangle.map(|v| points[v as usize]);
    Aabb::new(to_parry(a.inf(&b).inf(&c)), to_parry(a.sup(&b).sup(&c)))
}

/// The smallest box around the boxes of these triangles.
fn around(boxes: &[Aabb], members: &[u32]) -> Aabb {
    members
        .iter()
        .map(|t| &boxes[*t as usize])
        .fold(Aabb::new_invalid(), |all, own| Aabb::new(all.mins.min(own.mins), all.maxs.max(own.maxs)))
}

/// The middle of a box.
fn middle(own: &Aabb) -> [f64; 3] {
    own.center().into()
}

/// Whether a box has no inside and no boundary: that of no triangle.
fn is_empty(bounds: &Aabb) -> bool {
    bounds.mins.x > bounds.maxs.x
}

impl TriangleTree {
    /// Builds the tree of all `triangles`.
    pub fn new(points: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let boxes: Vec<Aabb> = triangles.iter().map(|t| bounds(points, *t)).collect();
        let members = groups(boxes.iter().map(middle));
        let mut place = vec![0; members.len()];
        members.iter().enumerate().for_each(|(at, t)| place[*t as usize] = at as u32);
        let leaves = members.chunks(GROUP).map(|group| around(&boxes, group)).enumerate();
        let bvh = Bvh::from_iter(BvhBuildStrategy::Binned, leaves);
        let grouped = members.len();
        Self { bvh, boxes, members, place, grouped }
    }

    /// Calls `visit` with every triangle whose box meets a condition, which must hold for a box if it holds for a part of the box.
    fn visit(&self, meets: impl Fn(Vector, Vector) -> bool, mut visit: impl FnMut(u32)) {
        for group in self.bvh.leaves(|node| meets(node.mins(), node.maxs())) {
            for &triangle in self.group(group) {
                let own = &self.boxes[triangle as usize];
                if !is_empty(own) && meets(own.mins, own.maxs) {
                    visit(triangle);
                }
            }
        }
    }

    /// Triangles of a leaf.
    fn group(&self, leaf: u32) -> &[u32] {
        let first = leaf as usize * GROUP;
        &self.members[first..self.members.len().min(first + GROUP)]
    }

    /// Calls `visit` with every triangle whose box intersects the box around `centre` with the half-size `reach` (both in m).
    pub fn near(&self, centre: Vec3, reach: f64, visit: impl FnMut(u32)) {
        let (centre, half) = (to_parry(centre), Vector::from([reach; 3]));
        let (low, high) = (centre - half, centre + half);
        self.visit(|min, max| min.cmple(high).all() && max.cmpge(low).all(), visit);
    }

    /// Calls `visit` with every triangle whose box comes within a distance (m) of `centre`, and possibly with others. The distance is `reach` at first, and what
    /// `visit` returned last after that, so a search for the closest triangle visits few.
    pub fn near_within(&self, centre: Vec3, reach: f64, mut visit: impl FnMut(u32) -> f64) {
        const SPARE: f64 = 1e-12;
        let centre = to_parry(centre);
        let spare = SPARE * centre.length();
        let within = Cell::new(reach);
        let is_within = |min: Vector, max: Vector| {
            let outside = (min - centre).max(centre - max).max(Vector::ZERO);
            outside.length() <= (1.0 + SPARE) * within.get() + spare
        };
        self.visit(is_within, |triangle| within.set(visit(triangle)));
    }

    /// Updates the boxes of the triangles `changed` and of their parents.
    pub fn refit(&mut self, points: &[Vec3], triangles: &[[u32; 3]], changed: &[u32]) {
        changed.iter().for_each(|&t| self.set_box(t, bounds(points, triangles[t as usize])));
        let mut leaves: Vec<u32> = changed.iter().map(|t| self.place[*t as usize] / GROUP as u32).collect();
        leaves.sort_unstable();
        leaves.dedup();
        for &leaf in &leaves {
            self.bvh.insert_or_update_partially(around(&self.boxes, self.group(leaf)), leaf, 0.0);
        }
        self.bvh.refit_partial(&[], &leaves);
    }

    /// Inserts a triangle, or updates its box.
    pub fn set(&mut self, triangle: u32, corners: [Vec3; 3]) {
        self.set_box(triangle, bounds(&corners, [0, 1, 2]));
        self.update_leaf_of(triangle);
    }

    /// Removes a triangle.
    pub fn remove(&mut self, triangle: u32) {
        if (triangle as usize) < self.boxes.len() {
            self.set_box(triangle, Aabb::new_invalid());
            self.update_leaf_of(triangle);
            self.grouped = self.grouped.min(triangle as usize);
        }
    }

    /// Groups the triangles that were inserted since the last time by where they are. Until then they are grouped by number, and queries are slow where triangles with successive
    /// numbers are far apart.
    pub fn regroup(&mut self) {
        let first = self.grouped.next_multiple_of(GROUP).min(self.members.len());
        self.grouped = self.members.len();
        let inserted = self.members[first..].to_vec();
        let (present, removed): (Vec<u32>, Vec<u32>) =
            inserted.into_iter().partition(|t| !is_empty(&self.boxes[*t as usize]));
        let middles = present.iter().map(|t| middle(&self.boxes[*t as usize]));
        let order = groups(middles).into_iter().map(|at| present[at as usize]).chain(removed);
        for (at, triangle) in (first..).zip(order) {
            self.members[at] = triangle;
            self.place[triangle as usize] = at as u32;
        }
        for leaf in (first / GROUP) as u32..self.members.len().div_ceil(GROUP) as u32 {
            let all = around(&self.boxes, self.group(leaf));
            self.bvh.remove(leaf);
            if !is_empty(&all) {
                self.bvh.insert(all, leaf);
            }
        }
    }

    /// Sets the box of a triangle. New triangles are grouped by their numbers: pieces of a cut are near each other.
    fn set_box(&mut self, triangle: u32, own: Aabb) {
        for new in self.boxes.len() as u32..=triangle {
            self.boxes.push(Aabb::new_invalid());
            self.place.push(new);
            self.members.push(new);
        }
        self.boxes[triangle as usize] = own;
    }

    /// Updates the leaf that a triangle belongs to after its box has changed.
    fn update_leaf_of(&mut self, triangle: u32) {
        let leaf = self.place[triangle as usize] / GROUP as u32;
        let all = around(&self.boxes, self.group(leaf));
        if is_empty(&all) {
            self.bvh.remove(leaf);
        } else {
            self.bvh.insert(all, leaf);
        }
    }

    /// Calls `visit` with every triangle whose box comes within `margin` (m) of the triangle `facet`. A box is excluded if the plane of the facet, a plane through
    /// one of its sides, or its bounding box separates the two, so a long thin facet does not visit everything in its bounding box.
    pub fn near_facet(&self, facet: [Vec3; 3], margin: f64, visit: impl FnMut(u32)) {
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
        let meets = |min: Vector, max: Vector| {
            let (middle, half) = (0.5 * (min + max), 0.5 * (max - min));
            min.cmple(high).all()
                && max.cmpge(low).all()
                && slabs.iter().all(|(axis, size, at, reach)| (axis.dot(middle) - at).abs() <= reach + size.dot(half))
        };
        self.visit(meets, visit);
    }

    /// Calls `visit` with every triangle whose box intersects the segment, and possibly a few others. Uses separating axes with a tolerance, because parry's ray
    /// test misses flat boxes by rounding.
    pub fn along(&self, from: Vec3, to: Vec3, visit: impl FnMut(u32)) {
        const SPARE: f64 = 1e-12;
        let (from, to) = (to_parry(from), to_parry(to));
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let size = half.abs();
        let spare = SPARE * (size.length() + middle.abs().length());
        let meets = |min: Vector, max: Vector| {
            let (away, reach) = (middle - 0.5 * (min + max), 0.5 * (max - min) + Vector::from([spare; 3]));
            let turn = half.cross(away).abs();
            away.abs().cmple(size + reach).all()
                && turn.x <= reach.y * size.z + reach.z * size.y
                && turn.y <= reach.x * size.z + reach.z * size.x
                && turn.z <= reach.x * size.y + reach.y * size.x
        };
        self.visit(meets, visit);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;
    use crate::{Surface, generate};
    use parry3d_f64::bounding_volume::BoundingVolume;
    use parry3d_f64::query::PointQuery;

    #[test]
    fn boxes_find_the_same_triangles_as_looking_at_all() {
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
    }

    /// Triangles all over a sphere, inserted in random order, are looked at as if the tree had been built with them.
    #[test]
    fn grouped_triangles_are_found_among_few() {
        let surface = Surface::from_document(&generate::sphere(40, 0.05).unwrap());
        let mut order: Vec<[Vec3; 3]> =
            surface.triangles.iter().map(|t| t.map(|v| surface.points[v as usize])).collect();
        let random = &mut Random(3);
        (1..order.len()).for_each(|last| order.swap(last, random.below(last as u64 + 1) as usize));
        let mut tree = TriangleTree::new(&[], &[]);
        (0..).zip(&order).for_each(|(triangle, corners)| tree.set(triangle, *corners));
        let looked_at = |tree: &TriangleTree| {
            let count = Cell::new(0);
            let from = to_parry(Vec3::new(0.05, 0.0, 0.0));
            let is_near = |min: Vector, max: Vector| {
                count.set(count.get() + 1);
                (from.clamp(min, max) - from).length() < 1e-3
            };
            tree.visit(is_near, |_| {});
            count.get()
        };
        let before = looked_at(&tree);
        tree.regroup();
        let built = TriangleTree::new(&surface.points, &surface.triangles);
        let (after, best) = (looked_at(&tree), looked_at(&built));
        assert!(before > 4 * best && after < 2 * best, "{before} boxes before, {after} after, {best} in a new tree");
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

    /// Triangles in random order around a sphere; some are moved, removed, added and regrouped. Every query finds what looking at all boxes finds.
    #[test]
    fn queries_find_the_same_triangles_as_looking_at_all_after_any_change() {
        for seed in 0..30 {
            let mut random = Random(seed);
            let count = random.below(400) as usize;
            let corners = |random: &mut Random| {
                let (middle, size) = (random.direction(), 10_f64.powi(-(random.below(3) as i32)));
                [0, 1, 2].map(|_| middle + 0.3 * size * random.vector())
            };
            let mut present: Vec<Option<[Vec3; 3]>> = (0..count).map(|_| Some(corners(&mut random))).collect();
            let points: Vec<Vec3> = present.iter().flatten().flatten().copied().collect();
            let triangles: Vec<[u32; 3]> = (0..count as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
            let mut tree = TriangleTree::new(&points, &triangles);
            for change in 0..60 {
                let triangle = random.below(present.len() as u64 + 3) as usize;
                if random.below(3) == 0 {
                    tree.remove(triangle as u32);
                    present.get_mut(triangle).map(Option::take);
                } else {
                    let to = corners(&mut random);
                    tree.set(triangle as u32, to);
                    present.resize(present.len().max(triangle + 1), None);
                    present[triangle] = Some(to);
                }
                if random.below(8) == 0 {
                    tree.regroup();
                }
                let (centre, reach) = (1.2 * random.vector(), 0.5 * random.unit());
                let expected = |meets: &dyn Fn(&Aabb) -> bool| -> Vec<u32> {
                    let boxes = present.iter().map(|c| c.map(|corners| bounds(&corners, [0, 1, 2])));
                    (0..).zip(boxes).filter(|(_, own)| own.as_ref().is_some_and(meets)).map(|(t, _)| t).collect()
                };
                let sorted = |mut found: Vec<u32>| {
                    found.sort_unstable();
                    found
                };
                let (mut near, mut within) = (Vec::new(), Vec::new());
                tree.near(centre, reach, |t| near.push(t));
                tree.near_within(centre, reach, |t| {
                    within.push(t);
                    reach
                });
                let query =
                    Aabb::new(to_parry(centre) - Vector::from([reach; 3]), to_parry(centre) + Vector::from([reach; 3]));
                assert_eq!(sorted(near), expected(&|own| own.intersects(&query)), "seed {seed}, change {change}");
                let is_within = |own: &Aabb| own.distance_to_local_point(to_parry(centre), true) <= reach;
                assert_eq!(sorted(within), expected(&is_within), "seed {seed}, change {change}");
            }
        }
    }
}
