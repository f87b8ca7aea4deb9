//! Moves between the lanes of AVX2.

use core::arch::x86_64::__m256d;
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
