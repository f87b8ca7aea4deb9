//! List of the constrained nodes, with their filters in single precision.

use crate::algebra::{SingleBlock, Vec3};
use crate::constraint::Constraint;
use crate::lanes::{LANES, Vectors};

/// A constrained node and its filter S_i as a matrix.
#[derive(Clone, Copy, Debug)]
pub struct ConstrainedNode {
    node: u32,
    filter: SingleBlock,
}

impl ConstrainedNode {
    /// Replaces `out` by the nodes that are not free, ascending.
    pub fn list(constraints: &[Constraint], out: &mut Vec<Self>) {
        out.clear();
        for (node, constraint) in constraints.iter().enumerate().filter(|(_, c)| !c.is_free()) {
            let columns = [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| constraint.filter(axis));
            let filter = std::array::from_fn(|e| columns[e % 3][e / 3] as f32);
            out.push(Self { node: node as u32, filter });
        }
    }

    /// Index of the node.
    pub fn index(&self) -> usize {
        self.node as usize
    }

    /// Applies the filters of `nodes` to `field`, vectors in groups of sixteen nodes.
    pub fn filter(nodes: &[Self], field: &mut [Vectors]) {
        for Self { node, filter: m } in nodes {
            let (sixteen, lane) = (&mut field[*node as usize / LANES], *node as usize % LANES);
            let [x, y, z] = [0, 1, 2].map(|c: usize| sixteen[c][lane]);
            (0..3).for_each(|r| sixteen[r][lane] = m[3 * r] * x + m[3 * r + 1] * y + m[3 * r + 2] * z);
        }
    }
}
