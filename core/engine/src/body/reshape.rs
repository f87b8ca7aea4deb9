//! Changing the shape a body has at rest: a field of displacements of nodes, and the surface that follows it.
//!
//! The shape at present stays; where the shape at rest has moved away from it, the material pulls the nodes after it.

use super::lattice::Lattice;
use super::{Body, Carrier, LatticeError};
use pliant_solver::Vec3;
use std::sync::Arc;

/// A change of the shape at rest.
#[derive(Debug, Default)]
pub struct RestChange {
    /// Nodes of each node (n x 3), m.
    pub nodes: Vec<Vec3>,
    /// Points of single vertices beyond what their nodes do: what is finer than a cell, m.
    pub points: Vec<(u32, Vec3)>,
}

impl RestChange {
    /// No change of a body with `nodes` nodes.
    pub fn clear(&mut self, nodes: usize) {
        self.nodes.clear();
        self.nodes.resize(nodes, Vec3::zeros());
        self.points.clear();
    }
}

impl Body {
    /// Changes the shape at rest. Cells it would turn over, or flatten to less than a tenth, stay as they are.
    ///
    /// # Errors
    /// A grid or material that fails.
    pub fn reshape(&mut self, change: &mut RestChange) -> Result<(), LatticeError> {
        let Self { model, skin, system, carrier, .. } = self;
        let mut moved: Vec<u32> = Vec::new();
        match carrier {
            Carrier::Lattice(lattice) => {
                lattice.limit_change(&mut change.nodes, &system.nodes.rest);
                let settled = Arc::make_mut(&mut skin.settled);
                lattice.move_points(change, &system.nodes.rest, model, settled, &mut moved)?;
                lattice.move_rest(&change.nodes, &mut system.nodes.rest);
                for &(vertex, d) in &change.points {
                    settled[vertex as usize] += d;
                    moved.push(vertex);
                }
                system.rest()?;
            }
            Carrier::Sheet(sheet) => {
                let settled = Arc::make_mut(&mut skin.settled);
                for (node, d) in change.nodes.iter().enumerate().filter(|(_, d)| **d != Vec3::zeros()) {
                    system.nodes.rest[node] += *d;
                    if let Some(vertex) = sheet.vertex_of(node as u32) {
                        settled[vertex as usize] = system.nodes.rest[node];
                        moved.push(vertex);
                    }
                }
                sheet.lay_out_rest(model, system)?;
            }
        }
        let mut triangles: Vec<u32> = moved.iter().flat_map(|v| model.around(*v)).copied().collect();
        triangles.sort_unstable();
        triangles.dedup();
        std::sync::Arc::make_mut(&mut skin.tree).refit(&skin.settled, &model.surface.triangles, &triangles);
        Ok(())
    }
}

/// Least volume of a corner of a cell, in cells, that a change may leave.
const LEAST_VOLUME: f64 = 0.1;

/// For each corner of a cell (bit i: upper in axis i), its neighbours along x, y and z.
const NEIGHBOURS: [[usize; 3]; 8] =
    [[1, 2, 4], [0, 3, 5], [3, 0, 6], [2, 1, 7], [5, 6, 0], [4, 7, 1], [7, 4, 2], [6, 5, 3]];

impl Lattice {
    /// Takes back the change of nodes whose cells would turn over.
    fn limit_change(&self, change: &mut [Vec3], rest: &[Vec3]) {
        let least = LEAST_VOLUME * self.edge().powi(3);
        for corners in &self.region().cell_corners {
            if corners.iter().all(|&n| change[n as usize] == Vec3::zeros()) {
                continue;
            }
            let at = |move_: bool| {
                corners.map(|n| if move_ { rest[n as usize] + change[n as usize] } else { rest[n as usize] })
            };
            let (before, after) = (least_volume(&at(false)), least_volume(&at(true)));
            if after < least && after < before {
                corners.iter().for_each(|&n| change[n as usize] = Vec3::zeros());
            }
        }
    }
}

/// The least volume spanned by the three edges at a corner of a cell, m^3.
fn least_volume(corners: &[Vec3; 8]) -> f64 {
    let volume = |(corner, near): (usize, &[usize; 3])| {
        let [x, y, z] = near.map(|n| corners[n] - corners[corner]);
        let sign = if corner.count_ones().is_multiple_of(2) { 1.0 } else { -1.0 };
        sign * x.cross(&y).dot(&z)
    };
    NEIGHBOURS.iter().enumerate().map(volume).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_has_its_volume_at_every_corner_and_one_turned_over_less_than_none() {
        let corners: [Vec3; 8] =
            std::array::from_fn(|i| Vec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64));
        assert_eq!(least_volume(&corners), 1.0);
        let mut turned = corners;
        turned[7] = Vec3::new(-0.5, -0.5, -0.5);
        assert!(least_volume(&turned) < 0.0);
    }
}
