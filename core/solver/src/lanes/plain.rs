//! The portable fallback, for processors without a supported vector unit.

use super::blocks::{BlockUnit, COLUMN, ENTRY, ROW, Scalar};
use super::{Lanes, Quad, Sixteen, flush_denormals};

/// The portable vector unit, which processes one number after the other.
#[derive(Clone, Copy)]
pub struct Plain;

impl Lanes for Plain {
    type V = Sixteen;
    type F64Blocks = Self;
    type F32Blocks = Self;
    type D = f64;
    const EXACT: usize = 1;

    #[inline(always)]
    fn f64_blocks(self) -> Self {
        self
    }

    #[inline(always)]
    fn f32_blocks(self) -> Self {
        self
    }

    #[inline(always)]
    fn load(self, from: &Sixteen) -> Sixteen {
        *from
    }

    #[inline(always)]
    fn store(self, v: Sixteen) -> Sixteen {
        v
    }

    #[inline(always)]
    fn add(self, mut a: Sixteen, b: Sixteen) -> Sixteen {
        (0..16).for_each(|l| a[l] += b[l]);
        a
    }

    #[inline(always)]
    fn sub(self, mut a: Sixteen, b: Sixteen) -> Sixteen {
        (0..16).for_each(|l| a[l] -= b[l]);
        a
    }

    #[inline(always)]
    fn mul(self, mut a: Sixteen, b: Sixteen) -> Sixteen {
        (0..16).for_each(|l| a[l] *= b[l]);
        a
    }

    #[inline(always)]
    fn fma(self, mut a: Sixteen, b: Sixteen, c: Sixteen) -> Sixteen {
        (0..16).for_each(|l| a[l] = fused(a[l], b[l], c[l]));
        a
    }

    #[inline(always)]
    fn fnma(self, mut a: Sixteen, b: Sixteen, c: Sixteen) -> Sixteen {
        (0..16).for_each(|l| a[l] = fused(-a[l], b[l], c[l]));
        a
    }

    #[inline(always)]
    fn four(self, vectors: [&Quad; 4]) -> Sixteen {
        let mut all = [0.0; 16];
        (0..16).for_each(|l| all[l] = vectors[l / 4][l % 4]);
        all
    }

    #[inline(always)]
    fn each_four(self, numbers: &Quad) -> Sixteen {
        let mut all = [0.0; 16];
        (0..16).for_each(|l| all[l] = numbers[l / 4]);
        all
    }

    #[inline(always)]
    fn sum_of_four(self, v: Sixteen) -> Quad {
        let mut sum = [0.0; 4];
        (0..4).for_each(|c| sum[c] = (v[c] + v[8 + c]) + (v[4 + c] + v[12 + c]));
        sum
    }

    #[inline(always)]
    fn lookup(self, from: [Sixteen; 2], places: &[u8; 16]) -> Sixteen {
        places.map(|at| from[at as usize / 16 % 2][at as usize % 16])
    }

    #[inline(always)]
    fn flush_denormals(self, v: Sixteen) -> Sixteen {
        v.map(flush_denormals)
    }

    #[inline(always)]
    fn exact(self, from: &[f32]) -> f64 {
        f64::from(from[0])
    }

    #[inline(always)]
    fn load_exact(self, from: &[f64]) -> f64 {
        from[0]
    }

    #[inline(always)]
    fn store_exact(self, v: f64, to: &mut [f64]) {
        to[0] = v;
    }

    #[inline(always)]
    fn add_exact(self, a: f64, b: f64) -> f64 {
        a + b
    }

    #[inline(always)]
    fn sub_exact(self, a: f64, b: f64) -> f64 {
        a - b
    }

    #[inline(always)]
    fn add_product(self, a: f64, b: f64, c: f64) -> f64 {
        a * b + c
    }

    #[inline(always)]
    fn take_product(self, a: f64, b: f64, c: f64) -> f64 {
        c - a * b
    }

    #[inline(always)]
    fn round(self, from: &[f64; 16]) -> Sixteen {
        from.map(|value| value as f32)
    }

    #[inline(always)]
    fn planes(self, vectors: [Sixteen; 4]) -> [Sixteen; 3] {
        let mut planes = [[0.0; 16]; 3];
        (0..16).for_each(|l| (0..3).for_each(|c| planes[c][l] = vectors[l / 4][l % 4 * 4 + c]));
        planes
    }

    #[inline(always)]
    fn vectors(self, planes: [Sixteen; 3]) -> [Sixteen; 4] {
        let mut vectors = [[0.0; 16]; 4];
        (0..16).for_each(|l| (0..3).for_each(|c| vectors[l / 4][l % 4 * 4 + c] = planes[c][l]));
        vectors
    }
}

impl<T: Scalar> BlockUnit<T> for Plain {
    type Eight = [T; 8];

    #[inline(always)]
    fn load_eight(self, from: &[T; 8]) -> [T; 8] {
        *from
    }

    #[inline(always)]
    fn load_eight_f32(self, from: &[f32; 8]) -> [T; 8] {
        from.map(T::from)
    }

    #[inline(always)]
    fn store_eight(self, v: [T; 8]) -> [T; 8] {
        v
    }

    #[inline(always)]
    fn add_eight(self, mut a: [T; 8], b: [T; 8]) -> [T; 8] {
        (0..8).for_each(|e| a[e] = a[e] + b[e]);
        a
    }

    #[inline(always)]
    fn mul_eight(self, mut a: [T; 8], b: [T; 8]) -> [T; 8] {
        (0..8).for_each(|e| a[e] = a[e] * b[e]);
        a
    }

    #[inline(always)]
    fn at_rows(self, v: &[T; 4]) -> [T; 8] {
        ROW.map(|at| v[at as usize])
    }

    #[inline(always)]
    fn at_columns(self, v: &[T; 4]) -> [T; 8] {
        COLUMN.map(|at| v[at as usize])
    }

    #[inline(always)]
    fn at_entries(self, v: [T; 8], transposed: usize) -> [T; 8] {
        ENTRY[transposed].map(|at| v[at as usize])
    }
}

/// `a b + c`, rounded once.
#[inline(always)]
#[allow(clippy::disallowed_methods, reason = "one instruction where it is called, and exact everywhere")]
pub fn fused(a: f32, b: f32, c: f32) -> f32 {
    if cfg!(any(target_arch = "aarch64", target_feature = "fma")) {
        return a.mul_add(b, c);
    }
    in_double(a, b, c)
}

/// As [`fused`], in double precision, for processors without a fused multiply-add instruction. The product is exact; the sum is rounded to odd, so that the
/// second rounding to single precision gives the correct result (Boldo and Melquiond 2008).
#[inline(always)]
pub fn in_double(a: f32, b: f32, c: f32) -> f32 {
    let (product, c) = (f64::from(a) * f64::from(b), f64::from(c));
    let sum = product + c;
    let added = sum - product;
    let lost = (product - (sum - added)) + (c - added);
    let bits = sum.to_bits();
    let is_even = lost != 0.0 && sum.is_finite() && bits & 1 == 0;
    let odd = if (lost > 0.0) == (sum > 0.0) { bits + 1 } else { bits.wrapping_sub(1) };
    f64::from_bits(if is_even { odd } else { bits }) as f32
}
