//! Which triangles a tool may touch.
//!
//! Two sides. What is settled is found in the tree over the settled surface. What follows nodes is found through the cells
//! that carry it: a vertex lies in the hull of its cell's eight corners, so a cell whose box is out of reach holds none that
//! is within. Both are exact, and neither costs more on a larger model.

use super::closest::{Closest, closest_point};
use crate::body::{Lattice, LatticeError, Model, Skin};
use crate::step::{Nodes, V3, axpy, dot};
use pliant_plugin_api::abi;

/// A triangle, and the point of it closest to where the search was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Of which body.
    pub body: u32,
    /// Which.
    pub triangle: u32,
    /// m
    pub corners: [V3; 3],
    /// To the centre of the search.
    pub closest: Closest,
    /// m
    pub distance: f64,
}

/// The search, with its buffers.
#[derive(Default)]
pub struct NearTriangles {
    /// What was found last, in order of triangle.
    pub found: Vec<Near>,
    candidates: Vec<u32>,
    /// Cells whose points a tool may reach soon, and how much motion, m, the list still stands for.
    cells: Vec<u32>,
    slack: f64,
    centre: V3,
}

/// Edges may have grown by this before a triangle could slip through between its vertices.
const STRETCH: f64 = 1.5;

impl NearTriangles {
    /// The list of cells is to be made anew: the region has changed.
    pub fn forget(&mut self) {
        self.slack = -1.0;
    }

    /// Finds the triangles within `reach` (m) of `centre`, after nodes have moved by at most `moved` (m) since last time.
    ///
    /// # Errors
    /// What the grid says.
    pub fn search(
        &mut self,
        (centre, reach, moved): (V3, f64, f64),
        lattice: &mut Lattice,
        nodes: &Nodes,
        model: &Model,
        skin: &mut Skin,
    ) -> Result<(), LatticeError> {
        let shift = axpy(centre, -1.0, self.centre);
        self.slack -= moved + dot(shift, shift).sqrt();
        self.centre = centre;
        let stale = self.slack < 0.0;
        if stale {
            self.slack = lattice.edge();
            self.list_cells(centre, reach + self.slack, lattice, nodes);
        }
        self.candidates.clear();
        let candidates = &mut self.candidates;
        skin.tree.near(centre, reach, |t| candidates.push(t));
        if stale || moved > 0.0 {
            self.cells.iter().try_for_each(|&cell| lattice.embed(cell, nodes, model, skin))?;
        }
        for &cell in &self.cells {
            for &v in lattice.points(cell)? {
                let d = axpy(skin.x[v as usize], -1.0, centre);
                if dot(d, d) <= (reach + STRETCH * model.longest_edge(v)).powi(2) {
                    candidates.extend_from_slice(model.around(v));
                }
            }
        }
        candidates.sort_unstable();
        candidates.dedup();
        self.found.clear();
        for &triangle in candidates.iter() {
            // A corner in a cell that was not listed is up to date all the same if it is settled; if not, embed it now.
            for v in model.surface.triangles[triangle as usize] {
                let cell = skin.cell[v as usize];
                if cell != crate::body::NOT_CARRIED && !self.cells.contains(&cell) {
                    lattice.embed(cell, nodes, model, skin)?;
                    self.cells.push(cell);
                }
            }
            let corners = skin.corners(model, triangle);
            let closest = closest_point(centre, corners);
            let d = axpy(closest.point, -1.0, centre);
            let distance = dot(d, d).sqrt();
            if distance <= reach {
                self.found.push(Near { body: 0, triangle, corners, closest, distance });
            }
        }
        Ok(())
    }

    fn list_cells(&mut self, centre: V3, reach: f64, lattice: &Lattice, nodes: &Nodes) {
        self.cells.clear();
        let region = lattice.region();
        for cell in 0..region.cell_id.len() {
            let [begin, end] = region.cell_points[cell];
            if begin == end || u32::from(region.cell_state[cell]) != abi::CELL_SURFACE {
                continue;
            }
            let reach = reach + STRETCH * lattice.longest_edge(cell as u32);
            let corners = lattice.corners(cell as u32, &nodes.x);
            let apart: f64 = (0..3)
                .map(|i| {
                    let low = corners.iter().fold(f64::INFINITY, |m, c| m.min(c[i]));
                    let high = corners.iter().fold(f64::NEG_INFINITY, |m, c| m.max(c[i]));
                    (low - centre[i]).max(centre[i] - high).max(0.0).powi(2)
                })
                .sum();
            if apart <= reach * reach {
                self.cells.push(cell as u32);
            }
        }
    }
}
