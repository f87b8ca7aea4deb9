//! The vector unit of processors with AVX-512: sixteen numbers in one register.
//!
//! Constants of type `u32x16` are permutations of two registers a and b: a number below 16 is a lane of a, another one less 16 is a lane of b.

use super::{EACH_FOUR, first};
use crate::lanes::{Entry, Lanes, Quad, Sixteen, TINY};
use pulp::x86::{V3, V4};
use pulp::{Simd, cast, f32x16, f64x8, u32x16};
use std::arch::x86_64::{__m256, __m512, __m512d};

/// First components, then second components, of the eight padded vectors in two registers.
const FIRST_TWO: u32x16 = u32x16(0, 4, 8, 12, 16, 20, 24, 28, 1, 5, 9, 13, 17, 21, 25, 29);
/// Third components of the eight padded vectors in two registers, twice.
const THIRD: u32x16 = u32x16(2, 6, 10, 14, 18, 22, 26, 30, 2, 6, 10, 14, 18, 22, 26, 30);
/// Lanes of the first and second components of vectors 4 k to 4 k + 3 in the planes of these components, by k.
const PAIRS: [u32x16; 4] = [pairs(0), pairs(4), pairs(8), pairs(12)];
/// Lanes that add the third components, from their plane, to four vectors made by [`PAIRS`], by k.
const WITH_THIRD: [u32x16; 4] = [with_third(0), with_third(4), with_third(8), with_third(12)];
/// Mask of the components of four padded vectors, without the padding.
const THREE_OF_FOUR: u16 = 0b0111_0111_0111_0111;
/// The even quarters (four lanes each) of two registers, alternating between these.
const EVEN: u32x16 = u32x16(0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27);
/// The odd quarters (four lanes each) of two registers, alternating between these.
const ODD: u32x16 = u32x16(4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31);

const fn pairs(k: u32) -> u32x16 {
    u32x16(k, 16 + k, 0, 0, k + 1, 17 + k, 0, 0, k + 2, 18 + k, 0, 0, k + 3, 19 + k, 0, 0)
}

const fn with_third(k: u32) -> u32x16 {
    u32x16(0, 1, 16 + k, 0, 4, 5, 17 + k, 0, 8, 9, 18 + k, 0, 12, 13, 19 + k, 0)
}

impl Lanes for V4 {
    type V = f32x16;
    type D = f64x8;
    type F64Blocks = Self;
    type F32Blocks = V3;
    const EXACT: usize = 8;

    #[inline(always)]
    fn f64_blocks(self) -> Self {
        self
    }

    #[inline(always)]
    fn f32_blocks(self) -> V3 {
        *self
    }

    #[inline(always)]
    fn load(self, from: &Sixteen) -> f32x16 {
        cast(*from)
    }

    #[inline(always)]
    fn store(self, v: f32x16) -> Sixteen {
        cast(v)
    }

    #[inline(always)]
    fn add(self, a: f32x16, b: f32x16) -> f32x16 {
        self.add_f32s(a, b)
    }

    #[inline(always)]
    fn sub(self, a: f32x16, b: f32x16) -> f32x16 {
        self.sub_f32s(a, b)
    }

    #[inline(always)]
    fn mul(self, a: f32x16, b: f32x16) -> f32x16 {
        self.mul_f32s(a, b)
    }

    #[inline(always)]
    fn fma(self, a: f32x16, b: f32x16, c: f32x16) -> f32x16 {
        self.mul_add_f32s(a, b, c)
    }

    #[inline(always)]
    fn fnma(self, a: f32x16, b: f32x16, c: f32x16) -> f32x16 {
        cast(self.avx512f._mm512_fnmadd_ps(cast(a), cast(b), cast(c)))
    }

    #[inline(always)]
    fn four(self, [a, b, c, d]: [&Quad; 4]) -> f32x16 {
        let avx = self.avx512f;
        let two = avx._mm512_insertf32x4::<1>(avx._mm512_castps128_ps512(cast(*a)), cast(*b));
        cast(avx._mm512_insertf32x4::<3>(avx._mm512_insertf32x4::<2>(two, cast(*c)), cast(*d)))
    }

    #[inline(always)]
    fn each_four(self, numbers: &Quad) -> f32x16 {
        let avx = self.avx512f;
        cast(avx._mm512_permutexvar_ps(cast(EACH_FOUR), avx._mm512_castps128_ps512(cast(*numbers))))
    }

    #[inline(always)]
    fn sum_of_four(self, v: f32x16) -> Quad {
        let ([low, high], avx): ([__m256; 2], _) = (cast(v), self.avx);
        let two = avx._mm256_add_ps(low, high);
        cast(self.sse._mm_add_ps(avx._mm256_castps256_ps128(two), avx._mm256_extractf128_ps::<1>(two)))
    }

    #[inline(always)]
    fn lookup(self, [low, high]: [f32x16; 2], places: &[u8; 16]) -> f32x16 {
        let at = self.avx512f._mm512_cvtepu8_epi32(cast(*places));
        cast(self.avx512f._mm512_permutex2var_ps(cast(low), at, cast(high)))
    }

    #[inline(always)]
    fn flush_denormals(self, v: f32x16) -> f32x16 {
        let tiny = self.less_than_f32s(self.abs_f32s(v), self.splat_f32s(TINY));
        self.select_f32s(tiny, self.splat_f32s(0.0), v)
    }

    #[inline(always)]
    fn exact(self, from: &[f32]) -> f64x8 {
        cast(self.avx512f._mm512_cvtps_pd(cast(*first::<f32, 8>(from))))
    }

    #[inline(always)]
    fn load_exact(self, from: &[f64]) -> f64x8 {
        cast(*first::<f64, 8>(from))
    }

    #[inline(always)]
    fn store_exact(self, v: f64x8, to: &mut [f64]) {
        to[..8].copy_from_slice(&cast::<_, [f64; 8]>(v));
    }

    #[inline(always)]
    fn add_exact(self, a: f64x8, b: f64x8) -> f64x8 {
        self.add_f64s(a, b)
    }

    #[inline(always)]
    fn sub_exact(self, a: f64x8, b: f64x8) -> f64x8 {
        self.sub_f64s(a, b)
    }

    #[inline(always)]
    fn add_product(self, a: f64x8, b: f64x8, c: f64x8) -> f64x8 {
        self.add_f64s(self.mul_f64s(a, b), c)
    }

    #[inline(always)]
    fn take_product(self, a: f64x8, b: f64x8, c: f64x8) -> f64x8 {
        self.sub_f64s(c, self.mul_f64s(a, b))
    }

    #[inline(always)]
    fn round(self, from: &[f64; 16]) -> f32x16 {
        let [low, high]: [__m512d; 2] = cast(*from);
        cast([self.avx512f._mm512_cvtpd_ps(low), self.avx512f._mm512_cvtpd_ps(high)])
    }

    #[inline(always)]
    fn planes(self, vectors: [f32x16; 4]) -> [f32x16; 3] {
        let ([a, b, c, d], avx) = (vectors, self.avx512f);
        let (low, high) = (both(self, a, FIRST_TWO, b), both(self, c, FIRST_TWO, d));
        let (z, other_z) = (both(self, a, THIRD, b), both(self, c, THIRD, d));
        [
            cast(avx._mm512_shuffle_f32x4::<0x44>(low, high)),
            cast(avx._mm512_shuffle_f32x4::<0xee>(low, high)),
            cast(avx._mm512_shuffle_f32x4::<0x44>(z, other_z)),
        ]
    }

    #[inline(always)]
    fn vectors(self, [x, y, z]: [f32x16; 3]) -> [f32x16; 4] {
        let mut vectors = [z; 4];
        for k in 0..4 {
            let (pairs, third) = (both(self, x, PAIRS[k], y), cast(WITH_THIRD[k]));
            vectors[k] = cast(self.avx512f._mm512_maskz_permutex2var_ps(THREE_OF_FOUR, pairs, third, cast(z)));
        }
        vectors
    }

    #[inline(always)]
    fn entries<T: Entry>(self, blocks: [&[T; 9]; 16], scale: f64) -> [f32x16; 9] {
        let avx = self.avx512f;
        let (mut rows, mut last) = ([cast(self.splat_f32x16(0.0)); 8], [0.0; 16]);
        for lane in 0..8 {
            let (low, high) = (blocks[lane], blocks[lane + 8]);
            rows[lane] = cast(T::eights(self, low, high, scale));
            (last[lane], last[lane + 8]) = (low[8].rounded(scale), high[8].rounded(scale));
        }
        let mut all = [cast(last); 9];
        let (four, other_four) = (
            quarters(self, [rows[0], rows[1], rows[2], rows[3]]),
            quarters(self, [rows[4], rows[5], rows[6], rows[7]]),
        );
        for e in 0..4 {
            all[e] = cast(avx._mm512_permutex2var_ps(four[e], cast(EVEN), other_four[e]));
            all[e + 4] = cast(avx._mm512_permutex2var_ps(four[e], cast(ODD), other_four[e]));
        }
        all
    }
}

#[inline(always)]
fn both(unit: V4, a: f32x16, places: u32x16, b: f32x16) -> __m512 {
    unit.avx512f._mm512_permutex2var_ps(cast(a), cast(places), cast(b))
}

/// In each quarter, four rows become four columns.
#[inline(always)]
fn quarters(unit: V4, [a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
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
