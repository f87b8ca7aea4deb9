//! Transposes of small matrices in registers of AVX2 and AVX-512.

use super::{Avx2, Avx512};
use core::arch::x86_64::{__m256, __m256d, __m512, __m512d};
use pulp::bytemuck::cast;

/// Transposes a 4 x 4 matrix of f64.
#[inline(always)]
pub(super) fn transpose_4x4_f64(unit: Avx2, rows: [__m256d; 4]) -> [__m256d; 4] {
    let ([a, b, c, d], unit) = (rows, unit.avx);
    let (even, odd) = (unit._mm256_unpacklo_pd(a, b), unit._mm256_unpackhi_pd(a, b));
    let (other_even, other_odd) = (unit._mm256_unpacklo_pd(c, d), unit._mm256_unpackhi_pd(c, d));
    [
        unit._mm256_permute2f128_pd::<0x20>(even, other_even),
        unit._mm256_permute2f128_pd::<0x20>(odd, other_odd),
        unit._mm256_permute2f128_pd::<0x31>(even, other_even),
        unit._mm256_permute2f128_pd::<0x31>(odd, other_odd),
    ]
}

/// Transposes an 8 x 16 matrix of f32. Each result has two rows of eight: 0 and 4, 1 and 5, 2 and 6, 3 and 7, then 8 and 12, ...
#[inline(always)]
pub(super) fn transpose_8x16_f32(unit: Avx512, [a, b, c, d, e, f, g, h]: [__m512; 8]) -> [__m512; 8] {
    const LOW: [u32; 16] = [0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23];
    const HIGH: [u32; 16] = [8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31];
    let (left, right) =
        (transpose_4x4_f32_per_quarter(unit, [a, b, c, d]), transpose_4x4_f32_per_quarter(unit, [e, f, g, h]));
    let mut out = [a; 8];
    for k in 0..4 {
        out[k] = unit.avx512f._mm512_permutex2var_ps(left[k], cast(LOW), right[k]);
        out[4 + k] = unit.avx512f._mm512_permutex2var_ps(left[k], cast(HIGH), right[k]);
    }
    out
}

/// Transposes the 4 x 4 matrix of f32 in each quarter of four registers.
#[inline(always)]
fn transpose_4x4_f32_per_quarter(unit: Avx512, [a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
    let avx = unit.avx512f;
    let (ab, other_ab) = (cast(avx._mm512_unpacklo_ps(a, b)), cast(avx._mm512_unpackhi_ps(a, b)));
    let (cd, other_cd) = (cast(avx._mm512_unpacklo_ps(c, d)), cast(avx._mm512_unpackhi_ps(c, d)));
    [
        cast(avx._mm512_unpacklo_pd(ab, cd)),
        cast(avx._mm512_unpackhi_pd(ab, cd)),
        cast(avx._mm512_unpacklo_pd(other_ab, other_cd)),
        cast(avx._mm512_unpackhi_pd(other_ab, other_cd)),
    ]
}

/// Transposes an 8 x 8 matrix of f32.
#[inline(always)]
pub(super) fn transpose_8x8_f32(unit: Avx2, [a, b, c, d, e, f, g, h]: [__m256; 8]) -> [__m256; 8] {
    let (left, right) =
        (transpose_4x4_f32_per_half(unit, [a, b, c, d]), transpose_4x4_f32_per_half(unit, [e, f, g, h]));
    let mut out = [a; 8];
    for k in 0..4 {
        out[k] = unit.avx._mm256_permute2f128_ps::<0x20>(left[k], right[k]);
        out[4 + k] = unit.avx._mm256_permute2f128_ps::<0x31>(left[k], right[k]);
    }
    out
}

/// Transposes the 4 x 4 matrix of f32 in each half of four registers.
#[inline(always)]
fn transpose_4x4_f32_per_half(unit: Avx2, [a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
    let avx = unit.avx;
    let (ab, other_ab) = (cast(avx._mm256_unpacklo_ps(a, b)), cast(avx._mm256_unpackhi_ps(a, b)));
    let (cd, other_cd) = (cast(avx._mm256_unpacklo_ps(c, d)), cast(avx._mm256_unpackhi_ps(c, d)));
    [
        cast(avx._mm256_unpacklo_pd(ab, cd)),
        cast(avx._mm256_unpackhi_pd(ab, cd)),
        cast(avx._mm256_unpacklo_pd(other_ab, other_cd)),
        cast(avx._mm256_unpackhi_pd(other_ab, other_cd)),
    ]
}

/// The first three columns of an 8 x 4 matrix of f64, whose rows are given in pairs: 0 and 4, 1 and 5, 2 and 6, 3 and 7.
#[inline(always)]
pub(super) fn first_three_columns_f64(unit: Avx512, [a, b, c, d]: [__m512d; 4]) -> [__m512d; 3] {
    const FIRST: [u64; 8] = [0, 1, 8, 9, 4, 5, 12, 13];
    const THIRD: [u64; 8] = [2, 3, 10, 11, 6, 7, 14, 15];
    let unit = unit.avx512f;
    let (even, odd) = (unit._mm512_unpacklo_pd(a, b), unit._mm512_unpackhi_pd(a, b));
    let (other_even, other_odd) = (unit._mm512_unpacklo_pd(c, d), unit._mm512_unpackhi_pd(c, d));
    [
        unit._mm512_permutex2var_pd(even, cast(FIRST), other_even),
        unit._mm512_permutex2var_pd(odd, cast(FIRST), other_odd),
        unit._mm512_permutex2var_pd(even, cast(THIRD), other_even),
    ]
}

/// Transposes an 8 x 8 matrix of f64.
#[inline(always)]
pub(super) fn transpose_8x8_f64(unit: Avx512, rows: [__m512d; 8]) -> [__m512d; 8] {
    let ([a, b, c, d, e, f, g, h], avx) = (rows, unit.avx512f);
    let even = [
        avx._mm512_unpacklo_pd(a, b),
        avx._mm512_unpacklo_pd(c, d),
        avx._mm512_unpacklo_pd(e, f),
        avx._mm512_unpacklo_pd(g, h),
    ];
    let odd = [
        avx._mm512_unpackhi_pd(a, b),
        avx._mm512_unpackhi_pd(c, d),
        avx._mm512_unpackhi_pd(e, f),
        avx._mm512_unpackhi_pd(g, h),
    ];
    let ([a, c, e, g], [b, d, f, h]) = (transpose_4x4_pairs(unit, even), transpose_4x4_pairs(unit, odd));
    [a, b, c, d, e, f, g, h]
}

/// Transposes a 4 x 4 matrix of pairs of f64.
#[inline(always)]
fn transpose_4x4_pairs(unit: Avx512, [a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
    let unit = unit.avx512f;
    let (low, high) =
        (unit._mm512_shuffle_f64x2::<0b01_00_01_00>(a, b), unit._mm512_shuffle_f64x2::<0b11_10_11_10>(a, b));
    let (other_low, other_high) =
        (unit._mm512_shuffle_f64x2::<0b01_00_01_00>(c, d), unit._mm512_shuffle_f64x2::<0b11_10_11_10>(c, d));
    [
        unit._mm512_shuffle_f64x2::<0b10_00_10_00>(low, other_low),
        unit._mm512_shuffle_f64x2::<0b11_01_11_01>(low, other_low),
        unit._mm512_shuffle_f64x2::<0b10_00_10_00>(high, other_high),
        unit._mm512_shuffle_f64x2::<0b11_01_11_01>(high, other_high),
    ]
}
