//! A block of eight springs in AVX-512, operation by operation the same as [`super::one`].

use super::{Block, LANES, NO_DIRECTION, Springs, Vectors};
use pulp::x86::V4;
use pulp::{cast, f64x8, u64x8};
use std::arch::x86_64::_CMP_NLT_UQ;

/// Eight vectors of three, 24 doubles in a row.
type Rows = [f64x8; 3];

impl Block for V4 {
    #[inline(always)]
    fn forces<const DAMPED: bool>(self, s: &Springs<'_>, e: usize, a: usize, b: usize, run: usize) -> Vectors {
        let d = difference(self, s.x, a, b);
        let l2 = dot(self, d, d);
        let rate = if DAMPED { dot(self, d, difference(self, s.v, a, b)) } else { self.splat_f64x8(0.0) };
        let (l0, k) = (eight(s.length, e), eight(s.stiffness, e));
        let factor = law::<DAMPED>(self, l2, rate, l0, k, s.damping_time);
        let factor = self.avx512f._mm512_maskz_mov_pd(((1_u32 << run) - 1) as u8, cast(factor));
        let spread = |index: u64x8| cast(self.avx512f._mm512_permutexvar_pd(cast(index), factor));
        let f: Rows = std::array::from_fn(|row| self.mul_f64x8(spread(SPREAD[row]), d[row]));
        cast(f)
    }
}

#[inline(always)]
fn eight(of: &[f64], from: usize) -> f64x8 {
    let chunk: &[f64; LANES] = of[from..].first_chunk().expect("the caller saw that the block fits");
    cast(*chunk)
}

#[inline(always)]
fn rows(of: &[[f64; 3]], from: usize) -> Rows {
    let chunk: &Vectors = of[from..].first_chunk().expect("the caller saw that the block fits");
    cast(*chunk)
}

#[inline(always)]
fn difference(simd: V4, of: &[[f64; 3]], a: usize, b: usize) -> Rows {
    let (from, to) = (rows(of, a), rows(of, b));
    std::array::from_fn(|row| simd.sub_f64x8(to[row], from[row]))
}

/// Where component i of vector j of 24 doubles in a row stands, in two steps: from the first two rows (places 0 to 15 of
/// the pair), then from that and the third (8 to 15). `-` marks what the second step overwrites.
const FIRST: [u64x8; 3] =
    [u64x8(0, 3, 6, 9, 12, 15, 0, 0), u64x8(1, 4, 7, 10, 13, 0, 0, 0), u64x8(2, 5, 8, 11, 14, 0, 0, 0)];
const SECOND: [u64x8; 3] =
    [u64x8(0, 1, 2, 3, 4, 5, 10, 13), u64x8(0, 1, 2, 3, 4, 8, 11, 14), u64x8(0, 1, 2, 3, 4, 9, 12, 15)];
/// The lane each of the 24 doubles belongs to.
const SPREAD: [u64x8; 3] =
    [u64x8(0, 0, 0, 1, 1, 1, 2, 2), u64x8(2, 3, 3, 3, 4, 4, 4, 5), u64x8(5, 5, 6, 6, 6, 7, 7, 7)];

/// The dot product of each pair of vectors.
#[inline(always)]
fn dot(simd: V4, a: Rows, b: Rows) -> f64x8 {
    let p: Rows = std::array::from_fn(|row| simd.mul_f64x8(a[row], b[row]));
    let component = |i: usize| -> f64x8 {
        let two = simd.avx512f._mm512_permutex2var_pd(cast(p[0]), cast(FIRST[i]), cast(p[1]));
        cast(simd.avx512f._mm512_permutex2var_pd(two, cast(SECOND[i]), cast(p[2])))
    };
    simd.add_f64x8(simd.add_f64x8(component(0), component(1)), component(2))
}

#[inline(always)]
fn law<const DAMPED: bool>(simd: V4, l2: f64x8, rate: f64x8, l0: f64x8, k: f64x8, damping_time: f64) -> f64x8 {
    let mul = |a, b| simd.mul_f64x8(a, b);
    let l: f64x8 = cast(simd.avx512f._mm512_sqrt_pd(cast(l2)));
    let stretched = mul(simd.sub_f64x8(l, l0), l);
    let ahead = if DAMPED { simd.add_f64x8(stretched, mul(simd.splat_f64x8(damping_time), rate)) } else { stretched };
    let factor = mul(simd.div_f64x8(k, l2), ahead);
    let shortest = mul(simd.splat_f64x8(NO_DIRECTION), l0);
    let directed = simd.avx512f._mm512_cmp_pd_mask::<_CMP_NLT_UQ>(cast(l2), cast(mul(shortest, shortest)));
    cast(simd.avx512f._mm512_maskz_mov_pd(directed, cast(factor)))
}
