//! Nodes that are held, and what they may still do in single precision.

use crate::algebra::{SingleBlock, Vec3};
use crate::constraint::Constraint;
use crate::lanes::{LANES, Vectors};

/// What a held node may still do, as a matrix.
#[derive(Clone, Copy, Debug)]
pub struct Held {
    node: u32,
    filter: SingleBlock,
}

impl Held {
    /// Of those that are not free.
    pub fn list(constraints: &[Constraint], held: &mut Vec<Self>) {
        held.clear();
        for (node, constraint) in constraints.iter().enumerate().filter(|(_, c)| !c.is_free()) {
            let columns = [Vec3::x(), Vec3::y(), Vec3::z()].map(|axis| constraint.filter(axis));
            let filter = std::array::from_fn(|e| columns[e % 3][e / 3] as f32);
            held.push(Self { node: node as u32, filter });
        }
    }

    /// Which one it is.
    pub fn node(&self) -> usize {
        self.node as usize
    }

    /// Takes out of `field` what held nodes may not do.
    pub fn filter(held: &[Self], field: &mut [Vectors]) {
        for Self { node, filter: m } in held {
            let (sixteen, lane) = (&mut field[*node as usize / LANES], *node as usize % LANES);
            let [x, y, z] = [0, 1, 2].map(|c: usize| sixteen[c][lane]);
            (0..3).for_each(|r| sixteen[r][lane] = m[3 * r] * x + m[3 * r + 1] * y + m[3 * r + 2] * z);
        }
    }
}
