//! Flips of edges of nearly flat walls towards a Delaunay triangulation.

use super::Vec3;
use super::fans::rename;
use super::record::{NONE, Triangle};
use super::refine::{Ends, WallEdge, Walls, ordered};

/// Largest distance between an edge and the one it is flipped to, in longest edges. Both walls move alike, so that no volume is lost, but a vertex that comes to be
/// in the middle of the new edge must be on its side of the blade's path in the grid too.
const FLAT: f64 = 0.01;
/// The same where the wall opposite has other triangles, as where a later cut has met one of the two only.
const IN_PLANE: f64 = 1e-9;
/// Largest difference of texture coordinates at a corner across an edge that is flipped, in longest edges.
const SAME_TEXTURE: f64 = 1e-3;
/// Least height of a triangle that a flip makes over its new edge, in longest edges.
const LEAST_HEIGHT: f64 = 1e-6;
/// Least cosine of the angle between a triangle that a flip makes and the wall.
const LEAST_COSINE: f64 = 0.99;
/// How far from Delaunay an edge is flipped, as a sum of two cotangents: above rounding, so that four corners on a circle stay.
const ROUNDING: f64 = 1e-9;
/// Bound of the number of edges seen after one change, for each of the edges it begins with: on walls that are not quite flat nothing else says that
/// flips come to an end.
const MOST_SEEN: usize = 32;

impl Walls<'_> {
    /// Flips the edges `begin` and those around them until all are Delaunay.
    pub fn flip_around(&mut self, begin: Vec<Ends>) {
        let mut left = MOST_SEEN * begin.len();
        let mut stack = begin;
        while let Some(ends) = stack.pop() {
            if left == 0 {
                return;
            }
            left -= 1;
            let Some(edge) = self.edge(ends) else { continue };
            let [c, d] = edge.apexes[..] else { continue };
            if self.is_better(ends, &edge, [c, d]) && self.can_flip(&edge, [c, d]) {
                self.flip(&edge);
                self.wait([c, d]);
                for end in ends {
                    for apex in [c, d] {
                        self.wait(ordered(end, apex));
                        stack.push(ordered(end, apex));
                    }
                }
            }
        }
    }

    /// Whether an edge is not Delaunay, and the edge between its apexes lies in the same plane and divides the same area.
    fn is_better(&self, ends: Ends, edge: &WallEdge, apexes: Ends) -> bool {
        let [a, b, c, d] = [ends[0], ends[1], apexes[0], apexes[1]].map(|place| self.positions[place as usize]);
        let cotangent = |apex: Vec3| {
            let (u, v) = (a - apex, b - apex);
            u.dot(&v) / u.cross(&v).norm()
        };
        // Of two angles that add up to more than pi the sum of the cotangents is negative.
        let sum = cotangent(c) + cotangent(d);
        if sum.is_nan() || sum >= -ROUNDING {
            return false;
        }
        let normals = ends.map(|place| self.normals[place as usize]);
        let Some(normal) = (normals[0] + normals[0].dot(&normals[1]).signum() * normals[1]).try_normalize(0.0) else {
            return false;
        };
        // Twice the areas in the plane of the wall: on a sliver the corners alone do not tell it.
        let area = |p: Vec3, q: Vec3, r: Vec3| (q - p).cross(&(r - p)).dot(&normal);
        let ([at_c, at_d], [at_a, at_b]) = ([area(a, b, c), area(a, b, d)], [area(c, d, a), area(c, d, b)]);
        let least = LEAST_HEIGHT * self.longest * (d - c).norm();
        if at_c * at_d >= 0.0 || at_a * at_b >= 0.0 || at_a.abs().min(at_b.abs()) <= least {
            return false;
        }
        // Slivers of a bent wall may stand across it, and tell others a wrong direction of the wall.
        let is_along = |p: Vec3, q: Vec3, r: Vec3| {
            let cross = (q - p).cross(&(r - p));
            cross.dot(&normal).abs() >= LEAST_COSINE * cross.norm()
        };
        if !is_along(c, d, a) || !is_along(c, d, b) {
            return false;
        }
        let crossing = [a.lerp(&b, at_a / (at_a - at_b)), c.lerp(&d, at_c / (at_c - at_d))];
        let flat = if self.is_mirrored(ends, edge, apexes[0]) { FLAT } else { IN_PLANE };
        (crossing[1] - crossing[0]).dot(&normal).abs() <= flat * self.longest
    }

    /// Whether as many walls face one way as the other, so that the volume between them stays the same.
    fn is_mirrored(&self, ends: Ends, edge: &WallEdge, apex: u32) -> bool {
        let halves = edge.rings.iter().flatten().filter(|half| self.apex(**half) == apex);
        halves.map(|half| if self.place_of(*half) == ends[0] { 1 } else { -1 }).sum::<i32>() == 0
    }

    /// Whether an edge has the same two triangles in each wall, with the same texture across it, and its apexes have no edge yet.
    fn can_flip(&self, edge: &WallEdge, apexes: Ends) -> bool {
        let is_pair = |ring: &Vec<u32>| {
            let [g, h] = ring[..] else { return false };
            let corners = |half: u32| [half, half - half % 3 + (half % 3 + 1) % 3];
            let ([a, b], [c, d]) = (corners(g), corners(h));
            g / 3 != h / 3
                && self.mesh.tail(a) == self.mesh.tail(d)
                && self.mesh.tail(b) == self.mesh.tail(c)
                && ordered(self.apex(g), self.apex(h)) == apexes
                && self.is_same_texture(a, d)
                && self.is_same_texture(b, c)
        };
        !self.half_edges.contains_key(&apexes) && edge.rings.iter().all(is_pair)
    }

    fn is_same_texture(&self, a: u32, b: u32) -> bool {
        let [p, q] = [a, b].map(|corner| self.mesh.texture[corner as usize / 3][corner as usize % 3]);
        if p == NONE || q == NONE {
            return p == q;
        }
        let [p, q] = [p, q].map(|row| self.mesh.texcoords[row as usize]);
        (0..2).all(|i| (p[i] - q[i]).abs() <= SAME_TEXTURE * self.longest)
    }

    /// Flips an edge in all walls.
    fn flip(&mut self, edge: &WallEdge) {
        for ring in &edge.rings {
            let [g, h] = [ring[0], ring[1]];
            [g, h].iter().for_each(|half| self.unlist(half / 3));
            let [old_g, old_h] = [g, h].map(|half| self.mesh.triangle(half / 3));
            let side = |half: u32, step: u32| half - half % 3 + (half % 3 + step) % 3;
            // Each triangle keeps its side behind the edge. The corner at the beginning of the edge becomes the other's apex.
            let turned = |old: Triangle, half: u32, other: Triangle, from: u32| {
                let (corner, apex) = (half as usize % 3, side(from, 2) as usize % 3);
                let mut new = old;
                new.corners[corner] = other.corners[apex];
                new.texture[corner] = other.texture[apex];
                new
            };
            let (new_g, new_h) = (turned(old_g, g, old_h, h), turned(old_h, h, old_g, g));
            self.mesh.set_triangle(g / 3, new_g);
            self.mesh.set_triangle(h / 3, new_h);
            rename(self.mesh, side(h, 2), g);
            rename(self.mesh, side(g, 2), h);
            self.mesh.link_around_edge(&[side(g, 2), side(h, 2)]);
            [g, h].iter().for_each(|half| self.list(half / 3));
        }
    }
}
