//! Stiffness of many springs at a time: in double precision, or, where two nodes meet alone, in single.
//!
//! Each spring has `k (n n' + max(0, 1 - l0/l) (I - n n')) + c n n'`, N/m, with n its axis and c its damping: what moving the second
//! end does to the force on the first. The transverse part of a compressed spring is left out, so that the matrix stays positive
//! semi-definite. Where the ends meet it is zero, for want of a direction. All is computed in double precision, with the same
//! operations for any vector unit; what goes to a matrix in single precision is rounded last.

use crate::gather::Gathered;
use crate::kernel::{NO_DIRECTION, Springs};
use pliant_plugin_api::lanes::{MAX_LANES, Real};
use pliant_plugin_api::{BlockScalar, BlockWindow, Blocks, TangentScale, abi, pair_index};
use pulp::{Simd, WithSimd};

/// Where entries of an upper triangle are in a block.
const PLACES: [[usize; 2]; 6] = [[0, 0], [1, 3], [2, 6], [4, 4], [5, 7], [8, 8]];

/// Adds the stiffness of each spring of a call.
pub struct Stiffness<'a, T> {
    springs: Springs<'a>,
    /// 1, and over the stiffness
    factors: [f64; 2],
    slots: &'a [[u32; 3]],
    /// The slot of the first block.
    first: usize,
    blocks: &'a mut [[T; 9]],
}

impl<'a, T: BlockScalar> Stiffness<'a, T> {
    /// `scale.stiffness` K + `scale.damping` C.
    pub fn new(springs: Springs<'a>, scale: TangentScale, out: &'a mut Blocks<'_, T>) -> Self {
        let BlockWindow { slots, first_slot: first, blocks } = out.window();
        Self { springs, factors: [scale.stiffness, scale.damping * springs.damping_time], slots, first, blocks }
    }
}

impl<T: BlockScalar> WithSimd for Stiffness<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let (mut upper, mut rows) = ([[0.0; MAX_LANES]; 6], [[T::from_f64(0.0); 9]; MAX_LANES]);
        for e in (0..self.springs.ends.len()).step_by(S::F64_LANES) {
            self.upper(simd, e, &mut upper);
            for (plane, places) in upper.iter().zip(PLACES) {
                for lane in 0..S::F64_LANES {
                    let value = T::from_f64(plane[lane]);
                    rows[lane][places[0]] = value;
                    rows[lane][places[1]] = value;
                }
            }
            for lane in 0..S::F64_LANES.min(self.springs.ends.len() - e) {
                let slots = self.slots[e + lane];
                if T::HAS_DIAGONAL_BLOCKS {
                    self.add(slots[pair_index(0, 0, 2)], &rows[lane]);
                    self.add(slots[pair_index(1, 1, 2)], &rows[lane]);
                }
                self.subtract(slots[pair_index(0, 1, 2)], &rows[lane]);
            }
        }
    }
}

impl<T: BlockScalar> Stiffness<'_, T> {
    /// Transposed or not: blocks are symmetric, which [`Blocks::add`] does not know; with it a step takes a twentieth longer.
    #[inline(always)]
    fn at(&mut self, slot: u32) -> &mut [T; 9] {
        &mut self.blocks[(slot & !abi::TRANSPOSED) as usize - self.first]
    }

    #[inline(always)]
    fn add(&mut self, slot: u32, block: &[T; 9]) {
        let to = self.at(slot);
        let mut sum = *to;
        for i in 0..9 {
            sum[i] += block[i];
        }
        *to = sum;
    }

    #[inline(always)]
    fn subtract(&mut self, slot: u32, block: &[T; 9]) {
        let to = self.at(slot);
        let mut sum = *to;
        for i in 0..9 {
            sum[i] -= block[i];
        }
        *to = sum;
    }

    /// The upper triangles, row by row, of springs from `e` on.
    #[inline(always)]
    fn upper<S: Simd>(&self, simd: S, e: usize, out: &mut [[f64; MAX_LANES]; 6]) {
        let Gathered { d: [x, y, z], square, l0, k } = self.springs.gather(simd, e);
        let (zero, one) = (square.splat(0.0), square.splat(1.0));
        let over = one / square;
        // l0 / l
        let short = l0 * square.sqrt() * over;
        let most = k * self.factors[0];
        let across = most * (one - short).max(zero);
        let along = (most + k * self.factors[1] - across) * over;
        let [u, v, w] = [along * x, along * y, along * z];
        let shortest = l0 * NO_DIRECTION;
        let all = [u * x + across, u * y, u * z, v * y + across, v * z, w * z + across];
        for i in 0..6 {
            out[i] = square.if_less(shortest * shortest, zero, all[i]).to_array();
        }
    }
}
