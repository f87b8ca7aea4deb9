//! Moves between the lanes of AVX2.

use core::arch::x86_64::{__m256, __m256d};
use pulp::bytemuck::cast;
use pulp::x86::V3 as Avx2;

/// The components of four vectors one behind the other.
#[inline(always)]
pub fn components(unit: Avx2, [p, q, r]: [__m256d; 3]) -> [__m256d; 3] {
    let avx = unit.avx;
    let xy = avx._mm256_permute2f128_pd::<0x30>(p, q);
    let zx = avx._mm256_permute2f128_pd::<0x21>(p, r);
    let yz = avx._mm256_permute2f128_pd::<0x30>(q, r);
    [
        avx._mm256_shuffle_pd::<0b1010>(xy, zx),
        avx._mm256_shuffle_pd::<0b0101>(xy, yz),
        avx._mm256_shuffle_pd::<0b1010>(zx, yz),
    ]
}

/// Each of four numbers three times.
#[inline(always)]
pub fn thrice(unit: Avx2, numbers: __m256d) -> [__m256d; 3] {
    let avx2 = unit.avx2;
    [
        avx2._mm256_permute4x64_pd::<0b01_00_00_00>(numbers),
        avx2._mm256_permute4x64_pd::<0b10_10_01_01>(numbers),
        avx2._mm256_permute4x64_pd::<0b11_11_11_10>(numbers),
    ]
}

/// Transposes a 4 x 4 matrix of f64.
#[inline(always)]
pub fn transpose_4x4_f64(unit: Avx2, rows: [__m256d; 4]) -> [__m256d; 4] {
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

/// Transposes an 8 x 8 matrix of f32.
#[inline(always)]
pub fn transpose_8x8_f32(unit: Avx2, [a, b, c, d, e, f, g, h]: [__m256; 8]) -> [__m256; 8] {
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

/// Two registers, rounded to one.
#[inline(always)]
pub fn round(unit: Avx2, [low, high]: [__m256d; 2]) -> __m256 {
    cast([unit.avx._mm256_cvtpd_ps(low), unit.avx._mm256_cvtpd_ps(high)])
}
