//! Forces on points of the surface, distributed among nodes by the transpose of the smooth embedding.

use super::hermite::Weights;
use super::{Jet, NO_JET, SmoothEmbedding};
use pliant_host::Region;
use pliant_solver::Vec3;

/// Loads on the values and derivatives of nodes, and buffers.
#[derive(Default)]
pub(super) struct JetLoads {
    /// Loads on the jet of each node (n): N for the value and, with lengths in edges of a cell, for the derivatives.
    loads: Vec<Jet>,
    /// Nodes with loads.
    touched: Vec<u32>,
    is_touched: Vec<bool>,
    /// Weights of nodes at one point (n); zero between calls.
    weights: Vec<f64>,
    /// Nodes with a weight.
    weighted: Vec<u32>,
}

impl SmoothEmbedding {
    /// Adds a force (N) at the point of a cell with these weights.
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

    /// Calls `visit(node, |w| sum |w|)` for each node with weight `w` at the point of a cell with these weights: its share of a stiffness there
    /// in a diagonal matrix `D` with `D - w w^T` positive semidefinite, as that difference is diagonally dominant.
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
        // A node whose sum was zero on the way is listed twice.
        weighted.sort_unstable();
        weighted.dedup();
        let total: f64 = weighted.iter().map(|node| sums[*node as usize].abs()).sum();
        for node in weighted.drain(..) {
            visit(node, std::mem::take(&mut sums[node as usize]).abs() * total);
        }
    }

    /// Distributes the loads among nodes by `visit(node, force)`, in the order of the loaded nodes, and clears them.
    pub(in super::super) fn pull_back(&mut self, region: &Region, mut visit: impl FnMut(u32, Vec3)) {
        self.loads.touched.sort_unstable();
        for node in self.loads.touched.drain(..) {
            let loads = std::mem::replace(&mut self.loads.loads[node as usize], NO_JET);
            self.loads.is_touched[node as usize] = false;
            self.adjacency.pull_back(region, &self.fits, node, &loads, &mut visit);
        }
    }
}
