//! AVX2 with FMA, and AVX-512.

use super::{Entry, Lanes, Quad, Sixteen, TINY};
use pulp::x86::{V3, V4};
use pulp::{Simd, cast, f32x8, f32x16, f64x4, f64x8, u32x16};
use std::arch::x86_64::{__m256, __m512};

/// Places of each of four numbers, four times.
const EACH_FOUR: [[u32; 8]; 2] = [[0, 0, 0, 0, 1, 1, 1, 1], [2, 2, 2, 2, 3, 3, 3, 3]];

impl Lanes for V3 {
    type V = [f32x8; 2];
    type D = f64x4;
    const EXACT: usize = 4;

    #[inline(always)]
    fn load(self, from: &Sixteen) -> [f32x8; 2] {
        cast(*from)
    }

    #[inline(always)]
    fn store(self, v: [f32x8; 2]) -> Sixteen {
        cast(v)
    }

    #[inline(always)]
    fn add(self, a: [f32x8; 2], b: [f32x8; 2]) -> [f32x8; 2] {
        [self.add_f32s(a[0], b[0]), self.add_f32s(a[1], b[1])]
    }

    #[inline(always)]
    fn sub(self, a: [f32x8; 2], b: [f32x8; 2]) -> [f32x8; 2] {
        [self.sub_f32s(a[0], b[0]), self.sub_f32s(a[1], b[1])]
    }

    #[inline(always)]
    fn mul(self, a: [f32x8; 2], b: [f32x8; 2]) -> [f32x8; 2] {
        [self.mul_f32s(a[0], b[0]), self.mul_f32s(a[1], b[1])]
    }

    #[inline(always)]
    fn fma(self, a: [f32x8; 2], b: [f32x8; 2], c: [f32x8; 2]) -> [f32x8; 2] {
        [self.mul_add_f32s(a[0], b[0], c[0]), self.mul_add_f32s(a[1], b[1], c[1])]
    }

    #[inline(always)]
    fn fnma(self, a: [f32x8; 2], b: [f32x8; 2], c: [f32x8; 2]) -> [f32x8; 2] {
        let fma = self.fma;
        [
            cast(fma._mm256_fnmadd_ps(cast(a[0]), cast(b[0]), cast(c[0]))),
            cast(fma._mm256_fnmadd_ps(cast(a[1]), cast(b[1]), cast(c[1]))),
        ]
    }

    #[inline(always)]
    fn four(self, [a, b, c, d]: [&Quad; 4]) -> [f32x8; 2] {
        // In registers all the way: from memory they would have to wait until all have got there.
        let (avx, wide) =
            (self.avx, [self.avx._mm256_castps128_ps256(cast(*a)), self.avx._mm256_castps128_ps256(cast(*c))]);
        [cast(avx._mm256_insertf128_ps::<1>(wide[0], cast(*b))), cast(avx._mm256_insertf128_ps::<1>(wide[1], cast(*d)))]
    }

    #[inline(always)]
    fn each_four(self, numbers: &Quad) -> [f32x8; 2] {
        let wide = self.avx._mm256_castps128_ps256(cast(*numbers));
        EACH_FOUR.map(|at| cast(self.avx2._mm256_permutevar8x32_ps(wide, cast(at))))
    }

    #[inline(always)]
    fn sum_of_four(self, v: [f32x8; 2]) -> Quad {
        let (avx, two) = (self.avx, cast(self.add_f32s(v[0], v[1])));
        cast(self.sse._mm_add_ps(avx._mm256_castps256_ps128(two), avx._mm256_extractf128_ps::<1>(two)))
    }

    #[inline(always)]
    fn lookup(self, [low, high]: [[f32x8; 2]; 2], places: &[u8; 16]) -> [f32x8; 2] {
        let (avx, mut out) = (self.avx, low);
        let eights = cast::<_, [u64; 2]>(*places);
        for (out, eight) in out.iter_mut().zip(eights) {
            let at = self.avx2._mm256_cvtepu8_epi32(cast([eight, 0]));
            let [a, b, c, d] =
                [low[0], low[1], high[0], high[1]].map(|eight| self.avx2._mm256_permutevar8x32_ps(cast(eight), at));
            // Which eight of the thirty-two, by the two bits above those of the place in it.
            let (odd, second) =
                (cast(self.avx2._mm256_slli_epi32::<28>(at)), cast(self.avx2._mm256_slli_epi32::<27>(at)));
            let (first, last) = (avx._mm256_blendv_ps(a, b, odd), avx._mm256_blendv_ps(c, d, odd));
            *out = cast(avx._mm256_blendv_ps(first, last, second));
        }
        out
    }

    #[inline(always)]
    fn flush_denormals(self, mut v: [f32x8; 2]) -> [f32x8; 2] {
        for half in &mut v {
            let tiny = self.less_than_f32s(self.abs_f32s(*half), self.splat_f32s(TINY));
            *half = self.select_f32s(tiny, self.splat_f32s(0.0), *half);
        }
        v
    }

    #[inline(always)]
    fn exact(self, from: &[f32]) -> f64x4 {
        cast(self.avx._mm256_cvtps_pd(cast(*first::<f32, 4>(from))))
    }

    #[inline(always)]
    fn load_exact(self, from: &[f64]) -> f64x4 {
        cast(*first::<f64, 4>(from))
    }

    #[inline(always)]
    fn store_exact(self, v: f64x4, to: &mut [f64]) {
        to[..4].copy_from_slice(&cast::<_, [f64; 4]>(v));
    }

    #[inline(always)]
    fn add_exact(self, a: f64x4, b: f64x4) -> f64x4 {
        self.add_f64s(a, b)
    }

    #[inline(always)]
    fn sub_exact(self, a: f64x4, b: f64x4) -> f64x4 {
        self.sub_f64s(a, b)
    }

    #[inline(always)]
    fn add_product(self, a: f64x4, b: f64x4, c: f64x4) -> f64x4 {
        self.add_f64s(self.mul_f64s(a, b), c)
    }

    #[inline(always)]
    fn take_product(self, a: f64x4, b: f64x4, c: f64x4) -> f64x4 {
        self.sub_f64s(c, self.mul_f64s(a, b))
    }

    #[inline(always)]
    fn planes(self, vectors: [[f32x8; 2]; 4]) -> [[f32x8; 2]; 3] {
        let mut planes = [[cast([0.0_f32; 8]); 2]; 3];
        for half in 0..2 {
            let ([a, c], [b, d]) = (vectors[2 * half], vectors[2 * half + 1]);
            let (low, high) = (turned_halves(self, cast(a), cast(b)), turned_halves(self, cast(c), cast(d)));
            let avx = self.avx;
            let (xy, zw) = (avx._mm256_unpacklo_ps(low[0], low[1]), avx._mm256_unpackhi_ps(low[0], low[1]));
            let (other_xy, other_zw) =
                (avx._mm256_unpacklo_ps(high[0], high[1]), avx._mm256_unpackhi_ps(high[0], high[1]));
            planes[0][half] = cast(avx._mm256_shuffle_ps::<0x44>(xy, other_xy));
            planes[1][half] = cast(avx._mm256_shuffle_ps::<0xee>(xy, other_xy));
            planes[2][half] = cast(avx._mm256_shuffle_ps::<0x44>(zw, other_zw));
        }
        planes
    }

    #[inline(always)]
    fn vectors(self, planes: [[f32x8; 2]; 3]) -> [[f32x8; 2]; 4] {
        let (mut vectors, zero) = ([[cast([0.0_f32; 8]); 2]; 4], cast([0.0_f32; 8]));
        for half in 0..2 {
            let (x, y, z) = (cast(planes[0][half]), cast(planes[1][half]), cast(planes[2][half]));
            let avx = self.avx;
            let (xy, other_xy) = (avx._mm256_unpacklo_ps(x, y), avx._mm256_unpackhi_ps(x, y));
            let (zw, other_zw) = (avx._mm256_unpacklo_ps(z, zero), avx._mm256_unpackhi_ps(z, zero));
            let low = turned_halves(self, avx._mm256_shuffle_ps::<0x44>(xy, zw), avx._mm256_shuffle_ps::<0xee>(xy, zw));
            let high = turned_halves(
                self,
                avx._mm256_shuffle_ps::<0x44>(other_xy, other_zw),
                avx._mm256_shuffle_ps::<0xee>(other_xy, other_zw),
            );
            vectors[2 * half] = [cast(low[0]), cast(high[0])];
            vectors[2 * half + 1] = [cast(low[1]), cast(high[1])];
        }
        vectors
    }

    #[inline(always)]
    fn entries<T: Entry>(self, blocks: [&[T; 9]; 16], scale: f64) -> [[f32x8; 2]; 9] {
        let (mut all, mut last) = ([[self.splat_f32x8(0.0); 2]; 9], [[0.0; 8]; 2]);
        for half in 0..2 {
            let mut rows = [cast([0.0_f32; 8]); 8];
            for lane in 0..8 {
                let block = blocks[8 * half + lane];
                rows[lane] = cast(T::eight(self, block, scale));
                last[half][lane] = block[8].rounded(scale);
            }
            for (e, entries) in columns(self, rows).into_iter().enumerate() {
                all[e][half] = cast(entries);
            }
            all[8][half] = cast(last[half]);
        }
        all
    }
}

/// Eight rows become eight columns.
#[inline(always)]
fn columns(unit: V3, [a, b, c, d, e, f, g, h]: [__m256; 8]) -> [__m256; 8] {
    let (left, right) = (quarter_columns(unit, [a, b, c, d]), quarter_columns(unit, [e, f, g, h]));
    let mut out = [a; 8];
    for k in 0..4 {
        out[k] = unit.avx._mm256_permute2f128_ps::<0x20>(left[k], right[k]);
        out[k + 4] = unit.avx._mm256_permute2f128_ps::<0x31>(left[k], right[k]);
    }
    out
}

/// In each half, four rows become four columns.
#[inline(always)]
fn quarter_columns(unit: V3, [a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
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

#[inline(always)]
fn first<T, const N: usize>(from: &[T]) -> &[T; N] {
    from.first_chunk().expect("as many as registers take")
}

/// The first halves of both, and the second ones.
#[inline(always)]
fn turned_halves(unit: V3, a: __m256, b: __m256) -> [__m256; 2] {
    [unit.avx._mm256_permute2f128_ps::<0x20>(a, b), unit.avx._mm256_permute2f128_ps::<0x31>(a, b)]
}

/// First and second components of the first eight vectors of two registers, and the third ones.
const FIRST_TWO: u32x16 = u32x16(0, 4, 8, 12, 16, 20, 24, 28, 1, 5, 9, 13, 17, 21, 25, 29);
const THIRD: u32x16 = u32x16(2, 6, 10, 14, 18, 22, 26, 30, 2, 6, 10, 14, 18, 22, 26, 30);
/// Where the components of four vectors are in two planes, and what is third in another.
const PAIRS: [u32x16; 4] = [pairs(0), pairs(4), pairs(8), pairs(12)];
const WITH_THIRD: [u32x16; 4] = [with_third(0), with_third(4), with_third(8), with_third(12)];
/// Without what is behind a vector.
const THREE_OF_FOUR: u16 = 0b0111_0111_0111_0111;
/// Of pairs of quarters, the even and the odd ones.
const EVEN: u32x16 = u32x16(0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27);
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
    const EXACT: usize = 8;

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
