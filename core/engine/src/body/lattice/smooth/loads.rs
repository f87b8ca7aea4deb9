//! Loads on places of the surface, brought to nodes by the transpose of the embedding.

use super::hermite::Weights;
use super::{Jet, NO_JET, SmoothEmbedding};
use pliant_host::Region;
use pliant_solver::Vec3;

/// Loads on the values and derivatives of nodes.
#[derive(Default)]
pub(super) struct JetLoads {
    /// N, N m and so on in edges of a cell, by node; zero where none is.
    loads: Vec<Jet>,
    /// Nodes with loads.
    touched: Vec<u32>,
    is_touched: Vec<bool>,
    /// Weights of nodes at one place; zero where there is none.
    weights: Vec<f64>,
    /// Nodes with a weight.
    weighted: Vec<u32>,
}

impl SmoothEmbedding {
    /// Adds a force (N) at a place of a cell with these weights.
    pub(in super::super) fn add_load(&mut self, region: &Region, cell: usize, weights: &Weights, force: Vec3) {
        let JetLoads { loads, touched, is_touched, .. } = &mut self.loads;
        if loads.len() < self.adjacency.len() {
            loads.resize(self.adjacency.len(), NO_JET);
            is_touched.resize(self.adjacency.len(), false);
        }
        for (weights, &node) in weights.chunks_exact(8).zip(&region.cell_corners[cell]) {
            let n = node as usize;
            if !std::mem::replace(&mut is_touched[n], true) {
                touched.push(node);
            }
            for (loads, force) in loads[n].iter_mut().zip(&force) {
                loads.iter_mut().zip(weights).for_each(|(load, w)| *load += w * force);
            }
        }
    }

    /// Visits each node that has a weight `w` at a place of a cell with the share `|w| sum |w|` of a stiffness there: the smallest diagonal
    /// matrix of this form that is not softer than `w w^T` (its rows are diagonally dominant).
    pub(in super::super) fn visit_stiffness_shares(
        &mut self,
        region: &Region,
        cell: usize,
        weights: &Weights,
        mut visit: impl FnMut(u32, f64),
    ) {
        let JetLoads { weights: sums, weighted, .. } = &mut self.loads;
        sums.resize(sums.len().max(self.adjacency.len()), 0.0);
        for (weights, &corner) in weights.chunks_exact(8).zip(&region.cell_corners[cell]) {
            self.adjacency.visit(region, &self.fits, corner, |node, share, coefficients| {
                let sum = &mut sums[node as usize];
                if *sum == 0.0 {
                    weighted.push(node);
                }
                *sum += share * weights.iter().zip(coefficients).map(|(w, c)| w * c).sum::<f64>();
            });
        }
        // A node whose sum passed through zero is listed twice.
        weighted.sort_unstable();
        weighted.dedup();
        let total: f64 = weighted.iter().map(|node| sums[*node as usize].abs()).sum();
        for node in weighted.drain(..) {
            visit(node, std::mem::take(&mut sums[node as usize]).abs() * total);
        }
    }

    /// Gives what the loads come to on nodes, in order, and forgets them.
    pub(in super::super) fn pull_back(&mut self, region: &Region, mut visit: impl FnMut(u32, Vec3)) {
        self.loads.touched.sort_unstable();
        for node in self.loads.touched.drain(..) {
            let loads = std::mem::replace(&mut self.loads.loads[node as usize], NO_JET);
            self.loads.is_touched[node as usize] = false;
            self.adjacency.pull_back(region, &self.fits, node, &loads, &mut visit);
        }
    }
}
