//! The links of a region and their boundary weights.
//!
//! The weight of a link is the share of the cells around it that belong to the region: 1/2 on a face of the body, 1/4 on an edge. With full
//! weights there, a block of eight cells is 18 % too stiff. The cells that share a link are read from the byte of its lower node that
//! marks the region's cells around that node, so one rule serves all families.

use crate::lattice::steps;
use crate::region::{BORDER, Nodes};
use pliant_plugin_api::RegionSink;
use pliant_plugin_api::abi::{BODY_DIAGONAL, FLEXION, SHEAR, STRUCTURAL};

/// A family of links.
#[derive(Clone, Copy)]
struct Family {
    bit: u32,
    /// Axes a link runs along at once: 1 along an edge, 2 along a face diagonal, 3 along a body diagonal.
    axes: usize,
    /// Cells a link runs along.
    cells: isize,
}

const FAMILIES: [Family; 4] = [
    Family { bit: STRUCTURAL, axes: 1, cells: 1 },
    Family { bit: SHEAR, axes: 2, cells: 1 },
    Family { bit: FLEXION, axes: 1, cells: 2 },
    Family { bit: BODY_DIAGONAL, axes: 3, cells: 1 },
];
/// The bits of all families.
pub(crate) const ALL_FAMILIES: u32 = STRUCTURAL | SHEAR | FLEXION | BODY_DIAGONAL;

/// Rows of lower nodes in a strip. Links are listed strip by strip, so that the nodes of a strip are still in the cache when the next
/// direction reads them.
const STRIP_ROWS: usize = 2;

/// Lists the links of `families`: by strips of the lower node, within a strip by direction, within a direction by ascending lower node.
/// Along a row, both nodes of consecutive links are then consecutive. Links between two border nodes are left out, as both are fixed.
pub(crate) fn list_links(nodes: &Nodes, families: u32, out: &mut RegionSink<'_>) {
    let [_, row, layer] = nodes.strides;
    let strip = |node: u32| (node as usize / layer, node as usize % layer / (STRIP_ROWS * row));
    for strip in nodes.list.chunk_by(|&a, &b| strip(a) == strip(b)) {
        let requested = FAMILIES.into_iter().filter(|family| families & family.bit != 0);
        for (family, step) in requested.flat_map(|family| steps(family.axes).map(move |step| (family, step))) {
            let sharing = sharing_cells(step);
            let share = 1.0 / f64::from(sharing.count_ones());
            let next: isize = (0..3).map(|axis| step[axis] as isize * nodes.strides[axis] as isize).sum();
            for &node in strip {
                let node = node as usize;
                let other = node.wrapping_add_signed(next * family.cells);
                let mut cells = nodes.around[node] & sharing;
                if family.cells == 2 {
                    cells &= nodes.around[node.wrapping_add_signed(next)];
                }
                if cells != 0 && nodes.around[node] & nodes.around[other] & BORDER == 0 {
                    let ends = [nodes.index[node], nodes.index[other]];
                    out.link(ends, family.bit, share * f64::from(cells.count_ones()));
                }
            }
        }
    }
}

/// The cells around a node that share a link along `step` from it, as bits of [`Nodes::around`].
fn sharing_cells(step: [i32; 3]) -> u16 {
    let shares = |q: usize| (0..3).all(|axis| step[axis] == 0 || (step[axis] > 0) == (q >> axis & 1 == 1));
    (0..8).filter(|&q| shares(q)).fold(0, |bits, q| bits | 1 << q)
}
