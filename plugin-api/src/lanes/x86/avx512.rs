//! Moves between the lanes of AVX-512.

use core::arch::x86_64::__m512d;
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
