//! The springs of a local lattice, and how much of each the cells around it carry.
//!
//! A link is assembled from the cells that share it, so that one on a face of the body is half as stiff and one on an
//! edge a quarter; full weights there make a block of eight cells 18 % too stiff. Which cells share a link is read from
//! one byte at its lower node: the region's cells around that node. So one rule serves all families.

use crate::lattice::steps;
use crate::region::{BORDER, Nodes};
use pliant_plugin_api::RegionSink;
use pliant_plugin_api::abi::{BODY_DIAGONAL, FLEXION, SHEAR, STRUCTURAL};

/// Every family there is, the axes its links run along, and how many cells far.
const FAMILIES: [(u32, usize, i32); 4] = [(STRUCTURAL, 1, 1), (SHEAR, 2, 1), (FLEXION, 1, 2), (BODY_DIAGONAL, 3, 1)];
/// Bits of every family.
pub(crate) const ALL_FAMILIES: u32 = STRUCTURAL | SHEAR | FLEXION | BODY_DIAGONAL;

/// Rows of lower nodes whose links come one direction after the other: what these and their neighbours have is still near
/// when the next direction asks for it.
const ROWS: usize = 2;

/// Pushes the links of `families`: strip by strip of the lower node, in a strip direction by direction, in a direction
/// by rising lower node, so that along a row both ends of consecutive links are consecutive. Links between two border
/// nodes, which are held, are left out.
pub(crate) fn links(nodes: &Nodes, families: u32, out: &mut RegionSink<'_>) {
    let [_, row, layer] = nodes.strides;
    let strip = |node: u32| (node as usize / layer, node as usize % layer / (ROWS * row));
    for strip in nodes.list.chunk_by(|&a, &b| strip(a) == strip(b)) {
        let wanted = FAMILIES.into_iter().filter(|(family, ..)| families & family != 0);
        for (family, step, far) in
            wanted.flat_map(|(family, axes, far)| steps(axes).map(move |step| (family, step, far)))
        {
            let along = sharing(step);
            let share = 1.0 / f64::from(along.count_ones());
            let next: isize = (0..3).map(|axis| step[axis] as isize * nodes.strides[axis] as isize).sum();
            for &node in strip {
                let node = node as usize;
                let other = node.wrapping_add_signed(next * far as isize);
                let mut cells = nodes.around[node] & along;
                if far == 2 {
                    cells &= nodes.around[node.wrapping_add_signed(next)];
                }
                if cells != 0 && nodes.around[node] & nodes.around[other] & BORDER == 0 {
                    let places = [nodes.place[node], nodes.place[other]];
                    out.link(places, family, share * f64::from(cells.count_ones()));
                }
            }
        }
    }
}

/// The cells around a node that a step from it runs through or along, as bits like those of [`Nodes::around`].
fn sharing(step: [i32; 3]) -> u16 {
    let holds = |q: usize| (0..3).all(|axis| step[axis] == 0 || (step[axis] > 0) == (q >> axis & 1 == 1));
    (0..8).filter(|&q| holds(q)).fold(0, |bits, q| bits | 1 << q)
}
