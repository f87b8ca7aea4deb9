//! How the surface follows the corners of its cells.
//!
//! Trilinear weights are continuous over shared faces and exact for every affine motion. The rule of the paper, lengths
//! of the three edges at the base corner laid along the world axes, is neither (a cell turned by 30 degrees is off by
//! 0.37 of its edge at the centre); it is kept to reproduce the paper. Everything here is *real time*.

use crate::cells::Cells;
use crate::states::EMPTY;
use crate::vector::{Vector, add, norm, scale, sub};
use pliant_plugin_api::Fault;

/// How far from its centre, in edges along each axis, a cell still carries a place.
const REACH: f64 = 0.6;

/// Which rule places the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Embedding {
    Trilinear,
    PaperRatio,
}

/// A place in the cell that carries it.
#[derive(Clone, Copy)]
pub(crate) struct Seat {
    pub(crate) cell: [u32; 3],
    /// Each within [0, 1], or 0.1 beyond where its own cube is empty or off the grid.
    pub(crate) local: Vector,
}

impl Seat {
    /// Of a rest place, m: its own cell, or else the nearest occupied one that reaches it, of these the first.
    ///
    /// # Errors
    /// A place that is not finite or that no cell reaches.
    pub(crate) fn of(cells: &Cells, place: Vector) -> Result<Self, Fault> {
        let far = Fault::bad_argument("a rest place is more than a tenth of a cell outside of the body");
        Self::find(cells, place)?.ok_or(far)
    }

    /// [`Seat::of`], or `None` where no cell reaches.
    pub(crate) fn find(cells: &Cells, place: Vector) -> Result<Option<Self>, Fault> {
        if !place.iter().all(|x| x.is_finite()) {
            return Err(Fault::bad_argument("a rest place is not finite"));
        }
        let lattice = &cells.lattice;
        let place = lattice.in_cells(place);
        let base = lattice.cell_of(place);
        let seat = |cell: [u32; 3]| Self { cell, local: sub(place, cell.map(f64::from)) };
        if cells.state(base) != EMPTY && seat(base).beyond() == 0.0 {
            return Ok(Some(seat(base)));
        }
        let near = |axis: usize| base[axis].saturating_sub(1)..(base[axis] + 2).min(lattice.cells);
        let neighbours =
            near(2).flat_map(|k| near(1).flat_map(move |j| cells.row(j, k, near(0)).map(move |(i, _)| [i, j, k])));
        let reaching = neighbours.map(seat).filter(|seat| seat.local.iter().all(|p| (p - 0.5).abs() <= REACH));
        Ok(reaching.min_by(|a, b| a.beyond().total_cmp(&b.beyond())))
    }

    /// Of each corner; corner i at bits (x, y, z) = (i & 1, i >> 1 & 1, i >> 2).
    pub(crate) fn weights(&self) -> [f64; 8] {
        let along = |axis: usize, far: usize| if far == 1 { self.local[axis] } else { 1.0 - self.local[axis] };
        [0, 1, 2, 3, 4, 5, 6, 7].map(|c: usize| along(0, c & 1) * along(1, c >> 1 & 1) * along(2, c >> 2))
    }

    /// The paper's place, m: `v = P R + b` from the current corners.
    pub(crate) fn ratio(&self, corners: &[Vector; 8]) -> Vector {
        [0, 1, 2].map(|axis| corners[0][axis] + self.local[axis] * norm(sub(corners[1 << axis], corners[0])))
    }

    /// Adds the transpose of the derivative of [`Seat::ratio`] times `load`, N. An edge of no length has no direction
    /// and passes nothing on.
    pub(crate) fn ratio_transposed(&self, corners: &[Vector; 8], load: Vector, corner_loads: &mut [Vector; 8]) {
        corner_loads[0] = add(corner_loads[0], load);
        for axis in 0..3 {
            let edge = sub(corners[1 << axis], corners[0]);
            let length = norm(edge);
            if length > 0.0 {
                let share = scale(self.local[axis] * load[axis] / length, edge);
                corner_loads[1 << axis] = add(corner_loads[1 << axis], share);
                corner_loads[0] = sub(corner_loads[0], share);
            }
        }
    }

    /// Squared distance from the cell, in edges.
    fn beyond(&self) -> f64 {
        self.local.iter().map(|p| (p - p.clamp(0.0, 1.0)).powi(2)).sum()
    }
}
