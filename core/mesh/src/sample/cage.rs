//! A control cage of quads, grown by extrusion.
//!
//! A limb is a list of rings, which are cross-sections with position, direction and size. An animal is a table of rings, and extrusion keeps a closed cage
//! closed.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector2;

use crate::geometry::Vec3;

/// Quads on points; lengths in the unit of the rings.
#[derive(Clone, Debug, Default)]
pub(super) struct Cage {
    pub(super) points: Vec<Vec3>, // (n x 3)
    pub(super) quads: Vec<Quad>,
}

/// Four points counter-clockwise seen from outside, and the part of the animal they belong to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Quad {
    pub(super) corners: [u32; 4],
    pub(super) part: usize,
}

/// A cross-section of a limb.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ring {
    /// Centre of the cross-section.
    pub(super) at: [f64; 3],
    /// Direction the limb goes in here; any length.
    pub(super) facing: [f64; 3],
    /// Half the width and half the height.
    pub(super) half: [f64; 2],
}

/// Upward direction of a limb's rings; not parallel to the direction of any ring.
pub(super) type Up = [f64; 3];

impl Ring {
    /// The point of the ring at `place` in [-1, 1]^2, with the square mapped to a disc.
    fn point(&self, up: Up, place: Vector2<f64>) -> Vec3 {
        let [right, up] = axes(up, self.facing.into());
        let squared = place.component_mul(&place);
        let [x, y] = [place.x * (1.0 - 0.5 * squared.y).sqrt(), place.y * (1.0 - 0.5 * squared.x).sqrt()];
        Vec3::from(self.at) + right * (x * self.half[0]) + up * (y * self.half[1])
    }

    pub(super) fn mirrored(&self) -> Self {
        let mirror = |[x, y, z]: [f64; 3]| [-x, y, z];
        Self { at: mirror(self.at), facing: mirror(self.facing), ..*self }
    }
}

impl Cage {
    /// A closed body through `rings`, back to front, each a round lattice of `cells` x `cells` quads. A ring's part is
    /// that of the quads from it to the next; the ends are of the first and last.
    pub(super) fn body(rings: &[(Ring, usize)], up: Up, cells: u32) -> Self {
        let mut cage = Self::default();
        let last = rings.len() as u32 - 1;
        let mut index = BTreeMap::new();
        for (layer, (ring, _)) in (0..).zip(rings) {
            for (i, j) in (0..=cells).flat_map(|j| (0..=cells).map(move |i| (i, j))) {
                if layer == 0 || layer == last || [i, j].iter().any(|&at| at == 0 || at == cells) {
                    let place = Vector2::new(i, j).map(|at| 2.0 * f64::from(at) / f64::from(cells) - 1.0);
                    index.insert([i, j, layer], cage.points.len() as u32);
                    cage.points.push(ring.point(up, place));
                }
            }
        }
        let mut quad = |layer: u32, corners: [[u32; 3]; 4]| {
            cage.quads.push(Quad { corners: corners.map(|at| index[&at]), part: rings[layer as usize].1 });
        };
        for (i, j) in (0..cells).flat_map(|j| (0..cells).map(move |i| (i, j))) {
            quad(0, [[i, j, 0], [i, j + 1, 0], [i + 1, j + 1, 0], [i + 1, j, 0]]);
            quad(last, [[i, j, last], [i + 1, j, last], [i + 1, j + 1, last], [i, j + 1, last]]);
        }
        for (i, k) in (0..last).flat_map(|k| (0..cells).map(move |i| (i, k))) {
            quad(k, [[i, 0, k], [i + 1, 0, k], [i + 1, 0, k + 1], [i, 0, k + 1]]);
            quad(k, [[i, cells, k], [i, cells, k + 1], [i + 1, cells, k + 1], [i + 1, cells, k]]);
            quad(k, [[0, i, k], [0, i, k + 1], [0, i + 1, k + 1], [0, i + 1, k]]);
            quad(k, [[cells, i, k], [cells, i + 1, k], [cells, i + 1, k + 1], [cells, i, k + 1]]);
        }
        cage
    }

    /// The quad whose centroid is closest to `place`.
    pub(super) fn nearest(&self, place: [f64; 3]) -> usize {
        let distance = |quad: usize| (self.middle(&[quad]) - Vec3::from(place)).norm_squared();
        (0..self.quads.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }

    /// Extrudes the connected quads of `root` through `rings`. They and their sides become `part`, except the sides up to the first ring, which keep the
    /// part the limb grows from.
    pub(super) fn limb(&mut self, root: &[usize], up: Up, rings: &[Ring], part: usize) {
        let normal: Vec3 = root.iter().map(|&quad| self.normal(quad)).sum();
        let [right, above] = axes(up, normal);
        let middle = self.middle(root);
        let mut places: BTreeMap<u32, Vector2<f64>> = BTreeMap::new(); // of each point in the root's own ring
        for &corner in root.iter().flat_map(|&quad| &self.quads[quad].corners) {
            let from_middle = self.points[corner as usize] - middle;
            places.insert(corner, Vector2::new(from_middle.dot(&right), from_middle.dot(&above)));
        }
        let reach = places.values().fold(Vector2::zeros(), |reach: Vector2<f64>, place| reach.sup(&place.abs()));
        places.values_mut().for_each(|place| *place = place.component_div(&reach));
        for ring in rings {
            let moved = self.extrude(root);
            root.iter().for_each(|&quad| self.quads[quad].part = part);
            places = places.into_iter().map(|(old, place)| (moved[&old], place)).collect();
            for (&corner, &place) in &places {
                self.points[corner as usize] = ring.point(up, place);
            }
        }
    }

    /// Separates the quads of `root` from the rest and connects both borders by side quads. Returns the new point for each old border point; interior points of
    /// the root keep their indices.
    fn extrude(&mut self, root: &[usize]) -> BTreeMap<u32, u32> {
        let sides = |quad: &Quad| [0, 1, 2, 3].map(|corner| (quad.corners[corner], quad.corners[(corner + 1) % 4]));
        let inside: BTreeSet<(u32, u32)> = root.iter().flat_map(|&quad| sides(&self.quads[quad])).collect();
        let border: Vec<_> = inside.iter().copied().filter(|&(from, to)| !inside.contains(&(to, from))).collect();
        let mut moved: BTreeMap<u32, u32> = inside.iter().map(|&(from, _)| (from, from)).collect();
        for &(from, _) in &border {
            moved.insert(from, self.points.len() as u32);
            self.points.push(self.points[from as usize]);
        }
        for &quad in root {
            self.quads[quad].corners = self.quads[quad].corners.map(|corner| moved[&corner]);
        }
        let part = root.first().map_or(0, |&quad| self.quads[quad].part);
        let walls = border.iter().map(|(from, to)| Quad { corners: [*from, *to, moved[to], moved[from]], part });
        self.quads.extend(walls);
        moved
    }

    /// Normal of a quad; its length is the area.
    pub(super) fn normal(&self, quad: usize) -> Vec3 {
        let [a, b, c, d] = self.quads[quad].corners.map(|corner| self.points[corner as usize]);
        0.5 * (c - a).cross(&(d - b))
    }

    fn middle(&self, quads: &[usize]) -> Vec3 {
        let corners = quads.iter().flat_map(|&quad| self.quads[quad].corners);
        let sum: Vec3 = corners.map(|corner| self.points[corner as usize]).sum();
        sum / (4 * quads.len()) as f64
    }
}

/// Unit vectors to the right and upwards for the viewing direction `facing`.
fn axes(up: Up, facing: Vec3) -> [Vec3; 2] {
    let right = Vec3::from(up).cross(&facing).normalize();
    [right, facing.normalize().cross(&right)]
}
