//! The neighbours of each node of a region, through the cells that share it, and the jets fitted to them.

use super::fit::{Fit, Fits, position};
use super::{Jet, NO_JET};
use pliant_host::Region;
use pliant_solver::Vec3;

/// Cells of a region around each of its nodes.
#[derive(Default)]
pub(in super::super) struct Adjacency {
    /// Start of the cells of each node in `cells` (n + 1).
    start: Vec<u32>,
    /// Cells around nodes: eight times the cell, plus the corner that the node is of it.
    cells: Vec<u32>,
    /// Which of the eight cells around each node exist, as bits (n): bit k for the cell of which it is corner k. 0 for a node that has its own
    /// value and no slope.
    mask: Vec<u8>,
}

/// Marks one of the 27 positions around a node where no node is.
const NO_NODE: u32 = u32::MAX;

/// A further copy of a node at one of the 27 positions around a node.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct FurtherCopy {
    position: usize,
    node: u32,
}

impl Adjacency {
    /// Lists the cells of each node. A node on the border of the region has its own value and no slope: the surface beyond does not move, and
    /// so continues without a crease.
    pub fn list(&mut self, region: &Region, fits: &mut Fits) {
        let n = region.node_id.len();
        self.start.clear();
        self.start.resize(n + 1, 0);
        region.cell_corners.iter().flatten().for_each(|node| self.start[*node as usize + 1] += 1);
        (0..n).for_each(|i| self.start[i + 1] += self.start[i]);
        let mut next = self.start.clone();
        self.cells.clear();
        self.cells.resize(8 * region.cell_corners.len(), 0);
        self.mask.clear();
        self.mask.resize(n, 0);
        for (cell, corners) in region.cell_corners.iter().enumerate() {
            for (corner, &node) in corners.iter().enumerate() {
                let at = &mut next[node as usize];
                self.cells[*at as usize] = (8 * cell + corner) as u32;
                *at += 1;
                self.mask[node as usize] |= 1 << corner;
            }
        }
        for (mask, border) in self.mask.iter_mut().zip(&region.node_border) {
            *mask = if *border == 0 { *mask } else { 0 };
            if *mask != 0 {
                fits.prepare(*mask);
            }
        }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.mask.len()
    }

    /// The jet at a node of the field that has the value `of(node)` (m) at each node.
    pub fn jet(&self, region: &Region, fits: &Fits, node: u32, of: impl Fn(u32) -> Vec3) -> Jet {
        let mut jet = NO_JET;
        self.visit(region, fits, node, |other, share, coefficients| {
            let value = share * of(other);
            for (sums, value) in jet.iter_mut().zip(&value) {
                for (sum, c) in sums.iter_mut().zip(coefficients) {
                    *sum += value * c;
                }
            }
        });
        jet
    }

    /// The transpose of [`Adjacency::jet`]: distributes `loads` on the value and the derivatives of a node (N, in edges of a cell) among nodes
    /// by `visit(node, force)`.
    pub fn pull_back(&self, region: &Region, fits: &Fits, node: u32, loads: &Jet, mut visit: impl FnMut(u32, Vec3)) {
        self.visit(region, fits, node, |other, share, coefficients| {
            let force = loads.map(|loads| loads.iter().zip(coefficients).map(|(load, c)| load * c).sum::<f64>());
            visit(other, share * Vec3::from(force));
        });
    }

    /// Calls `visit(node, share, coefficients)` for each node that contributes to the jet of `node`: the jet is the sum of share times
    /// coefficients times the node's value. At the end of a cut several copies of a node can be at one position; they share its coefficients.
    pub fn visit(&self, region: &Region, fits: &Fits, node: u32, mut visit: impl FnMut(u32, f64, &[f64; 8])) {
        let n = node as usize;
        if self.mask[n] == 0 {
            return visit(node, 1.0, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        }
        let fit: &Fit = fits.get(self.mask[n]);
        let cells = &self.cells[self.start[n] as usize..self.start[n + 1] as usize];
        let mut nodes = [NO_NODE; 27];
        // Eight cells with eight corners at most; an array, as a step must not allocate.
        let mut found = [FurtherCopy { position: 0, node: NO_NODE }; 64];
        let mut count = 0;
        for &at in cells {
            let (cell, corner) = (at as usize >> 3, at as usize & 7);
            for (other, &node) in region.cell_corners[cell].iter().enumerate() {
                let position = position(corner, other);
                let copy = FurtherCopy { position, node };
                if nodes[position] == NO_NODE {
                    nodes[position] = node;
                } else if nodes[position] != node && !found[..count].contains(&copy) {
                    found[count] = copy;
                    count += 1;
                }
            }
        }
        let copies = &mut found[..count];
        copies.sort_unstable();
        let copies = &*copies;
        for (position, &first) in nodes.iter().enumerate().filter(|(_, node)| **node != NO_NODE) {
            let others = || copies.iter().filter(|copy| copy.position == position).map(|copy| copy.node);
            let share = if copies.is_empty() { 1.0 } else { 1.0 / (1 + others().count()) as f64 };
            visit(first, share, &fit[position]);
            others().for_each(|other| visit(other, share, &fit[position]));
        }
    }
}
