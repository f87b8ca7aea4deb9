//! What each cell is: empty, surface or inside.
//!
//! Surface cells are those a triangle touches; the rest is decided at its centre, by how often the surface winds around
//! it. A flood fill from outside was rejected: it runs in through the smallest hole. Parity was rejected: it makes a
//! void of the overlap of two closed parts.

use crate::crossings::fill;
use crate::lattice::Lattice;
use crate::overlap::touched;
use crate::shape::Shape;
use pliant_plugin_api::abi;

pub(crate) const EMPTY: u8 = abi::CELL_EMPTY as u8;
pub(crate) const SURFACE: u8 = abi::CELL_SURFACE as u8;
pub(crate) const INSIDE: u8 = abi::CELL_INSIDE as u8;

/// The state of every cell of the finest level, by id.
pub(crate) fn finest(shape: &Shape<'_>, lattice: &Lattice) -> Vec<u8> {
    let m = lattice.cells as usize;
    let mut states = vec![EMPTY; m * m * m];
    for triangle in shape.triangles {
        let corners = triangle.map(|point| shape.corners[point as usize]);
        touched(&corners, lattice.cells, |[i, j, k]| states[i + m * (j + m * k)] = SURFACE);
    }
    fill(&mut states, shape, lattice.cells);
    states
}

/// The states one level up, of `cells` per axis: inside where all eight children are, empty where all are, else
/// surface. So a parent is occupied if a child is, and the lid that winding draws over a hole, where inside and empty
/// children meet without a triangle, counts as surface.
pub(crate) fn coarser(children: &[u8], cells: u32) -> Vec<u8> {
    let (m, n) = (cells as usize, 2 * cells as usize);
    let mut states = Vec::with_capacity(m * m * m);
    for at in (0..m * m).map(|row| 2 * n * (row % m + n * (row / m))) {
        let rows = [at, at + n, at + n * n, at + n * n + n].map(|row| &children[row..row + n]);
        states.extend((0..m).map(|i| {
            let first = rows[0][2 * i];
            let same = rows.iter().all(|row| row[2 * i] == first && row[2 * i + 1] == first);
            if same { first } else { SURFACE }
        }));
    }
    states
}
