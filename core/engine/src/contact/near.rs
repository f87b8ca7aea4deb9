//! What of a surface a tool may touch.
//!
//! A ball that is large against the cells of the grid meets samples; a smaller tool meets triangles, of which it can reach
//! few. Both are looked up through the cells that carry them: a point lies in the hull of its cell's eight corners, so a
//! cell whose box is out of reach holds none that is within. What is settled and not carried is found in the tree.

use crate::body::Samples;
use crate::body::{Body, LatticeError, NOT_CARRIED, weigh};
use nalgebra::Matrix3;
use pliant_mesh::geometry::closest_point;
use pliant_plugin_api::abi;
use pliant_solver::Vec3;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// Of which body.
    pub body: u32,
    /// m, where it is
    pub point: Vec3,
    /// m, where it was in the model as it was handed in
    pub rest: Vec3,
    /// Normal there, in the rest shape; of no particular length
    pub normal: Vec3,
    /// m, from the centre of the search
    pub distance: f64,
    /// m^2, of a sample; 0 of a triangle
    pub area: f64,
}

/// The search in one body, with its buffers.
#[derive(Default)]
pub struct NearSurface {
    candidates: Vec<u32>,
    /// Cells a tool may reach soon, and how much motion, m, the list still stands for.
    cells: Vec<u32>,
    slack: f64,
    centre: Vec3,
    /// +1 if the tool is on the side the normals point to, -1 on the other, 0 while it touches nothing
    side: f64,
    /// Weights of the samples of each listed cell, and where they start.
    weights: Vec<[f64; 8]>,
    weights_of: Vec<usize>,
    carried: Vec<Vec3>,
}

/// Edges may have grown by this before a triangle could slip through between its vertices.
const STRETCH: f64 = 1.5;

impl NearSurface {
    /// The cells of the body have changed.
    pub fn forget(&mut self) {
        self.slack = -1.0;
    }

    /// The tool touches nothing, and may come to any side of the surface.
    pub fn leave(&mut self) {
        self.side = 0.0;
    }

    /// Lists the cells within `reach` of `centre`, unless the last list still stands after nodes have moved by at most
    /// `moved` since (all in m). Gives whether it is a new list.
    fn list_cells(&mut self, (centre, reach, moved): (Vec3, f64, f64), body: &Body, edges: bool) -> bool {
        let shift = centre - self.centre;
        self.slack -= moved + shift.norm();
        self.centre = centre;
        if self.slack >= 0.0 {
            return false;
        }
        let Some(lattice) = body.carrier.lattice() else { return false };
        self.slack = lattice.edge();
        self.cells.clear();
        let region = lattice.region();
        for cell in 0..region.cell_id.len() as u32 {
            if u32::from(region.cell_state[cell as usize]) != abi::CELL_SURFACE {
                continue;
            }
            let longest = if edges { STRETCH * lattice.longest_edge(cell) } else { 0.0 };
            let reach = reach + self.slack + longest;
            let corners = lattice.corners(cell, &body.system.nodes.x);
            let apart: f64 = (0..3)
                .map(|i| {
                    let low = corners.iter().fold(f64::INFINITY, |m, c| m.min(c[i]));
                    let high = corners.iter().fold(f64::NEG_INFINITY, |m, c| m.max(c[i]));
                    (low - centre[i]).max(centre[i] - high).max(0.0).powi(2)
                })
                .sum();
            if apart <= reach * reach {
                self.cells.push(cell);
            }
        }
        true
    }

    /// Adds the samples within `reach` of `centre` that face it.
    ///
    /// # Errors
    /// What the grid says.
    pub fn samples(
        &mut self,
        (index, body, samples): (u32, &mut Body, &Samples),
        (centre, reach, moved): (Vec3, f64, f64),
        out: &mut Vec<Near>,
    ) -> Result<(), LatticeError> {
        if self.list_cells((centre, reach, moved), body, false) {
            self.weigh(body, samples)?;
        }
        let Some(lattice) = body.carrier.lattice() else { return Ok(()) };
        let first = out.len();
        let mut closest = (f64::INFINITY, 0.0);
        let side = self.side;
        for (&cell, &begin) in self.cells.iter().zip(&self.weights_of) {
            let range = lattice.samples_of(samples, cell);
            if range.is_empty() {
                continue;
            }
            let moved = lattice.displacements(cell, &body.system.nodes);
            let turn = normal_turn(&moved, lattice.edge());
            let weights = &self.weights[begin..begin + range.len()];
            lattice.carry(cell, &samples.place[range.clone()], weights, &body.system.nodes, &mut self.carried)?;
            for (i, s) in range.enumerate() {
                let point = self.carried[i];
                let d = centre - point;
                let distance = d.norm();
                if distance > reach {
                    continue;
                }
                let facing = (turn * samples.normal[s]).dot(&d);
                if distance < closest.0 {
                    closest = (distance, facing.signum());
                }
                let area = if facing >= 0.0 { samples.area[s] } else { -samples.area[s] };
                let (rest, normal) = (samples.place[s], samples.normal[s]);
                out.push(Near { body: index, point, rest, normal, distance, area });
            }
        }
        self.side = if side == 0.0 { closest.1 } else { side };
        let side = self.side;
        let mut kept = first;
        for i in first..out.len() {
            if out[i].area * side > 0.0 {
                out[kept] = Near { area: out[i].area.abs(), ..out[i] };
                kept += 1;
            }
        }
        out.truncate(kept);
        Ok(())
    }

    fn weigh(&mut self, body: &mut Body, samples: &Samples) -> Result<(), LatticeError> {
        self.weights.clear();
        self.weights_of.clear();
        let Some(lattice) = body.carrier.lattice_mut() else { return Ok(()) };
        for &cell in &self.cells {
            let range = lattice.samples_of(samples, cell);
            let begin = self.weights.len();
            self.weights_of.push(begin);
            self.weights.resize(begin + range.len(), [0.0; 8]);
            lattice.weights_in(&samples.place[range], &mut self.weights[begin..])?;
        }
        Ok(())
    }

    /// Adds the closest points of the triangles within `reach` of `centre`.
    ///
    /// # Errors
    /// What the grid says.
    pub fn triangles(
        &mut self,
        (index, body): (u32, &mut Body),
        (centre, reach, moved): (Vec3, f64, f64),
        out: &mut Vec<Near>,
    ) -> Result<(), LatticeError> {
        let fresh = self.list_cells((centre, reach, moved), body, true);
        let Body { carrier, model, skin, system, .. } = body;
        let Some(lattice) = carrier.lattice_mut() else { return Ok(()) };
        if fresh || moved > 0.0 {
            self.cells.iter().try_for_each(|&cell| lattice.embed(cell, &system.nodes, model, skin))?;
        }
        self.candidates.clear();
        let candidates = &mut self.candidates;
        skin.tree.near(centre, reach, |t| candidates.push(t));
        for &cell in &self.cells {
            for &v in lattice.points(cell)? {
                let d = skin.x[v as usize] - centre;
                if d.norm_squared() <= (reach + STRETCH * model.longest_edge(v)).powi(2) {
                    candidates.extend_from_slice(model.around(v));
                }
            }
        }
        candidates.sort_unstable();
        candidates.dedup();
        for &triangle in candidates.iter() {
            let vertices = model.surface.triangles[triangle as usize];
            for v in vertices {
                let cell = skin.cell[v as usize];
                if cell != NOT_CARRIED && !self.cells.contains(&cell) {
                    lattice.embed(cell, &system.nodes, model, skin)?;
                    self.cells.push(cell);
                }
            }
            let found = closest_point(centre, skin.corners(model, triangle));
            let d = found.point - centre;
            let distance = d.norm();
            if distance <= reach {
                let corners = vertices.map(|v| model.surface.points[v as usize]);
                let (rest, normal) = (weigh(corners, found.bary), normal_of(corners));
                let rest = if lattice.has_cuts() { inward(rest, normal, lattice.edge()) } else { rest };
                out.push(Near { body: index, point: found.point, rest, normal, distance, area: 0.0 });
            }
        }
        Ok(())
    }
}

/// A place of the surface, moved in just far enough to tell on which side of a cut it is.
fn inward(rest: Vec3, normal: Vec3, edge: f64) -> Vec3 {
    let length = normal.norm();
    if length > 0.0 { rest - 1e-6 * edge / length * normal } else { rest }
}

/// Normal of a triangle, as long as twice its area.
pub fn normal_of(corners: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = corners;
    (b - a).cross(&(c - a))
}

/// How normals of the rest shape are turned in a cell with these displacements of its corners: the cofactors of its mean
/// deformation gradient.
fn normal_turn(moved: &[Vec3; 8], edge: f64) -> Matrix3<f64> {
    let mut f = Matrix3::identity();
    for (corner, u) in moved.iter().enumerate() {
        for axis in 0..3 {
            let sign = if corner >> axis & 1 == 1 { 0.25 } else { -0.25 };
            for i in 0..3 {
                f[(i, axis)] += sign * u[i] / edge;
            }
        }
    }
    let column = |i: usize| f.column(i).into_owned();
    let [a, b, c] = [column(0), column(1), column(2)];
    Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}
