//! A block of eight springs in AVX-512, with the operations of [`super::spring_force`] in the same order.

use super::{Block, BlockKernel, BlockVectors, LANES, MIN_LENGTH_RATIO, SpringState, Springs};
use pulp::x86::V4 as Avx512;
use pulp::{cast, f64x8, u64x8};
use std::arch::x86_64::_CMP_NLT_UQ;

/// Eight vectors as they lie in memory: 24 consecutive doubles in three registers.
type Packed = [f64x8; 3];

impl BlockKernel for Avx512 {
    #[inline(always)]
    fn forces<const DAMPED: bool>(self, s: &Springs<'_>, block: Block) -> BlockVectors {
        let Block { first_spring: e, a, b, len } = block;
        let d = difference(self, s.x, a, b);
        let l2 = dot(self, d, d);
        let d_dot_w = if DAMPED { dot(self, d, difference(self, s.v, a, b)) } else { self.splat_f64x8(0.0) };
        let spring = SpringState { l2, d_dot_w, l0: eight(s.rest_length, e), k: eight(s.stiffness, e) };
        let factor = force_factor::<DAMPED>(self, spring, s.damping_time);
        let factor = self.avx512f._mm512_maskz_mov_pd(((1_u32 << len) - 1) as u8, cast(factor));
        let spread = |index: u64x8| cast(self.avx512f._mm512_permutexvar_pd(cast(index), factor));
        let f: Packed = std::array::from_fn(|i| self.mul_f64x8(spread(LANE_OF_ENTRY[i]), d[i]));
        cast(f)
    }
}

#[inline(always)]
fn eight(values: &[f64], first: usize) -> f64x8 {
    let chunk: &[f64; LANES] = values[first..].first_chunk().expect("the caller checked that the block fits");
    cast(*chunk)
}

#[inline(always)]
fn packed(vectors: &[[f64; 3]], first: usize) -> Packed {
    let chunk: &BlockVectors = vectors[first..].first_chunk().expect("the caller checked that the block fits");
    cast(*chunk)
}

/// Vectors `b, b + 1, ..` minus vectors `a, a + 1, ..`
#[inline(always)]
fn difference(simd: Avx512, vectors: &[[f64; 3]], a: usize, b: usize) -> Packed {
    let (from, to) = (packed(vectors, a), packed(vectors, b));
    std::array::from_fn(|i| simd.sub_f64x8(to[i], from[i]))
}

/// Indices that extract component i of all eight vectors, in two permutations: the first takes entries of the first two registers (0 to
/// 15), the second completes its result with entries of the third (8 to 15). A 0 stands for a lane the second one overwrites.
const FIRST: [u64x8; 3] =
    [u64x8(0, 3, 6, 9, 12, 15, 0, 0), u64x8(1, 4, 7, 10, 13, 0, 0, 0), u64x8(2, 5, 8, 11, 14, 0, 0, 0)];
const SECOND: [u64x8; 3] =
    [u64x8(0, 1, 2, 3, 4, 5, 10, 13), u64x8(0, 1, 2, 3, 4, 8, 11, 14), u64x8(0, 1, 2, 3, 4, 9, 12, 15)];
/// The spring each of the 24 doubles belongs to.
const LANE_OF_ENTRY: [u64x8; 3] =
    [u64x8(0, 0, 0, 1, 1, 1, 2, 2), u64x8(2, 3, 3, 3, 4, 4, 4, 5), u64x8(5, 5, 6, 6, 6, 7, 7, 7)];

/// Scalar product of each pair of vectors.
#[inline(always)]
fn dot(simd: Avx512, a: Packed, b: Packed) -> f64x8 {
    let p: Packed = std::array::from_fn(|i| simd.mul_f64x8(a[i], b[i]));
    let component = |i: usize| -> f64x8 {
        let two = simd.avx512f._mm512_permutex2var_pd(cast(p[0]), cast(FIRST[i]), cast(p[1]));
        cast(simd.avx512f._mm512_permutex2var_pd(two, cast(SECOND[i]), cast(p[2])))
    };
    simd.add_f64x8(simd.add_f64x8(component(0), component(1)), component(2))
}

/// [`super::force_factor`] of eight springs.
#[inline(always)]
fn force_factor<const DAMPED: bool>(simd: Avx512, spring: SpringState<f64x8>, damping_time: f64) -> f64x8 {
    let SpringState { l2, d_dot_w, l0, k } = spring;
    let mul = |a, b| simd.mul_f64x8(a, b);
    let l: f64x8 = cast(simd.avx512f._mm512_sqrt_pd(cast(l2)));
    let elastic = mul(simd.sub_f64x8(l, l0), l);
    let total = if DAMPED { simd.add_f64x8(elastic, mul(simd.splat_f64x8(damping_time), d_dot_w)) } else { elastic };
    let factor = mul(simd.div_f64x8(k, l2), total);
    let min_length = mul(simd.splat_f64x8(MIN_LENGTH_RATIO), l0);
    // Not less, so that a NaN keeps its force.
    let has_direction = simd.avx512f._mm512_cmp_pd_mask::<_CMP_NLT_UQ>(cast(l2), cast(mul(min_length, min_length)));
    cast(simd.avx512f._mm512_maskz_mov_pd(has_direction, cast(factor)))
}
