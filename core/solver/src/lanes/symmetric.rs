//! Symmetric blocks by sixteen nodes, stored as six numbers each.

use super::{Lanes, Sixteen};
use crate::algebra::Block;

/// Products of sixteen symmetric blocks with vectors.
#[inline(always)]
pub fn times<U: Lanes>(unit: U, m: &[Sixteen; 6], v: [U::V; 3]) -> [U::V; 3] {
    let mut out = v;
    for (out, places) in out.iter_mut().zip([[0, 1, 2], [1, 3, 4], [2, 4, 5]]) {
        *out = unit.mul(unit.load(&m[places[0]]), v[0]);
        *out = unit.fma(unit.load(&m[places[1]]), v[1], *out);
        *out = unit.fma(unit.load(&m[places[2]]), v[2], *out);
    }
    out
}

/// Indices of the six stored numbers in a 3 x 3 block.
pub const PLACES: [usize; 6] = [0, 1, 2, 4, 5, 8];

/// Stores the symmetric inverse of the diagonal block of node `i` among those of all nodes, of which sixteen are together.
pub fn put_inverse(all: &mut [f32], i: usize, inverse: &Block) {
    put_block(&mut all.as_chunks_mut().0.as_chunks_mut().0[i / 16], i % 16, inverse);
}

/// Stores the six numbers of a symmetric block, rounded to single precision, in lane `lane` (0 to 15).
pub fn put_block(sixteen: &mut [Sixteen; 6], lane: usize, block: &Block) {
    (0..6).for_each(|e| sixteen[e][lane] = block[PLACES[e]] as f32);
}
