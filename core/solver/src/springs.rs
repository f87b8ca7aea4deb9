//! What a tool does to the nodes of a body during one step: a force on each, and how it changes as the node moves.
//!
//! The linear contact model of a step: node n is pulled with `F = force - stiffness (x - anchor) - damping v`. Explicit
//! schemes evaluate it in every substep; implicit ones add its blocks to the diagonal of the matrix. A load that is spread
//! over weighted nodes is lumped: each gets its share of the stiffness, which is never less stiff than the exact low-rank
//! matrix, so what is stable with the one is stable with the other.

use super::algebra::{Block, Vec3, matrix3};

/// Forces on nodes that follow them.
#[derive(Debug, Default)]
pub struct NodeSprings {
    /// Which, rising (k)
    pub nodes: Vec<u32>,
    /// N, at the anchor (k x 3)
    pub force: Vec<Vec3>,
    /// N/m (k blocks)
    pub stiffness: Vec<Block>,
    /// N s/m (k blocks)
    pub damping: Vec<Block>,
    /// m, where the force holds (k x 3)
    pub anchor: Vec<Vec3>,
}

impl NodeSprings {
    /// Nothing pulled; keeps its buffers.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.force.clear();
        self.stiffness.clear();
        self.damping.clear();
        self.anchor.clear();
    }

    /// Whether nothing is pulled.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Pulls one more node, which is at `anchor` now.
    pub fn push(&mut self, node: u32, force: Vec3, stiffness: Block, damping: Block, anchor: Vec3) {
        self.nodes.push(node);
        self.force.push(force);
        self.stiffness.push(stiffness);
        self.damping.push(damping);
        self.anchor.push(anchor);
    }

    /// N, on the i-th node pulled; without `v`, its elastic part.
    #[inline(always)]
    fn load(&self, i: usize, x: &[Vec3], v: Option<&[Vec3]>) -> Vec3 {
        let node = self.nodes[i] as usize;
        let f = self.force[i] - matrix3(&self.stiffness[i]) * (x[node] - self.anchor[i]);
        v.map_or(f, |v| f - matrix3(&self.damping[i]) * v[node])
    }

    /// Adds the forces to those on the nodes.
    pub fn add_to(&self, force: &mut [Vec3], x: &[Vec3], v: Option<&[Vec3]>) {
        for (i, &node) in self.nodes.iter().enumerate() {
            force[node as usize] += self.load(i, x, v);
        }
    }

    /// Potential energy without damping, from where each holds, J.
    pub fn potential(&self, x: &[Vec3]) -> f64 {
        let each = self.nodes.iter().enumerate().map(|(i, &node)| {
            let d = x[node as usize] - self.anchor[i];
            0.5 * d.dot(&(matrix3(&self.stiffness[i]) * d)) - self.force[i].dot(&d)
        });
        each.sum()
    }

    /// N, all of them together.
    pub fn total(&self, x: &[Vec3], v: &[Vec3]) -> Vec3 {
        (0..self.nodes.len()).map(|i| self.load(i, x, Some(v))).sum()
    }

    /// The largest stiffness over mass, 1/s^2, and damping over mass, 1/s, of a node.
    pub fn rates(&self, mass: &[f64]) -> (f64, f64) {
        let trace = |b: &Block| b[0].max(b[4]).max(b[8]);
        let mut rates = (0.0_f64, 0.0_f64);
        for (i, &node) in self.nodes.iter().enumerate() {
            let m = mass[node as usize];
            rates = (rates.0.max(trace(&self.stiffness[i]) / m), rates.1.max(trace(&self.damping[i]) / m));
        }
        rates
    }
}
