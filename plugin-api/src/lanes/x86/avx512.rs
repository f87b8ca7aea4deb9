//! Moves between the lanes of AVX-512.

use core::arch::x86_64::{__m512, __m512d};
use pulp::bytemuck::cast;
use pulp::x86::V4 as Avx512;

/// Indices of component i of eight vectors among the numbers of the first two registers (0 to 15). A 0 stands for a lane that
/// [`THIRD`] fills.
const FIRST_TWO: [[u64; 8]; 3] = [[0, 3, 6, 9, 12, 15, 0, 0], [1, 4, 7, 10, 13, 0, 0, 0], [2, 5, 8, 11, 14, 0, 0, 0]];
/// Indices among those and the numbers of the third register (8 to 15).
const THIRD: [[u64; 8]; 3] = [[0, 1, 2, 3, 4, 5, 10, 13], [0, 1, 2, 3, 4, 8, 11, 14], [0, 1, 2, 3, 4, 9, 12, 15]];
/// The vector that each number of three registers belongs to.
const VECTOR: [[u64; 8]; 3] = [[0, 0, 0, 1, 1, 1, 2, 2], [2, 3, 3, 3, 4, 4, 4, 5], [5, 5, 6, 6, 6, 7, 7, 7]];

/// The components of eight vectors one behind the other.
#[inline(always)]
pub fn components(unit: Avx512, [p, q, r]: [__m512d; 3]) -> [__m512d; 3] {
    let (avx, mut components) = (unit.avx512f, [p; 3]);
    for i in 0..3 {
        let two = avx._mm512_permutex2var_pd(p, cast(FIRST_TWO[i]), q);
        components[i] = avx._mm512_permutex2var_pd(two, cast(THIRD[i]), r);
    }
    components
}

/// Each of eight numbers three times.
#[inline(always)]
pub fn thrice(unit: Avx512, numbers: __m512d) -> [__m512d; 3] {
    let mut thrice = [numbers; 3];
    for i in 0..3 {
        thrice[i] = unit.avx512f._mm512_permutexvar_pd(cast(VECTOR[i]), numbers);
    }
    thrice
}

/// The components of eight padded vectors.
#[inline(always)]
pub fn padded_components(unit: Avx512, vectors: [&[f64; 4]; 8]) -> [__m512d; 3] {
    let mut pairs = [cast([0.0; 8]); 4];
    for k in 0..4 {
        let low = unit.avx512f._mm512_castpd256_pd512(cast(*vectors[k]));
        pairs[k] = unit.avx512f._mm512_insertf64x4::<1>(low, cast(*vectors[k + 4]));
    }
    first_three_columns_f64(unit, pairs)
}

/// The first three columns of an 8 x 4 matrix of f64, whose rows are given in pairs: 0 and 4, 1 and 5, 2 and 6, 3 and 7.
#[inline(always)]
fn first_three_columns_f64(unit: Avx512, [a, b, c, d]: [__m512d; 4]) -> [__m512d; 3] {
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
pub fn transpose_8x8_f64(unit: Avx512, rows: [__m512d; 8]) -> [__m512d; 8] {
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

/// Transposes an 8 x 16 matrix of f32. Each result has two rows of eight: 0 and 4, 1 and 5, 2 and 6, 3 and 7, then 8 and 12, ...
#[inline(always)]
pub fn transpose_8x16_f32(unit: Avx512, [a, b, c, d, e, f, g, h]: [__m512; 8]) -> [__m512; 8] {
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

/// Two registers, rounded to one.
#[inline(always)]
pub fn round(unit: Avx512, [low, high]: [__m512d; 2]) -> __m512 {
    cast([unit.avx512f._mm512_cvtpd_ps(low), unit.avx512f._mm512_cvtpd_ps(high)])
}

/// The numbers at `places`.
#[inline(always)]
pub fn permute(unit: Avx512, numbers: __m512d, places: &[u32; 8]) -> __m512d {
    unit.avx512f._mm512_permutexvar_pd(unit.avx512f._mm512_cvtepu32_epi64(cast(*places)), numbers)
}
