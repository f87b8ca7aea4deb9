//! Stiffness of springs, one per lane of a vector register, for a matrix in double or single precision.
//!
//! The block of a spring is `k (n n^T + max(0, 1 - l0/l) (I - n n^T)) + c n n^T`, N/m, with its axis n and damping c: the derivative of the
//! force on the first end by the position of the second. The negative transverse part of a compressed spring is left out, so that
//! the matrix is positive semi-definite. A spring without length has no direction, and its block is zero. Everything is computed
//! in double precision; entries for a matrix in single precision are rounded last.

use crate::gather::WideSprings;
use crate::kernel::{MIN_LENGTH_RATIO, Springs};
use pliant_plugin_api::lanes::{MAX_LANES, Real};
use pliant_plugin_api::{BlockScalar, BlockWindow, Blocks, TangentScale, abi, pair_index};
use pulp::{Simd, WithSimd};

/// For each entry of the upper triangle, row by row, its index in a block and that of its mirror image.
const ENTRIES: [[usize; 2]; 6] = [[0, 0], [1, 3], [2, 6], [4, 4], [5, 7], [8, 8]];

/// Adds the stiffness and damping of each spring of a call.
pub struct Stiffness<'a, T> {
    springs: Springs<'a>,
    /// Factors of stiffness and damping.
    scale: TangentScale,
    /// Blocks of the matrix.
    window: BlockWindow<'a, T, 3>,
}

impl<'a, T: BlockScalar> Stiffness<'a, T> {
    /// `scale.stiffness` K + `scale.damping` C.
    pub fn new(springs: Springs<'a>, scale: TangentScale, out: &'a mut Blocks<'_, T>) -> Self {
        Self { springs, scale, window: out.window() }
    }
}

impl<T: BlockScalar> WithSimd for Stiffness<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (mut upper, mut blocks) = ([[0.0; MAX_LANES]; 6], [[T::from_f64(0.0); 9]; MAX_LANES]);
        for e in (0..self.springs.ends.len()).step_by(S::F64_LANES) {
            self.upper_triangles(simd, e, &mut upper);
            for (values, [entry, mirror]) in upper.iter().zip(ENTRIES) {
                for lane in 0..S::F64_LANES {
                    let value = T::from_f64(values[lane]);
                    blocks[lane][entry] = value;
                    blocks[lane][mirror] = value;
                }
            }
            for lane in 0..S::F64_LANES.min(self.springs.ends.len() - e) {
                let slots = self.window.slots[e + lane];
                if T::HAS_DIAGONAL_BLOCKS {
                    self.add(slots[pair_index(0, 0, 2)], &blocks[lane]);
                    self.add(slots[pair_index(1, 1, 2)], &blocks[lane]);
                }
                self.subtract(slots[pair_index(0, 1, 2)], &blocks[lane]);
            }
        }
    }
}

impl<T: BlockScalar> Stiffness<'_, T> {
    /// The block of a slot. A spring's block is symmetric, so its orientation does not matter; [`Blocks::add`] would look at it, which
    /// makes a step 5 % slower.
    #[inline(always)]
    fn target(&mut self, slot: u32) -> &mut [T; 9] {
        &mut self.window.blocks[(slot & !abi::TRANSPOSED) as usize - self.window.first_slot]
    }

    #[inline(always)]
    fn add(&mut self, slot: u32, block: &[T; 9]) {
        let target = self.target(slot);
        let mut sum = *target;
        for i in 0..9 {
            sum[i] += block[i];
        }
        *target = sum;
    }

    #[inline(always)]
    fn subtract(&mut self, slot: u32, block: &[T; 9]) {
        let target = self.target(slot);
        let mut sum = *target;
        for i in 0..9 {
            sum[i] -= block[i];
        }
        *target = sum;
    }

    /// Writes the upper triangles of the blocks of springs `e, e + 1, ..`, by entry and lane.
    #[inline(always)]
    fn upper_triangles<S: Simd>(&self, simd: S, e: usize, out: &mut [[f64; MAX_LANES]; 6]) {
        let WideSprings { d, l2, l0, k } = self.springs.gather(simd, e);
        let (zero, one) = (l2.splat(0.0), l2.splat(1.0));
        let inverse_l2 = one / l2;
        let l0_over_l = l0 * l2.sqrt() * inverse_l2;
        let stiffness = k * self.scale.stiffness;
        let damping = k * (self.scale.damping * self.springs.damping_time);
        let across = stiffness * (one - l0_over_l).max(zero);
        let [x, y, z] = d.0;
        let [u, v, w] = (d * ((stiffness + damping - across) * inverse_l2)).0;
        let min_length = l0 * MIN_LENGTH_RATIO;
        let entries = [u * x + across, u * y, u * z, v * y + across, v * z, w * z + across];
        for i in 0..6 {
            out[i] = l2.if_less(min_length * min_length, zero, entries[i]).to_array();
        }
    }
}
