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
}

impl SmoothEmbedding {
    /// Adds a force (N) at a place of a cell with these weights.
    pub(in super::super) fn add_load(&mut self, region: &Region, cell: usize, weights: &Weights, force: Vec3) {
        let JetLoads { loads, touched, is_touched } = &mut self.loads;
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
