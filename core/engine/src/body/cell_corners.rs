//! Corners of the cells of a lattice that faces go through.

use pliant_mesh::geometry::meets_cube;
use pliant_plugin_api::abi::Level;
use pliant_solver::Vec3;
use std::collections::HashSet;

/// A face this near to a plane between cells, in lengths of the whole lattice, is in the plane and not in the cells beyond it: a grid may be that
/// much larger than the body.
const MARGIN: f64 = 1e-6;

/// Nodes of a lattice by their place in it.
#[derive(Clone, Debug, PartialEq)]
pub struct CellCorners {
    /// A corner of a cell, m.
    origin: Vec3,
    /// Edge of a cell, m.
    edge: f64,
    /// Share of an edge by which cells are taken smaller.
    margin: f64,
    /// Edges from the origin along each axis.
    nodes: HashSet<[i64; 3]>,
}

impl CellCorners {
    /// The corners of all cells of a lattice that triangles (corners in m) go through. Of a triangle in a plane of the lattice those in the plane.
    pub fn of(triangles: impl Iterator<Item = [Vec3; 3]>, lattice: &Level) -> Self {
        let (origin, edge) = (lattice.origin.into(), lattice.edge);
        let margin = MARGIN * f64::from(lattice.cells_per_axis);
        let mut all = Self { origin, edge, margin, nodes: HashSet::new() };
        for corners in triangles {
            let [a, b, c] = corners.map(|corner| (corner - origin) / edge);
            let (min, max) = (a.inf(&b).inf(&c).map(f64::floor), a.sup(&b).sup(&c).map(f64::ceil));
            let count = ((max - min).max() as u64 + 1).next_power_of_two();
            all.add(corners, <[f64; 3]>::from(min).map(|least| least as i64), count);
        }
        all
    }

    /// Adds the corners among `count`^3 nodes, a power of two, from `least` on. A cube of nodes that the triangle does not come near is
    /// passed over as a whole.
    fn add(&mut self, triangle: [Vec3; 3], least: [i64; 3], count: u64) {
        let to_middle = 0.5 * (count - 1) as f64;
        let middle = self.origin + self.edge * Vec3::from(least.map(|i| i as f64 + to_middle));
        // A node is a corner of a cell that the triangle goes through if the eight cells around it meet the triangle.
        if !meets_cube(triangle, middle, self.edge * (to_middle + 1.0 - self.margin)) {
            return;
        }
        if count == 1 {
            self.nodes.insert(least);
            return;
        }
        for octant in 0..8 {
            let shift = |axis: usize| if octant >> axis & 1 == 1 { (count / 2) as i64 } else { 0 };
            self.add(triangle, std::array::from_fn(|axis| least[axis] + shift(axis)), count / 2);
        }
    }

    /// Whether the node at this rest position (m) is one of them.
    pub fn holds(&self, rest: Vec3) -> bool {
        let place = (rest - self.origin) / self.edge;
        self.nodes.contains(&<[f64; 3]>::from(place).map(|along| along.round() as i64))
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::testing::Random;

    fn lattice(origin: Vec3, edge: f64) -> Level {
        let counts = Level {
            size: 0,
            level: 5,
            cells_per_axis: 16,
            surface_cells: 1,
            inside_cells: 0,
            nodes: 8,
            edge,
            origin: [0.0; 3],
        };
        Level { origin: origin.into(), ..counts }
    }

    #[test]
    fn all_corners_of_cells_with_a_piece_of_the_face_are_held_and_no_others() {
        let mut random = Random(8);
        for _ in 0..40 {
            let (origin, edge) = (Vec3::from_fn(|_, _| random.unit()), 0.05 + 0.2 * random.unit());
            let corners = [0, 1, 2].map(|_| Vec3::from_fn(|_, _| 2.0 * random.unit() - 1.0));
            let held = CellCorners::of(std::iter::once(corners), &lattice(origin, edge));
            // Cells with one of many places of the triangle, a tenth of an edge apart.
            let n =
                10 + (10.0 * (corners[1] - corners[0]).norm().max((corners[2] - corners[0]).norm()) / edge) as usize;
            let node = |at: [f64; 3]| origin + edge * Vec3::from(at);
            for (i, j) in (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j))) {
                let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
                let place = corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0]);
                let along = (place - origin) / edge;
                if along.iter().any(|c| (c - c.round()).abs() < 2.0 * held.margin) {
                    continue;
                }
                let cell = along.map(f64::floor);
                for corner in 0..8 {
                    let at: [f64; 3] = std::array::from_fn(|axis| cell[axis] + f64::from(corner >> axis & 1));
                    assert!(held.holds(node(at)), "{corners:?} {place:?} {at:?}");
                }
            }
            let mut count = 0;
            for (i, j, k) in (-60..60).flat_map(|i| (-60..60).flat_map(move |j| (-60..60).map(move |k| (i, j, k)))) {
                let place = node([f64::from(i), f64::from(j), f64::from(k)]);
                if held.holds(place) {
                    count += 1;
                    let near = pliant_mesh::geometry::closest_point(place, corners).point - place;
                    assert!(near.abs().max() < 3_f64.sqrt() * edge, "{corners:?} {place:?}");
                }
            }
            assert_eq!(count, held.nodes.len());
        }
    }

    #[test]
    fn a_face_in_a_plane_of_the_lattice_holds_the_nodes_in_it() {
        let face = [[0.0, 0.0, 0.3], [0.4, 0.0, 0.3], [0.0, 0.4, 0.3]].map(Vec3::from);
        let held = CellCorners::of(std::iter::once(face), &lattice(Vec3::zeros(), 0.1));
        assert!(held.nodes.len() >= 15 && held.nodes.iter().all(|[_, _, k]| *k == 3), "{held:?}");
        assert!(CellCorners::of(std::iter::empty(), &lattice(Vec3::zeros(), 0.1)).is_empty());
    }
}
