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

/// Blocks of the pairs of corners of a few tetrahedra, one for each lane, that go to the matrix element by element. Pairs of several elements share a
/// block of the matrix, so the order of the sums would depend on the vector unit if a pair of all lanes came before the next pair.
pub struct ElementBlocks<T> {
    /// Block of each lane and pair of corners ([`pair_index`](crate::pair_index)), N/m.
    blocks: [[[[T; 3]; 3]; CORNER_PAIRS.len()]; MAX_LANES],
}

/// Pairs of corners (a, b), a <= b, of a tetrahedron, in the order of [`pair_index`](crate::pair_index).
pub const CORNER_PAIRS: [(usize, usize); 10] =
    [(0, 0), (0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3), (2, 2), (2, 3), (3, 3)];

impl<T: BlockScalar> Default for ElementBlocks<T> {
    fn default() -> Self {
        Self { blocks: [[[[T::from_f64(0.0); 3]; 3]; CORNER_PAIRS.len()]; MAX_LANES] }
    }
}

impl<T: BlockScalar> ElementBlocks<T> {
    /// Sets the block of corners a and b, N/m.
    #[inline(always)]
    pub fn set<S: Simd>(&mut self, a: usize, b: usize, block: &Mat3<Wide<S>>) {
        let pair = crate::pair_index(a, b, 4);
        for i in 0..3 {
            for j in 0..3 {
                let entries = block[i][j].to_array();
                for lane in 0..S::F64_LANES {
                    self.blocks[lane][pair][i][j] = T::from_f64(entries[lane]);
                }
            }
        }
    }

    /// Adds the blocks of these lanes, in ascending order, to the matrix; `first` is the element of lane 0.
    #[inline(always)]
    pub fn add_to(&self, out: &mut Blocks<'_, T>, first: usize, lanes: impl Iterator<Item = usize>) {
        for lane in lanes {
            for (pair, (a, b)) in CORNER_PAIRS.into_iter().enumerate() {
                if a != b || T::HAS_DIAGONAL_BLOCKS {
                    out.add(first + lane, pair, &self.blocks[lane][pair]);
                }
            }
        }
    }
}
