//! From arrays of nodes to vector registers and back: one element for each lane. Results are added element by element in the order of the
//! list, so the bytes do not depend on the vector unit.

use super::matrix::Mat3;
use crate::lanes::{self, MAX_LANES, NodeVectorsView, Vec3, Wide};
use crate::{BlockScalar, Blocks, NodeVectors};
use pulp::Simd;

/// The vectors at the corners of elements `e, e + 1, ..`; lanes past the end repeat the last element.
#[inline(always)]
pub fn gather<S: Simd>(simd: S, nodes: &[[u32; 4]], e: usize, vectors: &[[f64; 3]]) -> [Vec3<Wide<S>>; 4] {
    lanes::gather(simd, nodes, e, NodeVectorsView::new(vectors))
}

/// Adds vectors to the corners of elements `e, e + 1, ..`. Returns a sum over them that is finite only if the vectors of the last three corners
/// are.
#[inline(always)]
pub fn scatter<S: Simd>(nodes: &[[u32; 4]], e: usize, vectors: &[Vec3<Wide<S>>; 4], out: &mut NodeVectors<'_>) -> f64 {
    // By corner, axis and lane.
    let mut lanes = [[[0.0; MAX_LANES]; 3]; 4];
    for corner in 0..4 {
        for i in 0..3 {
            lanes[corner][i] = vectors[corner][i].to_array();
        }
    }
    let mut sum = 0.0;
    for lane in 0..S::F64_LANES.min(nodes.len() - e) {
        for corner in 0..4 {
            let [x, y, z] = &lanes[corner];
            out.add(nodes[e + lane][corner], [x[lane], y[lane], z[lane]]);
        }
        sum += lanes[1][0][lane] + lanes[2][1][lane] + lanes[3][2][lane];
    }
    sum
}

/// Adds the block of a pair of corners ([`pair_index`](crate::pair_index)) to the matrix for a range of elements, one per lane.
#[inline(always)]
pub fn add_blocks<S: Simd, T: BlockScalar>(
    out: &mut Blocks<'_, T>,
    elements: core::ops::Range<usize>,
    pair: usize,
    block: &Mat3<Wide<S>>,
) {
    let mut blocks = [[[T::from_f64(0.0); 3]; 3]; MAX_LANES];
    for i in 0..3 {
        for j in 0..3 {
            let entries = block[i][j].to_array();
            for lane in 0..S::F64_LANES {
                blocks[lane][i][j] = T::from_f64(entries[lane]);
            }
        }
    }
    for (e, block) in elements.zip(&blocks) {
        out.add(e, pair, block);
    }
}
