//! The nodes around each node of a region, by the cells that share it.

use super::fit::{Fit, Fits, place};
use super::{Jet, NO_JET};
use pliant_host::Region;
use pliant_solver::Vec3;

/// Cells of a region around each of its nodes.
#[derive(Default)]
pub(in super::super) struct Adjacency {
    /// Where the cells of each node start (n + 1).
    start: Vec<u32>,
    /// Eight times the cell, and which of its corners the node is.
    cells: Vec<u32>,
    /// Which of the eight cells around each node there are (n): bit k for the one of which it is corner k. 0 where the node's own value is
    /// all there is to it.
    which: Vec<u8>,
}

/// The nodes at one of the 27 places around a node.
const NO_NODE: u32 = u32::MAX;

impl Adjacency {
    /// Lists the cells of each node. A node on the border of a region, beyond which nothing moves, has its own value and no slope: the
    /// surface then meets what does not move without a crease.
    pub fn list(&mut self, region: &Region, fits: &mut Fits) {
        let n = region.node_id.len();
        self.start.clear();
        self.start.resize(n + 1, 0);
        region.cell_corners.iter().flatten().for_each(|node| self.start[*node as usize + 1] += 1);
        (0..n).for_each(|i| self.start[i + 1] += self.start[i]);
        let mut next = self.start.clone();
        self.cells.clear();
        self.cells.resize(8 * region.cell_corners.len(), 0);
        self.which.clear();
        self.which.resize(n, 0);
        for (cell, corners) in region.cell_corners.iter().enumerate() {
            for (corner, &node) in corners.iter().enumerate() {
                let at = &mut next[node as usize];
                self.cells[*at as usize] = (8 * cell + corner) as u32;
                *at += 1;
                self.which[node as usize] |= 1 << corner;
            }
        }
        for (which, border) in self.which.iter_mut().zip(&region.node_border) {
            *which = if *border == 0 { *which } else { 0 };
            if *which != 0 {
                fits.prepare(*which);
            }
        }
    }

    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.which.len()
    }

    /// The jet of a node in the field that has the value `of(node)` (m) at each.
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

    /// The transpose of [`Adjacency::jet`]: what `loads` (N) on the value and the derivatives of a node come to on nodes.
    pub fn pull_back(&self, region: &Region, fits: &Fits, node: u32, loads: &Jet, mut visit: impl FnMut(u32, Vec3)) {
        self.visit(region, fits, node, |other, share, coefficients| {
            let force = loads.map(|loads| loads.iter().zip(coefficients).map(|(load, c)| load * c).sum::<f64>());
            visit(other, share * Vec3::from(force));
        });
    }

    /// Nodes that take part in the jet of a node, each with its share of its place and the coefficients of the fit there. Before the end of
    /// a cut several copies of a node can be at one place: they count as their mean.
    pub fn visit(&self, region: &Region, fits: &Fits, node: u32, mut visit: impl FnMut(u32, f64, &[f64; 8])) {
        let n = node as usize;
        if self.which[n] == 0 {
            return visit(node, 1.0, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        }
        let fit: &Fit = fits.get(self.which[n]);
        let cells = &self.cells[self.start[n] as usize..self.start[n + 1] as usize];
        let mut nodes = [NO_NODE; 27];
        // Each cell names eight corners; on the stack, for this runs in every step.
        let mut found = [(0, NO_NODE); 64];
        let mut count = 0;
        for &at in cells {
            let (cell, corner) = (at as usize >> 3, at as usize & 7);
            for (other, &there) in region.cell_corners[cell].iter().enumerate() {
                let place = place(corner, other);
                if nodes[place] == NO_NODE {
                    nodes[place] = there;
                } else if nodes[place] != there && !found[..count].contains(&(place, there)) {
                    found[count] = (place, there);
                    count += 1;
                }
            }
        }
        let copies = &mut found[..count];
        copies.sort_unstable();
        let copies = &*copies;
        for (place, &there) in nodes.iter().enumerate().filter(|(_, there)| **there != NO_NODE) {
            let others = || copies.iter().filter(|(at, _)| *at == place).map(|(_, other)| *other);
            let share = if copies.is_empty() { 1.0 } else { 1.0 / (1 + others().count()) as f64 };
            visit(there, share, &fit[place]);
            others().for_each(|other| visit(other, share, &fit[place]));
        }
    }
}
