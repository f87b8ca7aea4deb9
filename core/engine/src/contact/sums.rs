//! NodeSums of loads by node.

use pliant_solver::{Block, NodeSprings, Vec3};

/// Dense accumulators of force, stiffness and damping by node, with a list of the nodes that have a load.
#[derive(Debug, Default)]
pub(crate) struct NodeSums {
    /// Force, N (n x 3).
    force: Vec<Vec3>,
    /// Stiffness, N/m (n blocks).
    stiffness: Vec<Block>,
    /// Damping, N s/m (n blocks).
    damping: Vec<Block>,
    /// Whether a node is in `touched` (n).
    seen: Vec<bool>,
    /// Nodes with a load, in the order of their first load.
    touched: Vec<u32>,
}

impl NodeSums {
    /// Prepares the accumulators, which are zero, for this number of nodes.
    pub fn begin(&mut self, nodes: usize) {
        if self.force.len() < nodes {
            self.force.resize(nodes, Vec3::zeros());
            self.stiffness.resize(nodes, [0.0; 9]);
            self.damping.resize(nodes, [0.0; 9]);
            self.seen.resize(nodes, false);
        }
        self.touched.clear();
    }

    /// The accumulators of a node: force, stiffness, damping.
    pub fn entry(&mut self, node: u32) -> (&mut Vec3, &mut Block, &mut Block) {
        let n = node as usize;
        if !self.seen[n] {
            self.seen[n] = true;
            self.touched.push(node);
        }
        (&mut self.force[n], &mut self.stiffness[n], &mut self.damping[n])
    }

    /// Adds a load times `weight` to a node.
    pub fn add(&mut self, node: u32, weight: f64, force: Vec3, stiffness: &Block, damping: &Block) {
        *self.entry(node).0 += weight * force;
        self.add_springs(node, weight, stiffness, damping);
    }

    /// Adds springs whose anchors are the present positions.
    pub fn add_all(&mut self, springs: &NodeSprings) {
        for (i, node) in springs.nodes.iter().enumerate() {
            self.add(*node, 1.0, springs.force[i], &springs.stiffness[i], &springs.damping[i]);
        }
    }

    /// Adds a stiffness and a damping times `weight` to a node.
    pub fn add_springs(&mut self, node: u32, weight: f64, stiffness: &Block, damping: &Block) {
        let (_, k, c) = self.entry(node);
        for e in 0..9 {
            k[e] += weight * stiffness[e];
            c[e] += weight * damping[e];
        }
    }

    /// Sum of all forces, N.
    pub fn total(&self) -> Vec3 {
        self.touched.iter().map(|&n| self.force[n as usize]).sum()
    }

    /// Moves the sums to `out`, nodes ascending, forces scaled by `scale`; sets the accumulators to zero. `x` (n x 3, m) are the positions at
    /// which the forces hold.
    pub fn drain_into(&mut self, scale: f64, x: &[Vec3], out: &mut NodeSprings) {
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
