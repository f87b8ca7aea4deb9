//! AVX2 with FMA.

use super::{EACH_FOUR, first};
use crate::lanes::{Entry, Lanes, Quad, Sixteen, TINY};
use pulp::x86::V3;
use pulp::{Simd, cast, f32x8, f64x4};
use std::arch::x86_64::{__m256, __m256d};

impl Lanes for V3 {
    type V = [f32x8; 2];
    type F64Blocks = Self;
    type F32Blocks = Self;
    type D = f64x4;
    const EXACT: usize = 4;

    #[inline(always)]
    fn f64_blocks(self) -> Self {
        self
    }

    #[inline(always)]
    fn f32_blocks(self) -> Self {
        self
    }

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
    fn round(self, from: &[f64; 16]) -> [f32x8; 2] {
        let [a, b, c, d]: [__m256d; 4] = cast(*from);
        let four = |v| self.avx._mm256_cvtpd_ps(v);
        [cast([four(a), four(b)]), cast([four(c), four(d)])]
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

/// The first halves of both, and the second ones.
#[inline(always)]
fn turned_halves(unit: V3, a: __m256, b: __m256) -> [__m256; 2] {
    [unit.avx._mm256_permute2f128_ps::<0x20>(a, b), unit.avx._mm256_permute2f128_ps::<0x31>(a, b)]
}
