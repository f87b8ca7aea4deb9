//! Loads summed by node.

use pliant_solver::{Block, NodeSprings, V3, axpy};

/// Sums by node, dense, and which nodes have one.
#[derive(Debug, Default)]
pub(super) struct Sums {
    force: Vec<V3>,
    stiffness: Vec<Block>,
    damping: Vec<Block>,
    seen: Vec<bool>,
    touched: Vec<u32>,
}

impl Sums {
    pub fn begin(&mut self, nodes: usize) {
        if self.force.len() < nodes {
            self.force.resize(nodes, [0.0; 3]);
            self.stiffness.resize(nodes, [0.0; 9]);
            self.damping.resize(nodes, [0.0; 9]);
            self.seen.resize(nodes, false);
        }
        self.touched.clear();
    }

    pub fn touch(&mut self, node: u32) -> (&mut V3, &mut Block, &mut Block) {
        let n = node as usize;
        if !self.seen[n] {
            self.seen[n] = true;
            self.touched.push(node);
        }
        (&mut self.force[n], &mut self.stiffness[n], &mut self.damping[n])
    }

    pub fn add(&mut self, node: u32, weight: f64, force: V3, stiffness: &Block, damping: &Block) {
        let (f, k, c) = self.touch(node);
        *f = axpy(*f, weight, force);
        for e in 0..9 {
            k[e] += weight * stiffness[e];
            c[e] += weight * damping[e];
        }
    }

    /// N, all of them.
    pub fn total(&self) -> V3 {
        self.touched.iter().fold([0.0; 3], |sum, &n| axpy(sum, 1.0, self.force[n as usize]))
    }

    /// Empties the sums into `out`, with every force times `scale`.
    pub fn give(&mut self, scale: f64, x: &[V3], out: &mut NodeSprings) {
        self.touched.sort_unstable();
        out.clear();
        for &node in &self.touched {
            let n = node as usize;
            let force = std::mem::take(&mut self.force[n]).map(|f| scale * f);
            let (stiffness, damping) = (std::mem::take(&mut self.stiffness[n]), std::mem::take(&mut self.damping[n]));
            self.seen[n] = false;
            out.push(node, force, stiffness, damping, x[n]);
        }
    }
}
