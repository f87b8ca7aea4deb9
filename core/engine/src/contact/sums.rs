//! Loads summed by node.

use pliant_solver::{Block, NodeSprings, Vec3};

/// Sums by node, dense, and which nodes have one.
#[derive(Debug, Default)]
pub(super) struct Sums {
    force: Vec<Vec3>,
    stiffness: Vec<Block>,
    damping: Vec<Block>,
    seen: Vec<bool>,
    touched: Vec<u32>,
}

impl Sums {
    pub fn begin(&mut self, nodes: usize) {
        if self.force.len() < nodes {
            self.force.resize(nodes, Vec3::zeros());
            self.stiffness.resize(nodes, [0.0; 9]);
            self.damping.resize(nodes, [0.0; 9]);
            self.seen.resize(nodes, false);
        }
        self.touched.clear();
    }

    pub fn touch(&mut self, node: u32) -> (&mut Vec3, &mut Block, &mut Block) {
        let n = node as usize;
        if !self.seen[n] {
            self.seen[n] = true;
            self.touched.push(node);
        }
        (&mut self.force[n], &mut self.stiffness[n], &mut self.damping[n])
    }

    pub fn add(&mut self, node: u32, weight: f64, force: Vec3, stiffness: &Block, damping: &Block) {
        let (f, k, c) = self.touch(node);
        *f += weight * force;
        for e in 0..9 {
            k[e] += weight * stiffness[e];
            c[e] += weight * damping[e];
        }
    }

    /// N, all of them.
    pub fn total(&self) -> Vec3 {
        self.touched.iter().map(|&n| self.force[n as usize]).sum()
    }

    /// Empties the sums into `out`, with every force times `scale`.
    pub fn give(&mut self, scale: f64, x: &[Vec3], out: &mut NodeSprings) {
        self.touched.sort_unstable();
        out.clear();
        for &node in &self.touched {
            let n = node as usize;
            let force = scale * std::mem::take(&mut self.force[n]);
            let (stiffness, damping) = (std::mem::take(&mut self.stiffness[n]), std::mem::take(&mut self.damping[n]));
            self.seen[n] = false;
            out.push(node, force, stiffness, damping, x[n]);
        }
    }
}
