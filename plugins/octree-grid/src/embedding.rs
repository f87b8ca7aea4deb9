//! Embedding of the surface in the cells: how it follows their corners.
//!
//! Trilinear weights are continuous across shared faces and exact for every affine motion. The rule of the paper lays the lengths of the
//! three edges at the base corner along the world axes. It is neither continuous nor exact (the centre of a cell rotated by 30 degrees
//! is off by 0.37 of the edge) and is there to reproduce the paper. Everything here is *real time*.

use crate::cells::Cells;
use crate::states::EMPTY;
use pliant_plugin_api::Fault;
use pliant_plugin_api::lanes::Vec3;

/// Distance from a cell's centre, in edges along each axis, up to which the cell embeds a point.
const REACH: f64 = 0.6;

/// The embedding rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Embedding {
    /// Trilinear interpolation between the corners of the cell.
    Trilinear,
    /// The paper's rule.
    PaperRatio,
}

/// A rest position as a cell and coordinates in it.
#[derive(Clone, Copy)]
pub(crate) struct EmbeddedPoint {
    /// Indices of the cell.
    pub(crate) cell: [u32; 3],
    /// Coordinates in the cell, each in [0, 1]; up to 0.1 outside where the cube around the point is empty or off the grid.
    pub(crate) local: Vec3,
}

impl EmbeddedPoint {
    /// Embeds a rest position, m, in the cell around it, or else in the nearest occupied cell within reach.
    ///
    /// # Errors
    /// A position that is not finite, or outside the reach of all cells.
    pub(crate) fn new(cells: &Cells, position: [f64; 3]) -> Result<Self, Fault> {
        let too_far = Fault::bad_argument("a rest position is more than a tenth of a cell outside the body");
        Self::find(cells, position)?.ok_or(too_far)
    }

    /// [`EmbeddedPoint::new`], with `None` for a position outside the reach of all cells. Of equally near cells the first is taken.
    pub(crate) fn find(cells: &Cells, position: [f64; 3]) -> Result<Option<Self>, Fault> {
        if !position.iter().all(|x| x.is_finite()) {
            return Err(Fault::bad_argument("a rest position is not finite"));
        }
        let lattice = &cells.lattice;
        let scaled = lattice.in_cells(position);
        let base = lattice.cell_of(scaled);
        let in_cell = |cell: [u32; 3]| Self { cell, local: Vec3(scaled) - Vec3(cell.map(f64::from)) };
        if cells.state(base) != EMPTY && in_cell(base).distance_squared() == 0.0 {
            return Ok(Some(in_cell(base)));
        }
        let near = |axis: usize| base[axis].saturating_sub(1)..(base[axis] + 2).min(lattice.cells);
        let neighbours =
            near(2).flat_map(|k| near(1).flat_map(move |j| cells.row(j, k, near(0)).map(move |(i, _)| [i, j, k])));
        let within_reach = |point: &Self| point.local.0.iter().all(|p| (p - 0.5).abs() <= REACH);
        let candidates = neighbours.map(in_cell).filter(within_reach);
        Ok(candidates.min_by(|a, b| a.distance_squared().total_cmp(&b.distance_squared())))
    }

    /// Trilinear weights of the corners; corner i at bits (x, y, z) = (i & 1, i >> 1 & 1, i >> 2).
    pub(crate) fn weights(&self) -> [f64; 8] {
        let along = |axis: usize, far: usize| if far == 1 { self.local[axis] } else { 1.0 - self.local[axis] };
        [0, 1, 2, 3, 4, 5, 6, 7].map(|c: usize| along(0, c & 1) * along(1, c >> 1 & 1) * along(2, c >> 2))
    }

    /// The paper's position from the current corners, m: `v = P R + b`.
    pub(crate) fn ratio_position(&self, corners: &[Vec3; 8]) -> Vec3 {
        let lengths = [0, 1, 2].map(|axis| (corners[1 << axis] - corners[0]).norm());
        Vec3([0, 1, 2].map(|axis| corners[0][axis] + self.local[axis] * lengths[axis]))
    }

    /// Adds the transpose of the derivative of [`EmbeddedPoint::ratio_position`] times `load` to the loads on the corners, N. An edge
    /// without length has no direction and transmits nothing.
    pub(crate) fn add_ratio_loads(&self, corners: &[Vec3; 8], load: Vec3, corner_loads: &mut [[f64; 3]; 8]) {
        let mut add = |corner: usize, load: Vec3| corner_loads[corner] = (Vec3(corner_loads[corner]) + load).0;
        add(0, load);
        for axis in 0..3 {
            let edge = corners[1 << axis] - corners[0];
            let length = edge.norm();
            if length > 0.0 {
                let share = edge * (self.local[axis] * load[axis] / length);
                add(1 << axis, share);
                add(0, -share);
            }
        }
    }

    /// Squared distance of the point from the cell, in edges.
    fn distance_squared(&self) -> f64 {
        self.local.0.iter().map(|p| (p - p.clamp(0.0, 1.0)).powi(2)).sum()
    }
}
