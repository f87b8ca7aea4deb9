//! Classification of cells: empty, surface or inside.
//!
//! Surface cells are those a triangle touches. The others are classified by the winding number of the surface around their centres. Two
//! simpler rules fail: a flood fill from outside leaks in through the smallest hole, and the parity of crossings takes the overlap of
//! two closed parts for empty.

use crate::crossings::mark_inside;
use crate::lattice::Lattice;
use crate::overlap::for_each_touched_cell;
use crate::scaled_surface::ScaledSurface;
use pliant_plugin_api::abi;

pub(crate) const EMPTY: u8 = abi::CELL_EMPTY as u8;
pub(crate) const SURFACE: u8 = abi::CELL_SURFACE as u8;
pub(crate) const INSIDE: u8 = abi::CELL_INSIDE as u8;

/// The state of every cell of the finest level, at `i + m (j + m k)` for `m` cells per axis.
pub(crate) fn classify(surface: &ScaledSurface<'_>, lattice: &Lattice) -> Vec<u8> {
    let m = lattice.cells as usize;
    let mut states = vec![EMPTY; m * m * m];
    for triangle in surface.triangles {
        let corners = triangle.map(|point| surface.points[point as usize]);
        for_each_touched_cell(&corners, lattice.cells, |[i, j, k]| states[i + m * (j + m * k)] = SURFACE);
    }
    mark_inside(&mut states, surface, lattice.cells);
    states
}

/// The states of the next coarser level, with `cells` per axis: inside or empty where all eight children are, else surface. So a
/// parent with a child that is not empty is not empty either. Across a hole, inside and empty children meet without a triangle; their
/// parent is surface.
pub(crate) fn coarsen(children: &[u8], cells: u32) -> Vec<u8> {
    let (m, n) = (cells as usize, 2 * cells as usize);
    let mut states = Vec::with_capacity(m * m * m);
    for first in (0..m * m).map(|row| 2 * n * (row % m + n * (row / m))) {
        let rows = [first, first + n, first + n * n, first + n * n + n].map(|row| &children[row..row + n]);
        states.extend((0..m).map(|i| {
            let first = rows[0][2 * i];
            let same = rows.iter().all(|row| row[2 * i] == first && row[2 * i + 1] == first);
            if same { first } else { SURFACE }
        }));
    }
    states
}
