//! Blocks with AVX2 and AVX-512.

use crate::lanes::blocks::{BlockUnit, COLUMN, ENTRY, ROW};
use pulp::x86::{V3, V4};
use pulp::{Simd, cast, f32x8, f64x4, f64x8};
use std::arch::x86_64::{__m256d, __m512d};

impl BlockUnit<f64> for V3 {
    type Eight = [f64x4; 2];

    #[inline(always)]
    fn load_eight(self, from: &[f64; 8]) -> [f64x4; 2] {
        cast(*from)
    }

    #[inline(always)]
    fn load_eight_f32(self, from: &[f32; 8]) -> [f64x4; 2] {
        let [low, high]: [[f32; 4]; 2] = cast(*from);
        [cast(self.avx._mm256_cvtps_pd(cast(low))), cast(self.avx._mm256_cvtps_pd(cast(high)))]
    }

    #[inline(always)]
    fn store_eight(self, v: [f64x4; 2]) -> [f64; 8] {
        cast(v)
    }

    #[inline(always)]
    fn add_eight(self, a: [f64x4; 2], b: [f64x4; 2]) -> [f64x4; 2] {
        [self.add_f64s(a[0], b[0]), self.add_f64s(a[1], b[1])]
    }

    #[inline(always)]
    fn mul_eight(self, a: [f64x4; 2], b: [f64x4; 2]) -> [f64x4; 2] {
        [self.mul_f64s(a[0], b[0]), self.mul_f64s(a[1], b[1])]
    }

    #[inline(always)]
    fn at_rows(self, v: &[f64; 4]) -> [f64x4; 2] {
        let (avx2, v) = (self.avx2, cast(*v));
        [cast(avx2._mm256_permute4x64_pd::<0b01_00_00_00>(v)), cast(avx2._mm256_permute4x64_pd::<0b10_10_01_01>(v))]
    }

    #[inline(always)]
    fn at_columns(self, v: &[f64; 4]) -> [f64x4; 2] {
        let (avx2, v) = (self.avx2, cast(*v));
        [cast(avx2._mm256_permute4x64_pd::<0b00_10_01_00>(v)), cast(avx2._mm256_permute4x64_pd::<0b01_00_10_01>(v))]
    }

    #[inline(always)]
    fn at_entries(self, v: [f64x4; 2], transposed: usize) -> [f64x4; 2] {
        let ([low, high], avx2): ([__m256d; 2], _) = (cast(v), self.avx2);
        let mask = cast([0_u64.wrapping_sub(transposed as u64); 4]);
        // Entries 0 3 6 1 and 4 7 2 5: the third of each is in the other register.
        let turned = [low, high].map(|half| avx2._mm256_permute4x64_pd::<0b01_10_11_00>(half));
        let first = self.avx._mm256_blend_pd::<0b0100>(turned[0], turned[1]);
        let second = self.avx._mm256_blend_pd::<0b0100>(turned[1], turned[0]);
        [cast(self.avx._mm256_blendv_pd(low, first, mask)), cast(self.avx._mm256_blendv_pd(high, second, mask))]
    }
}

impl BlockUnit<f32> for V3 {
    type Eight = f32x8;

    #[inline(always)]
    fn load_eight(self, from: &[f32; 8]) -> f32x8 {
        cast(*from)
    }

    #[inline(always)]
    fn load_eight_f32(self, from: &[f32; 8]) -> f32x8 {
        cast(*from)
    }

    #[inline(always)]
    fn store_eight(self, v: f32x8) -> [f32; 8] {
        cast(v)
    }

    #[inline(always)]
    fn add_eight(self, a: f32x8, b: f32x8) -> f32x8 {
        self.add_f32s(a, b)
    }

    #[inline(always)]
    fn mul_eight(self, a: f32x8, b: f32x8) -> f32x8 {
        self.mul_f32s(a, b)
    }

    #[inline(always)]
    fn at_rows(self, v: &[f32; 4]) -> f32x8 {
        cast(self.avx2._mm256_permutevar8x32_ps(self.avx._mm256_castps128_ps256(cast(*v)), cast(ROW)))
    }

    #[inline(always)]
    fn at_columns(self, v: &[f32; 4]) -> f32x8 {
        cast(self.avx2._mm256_permutevar8x32_ps(self.avx._mm256_castps128_ps256(cast(*v)), cast(COLUMN)))
    }

    #[inline(always)]
    fn at_entries(self, v: f32x8, transposed: usize) -> f32x8 {
        cast(self.avx2._mm256_permutevar8x32_ps(cast(v), cast(ENTRY[transposed])))
    }
}

impl BlockUnit<f64> for V4 {
    type Eight = f64x8;

    #[inline(always)]
    fn load_eight(self, from: &[f64; 8]) -> f64x8 {
        cast(*from)
    }

    #[inline(always)]
    fn load_eight_f32(self, from: &[f32; 8]) -> f64x8 {
        cast(self.avx512f._mm512_cvtps_pd(cast(*from)))
    }

    #[inline(always)]
    fn store_eight(self, v: f64x8) -> [f64; 8] {
        cast(v)
    }

    #[inline(always)]
    fn add_eight(self, a: f64x8, b: f64x8) -> f64x8 {
        self.add_f64s(a, b)
    }

    #[inline(always)]
    fn mul_eight(self, a: f64x8, b: f64x8) -> f64x8 {
        self.mul_f64s(a, b)
    }

    #[inline(always)]
    fn at_rows(self, v: &[f64; 4]) -> f64x8 {
        permuted(self, self.avx512f._mm512_castpd256_pd512(cast(*v)), ROW)
    }

    #[inline(always)]
    fn at_columns(self, v: &[f64; 4]) -> f64x8 {
        permuted(self, self.avx512f._mm512_castpd256_pd512(cast(*v)), COLUMN)
    }

    #[inline(always)]
    fn at_entries(self, v: f64x8, transposed: usize) -> f64x8 {
        permuted(self, cast(v), ENTRY[transposed])
    }
}

#[inline(always)]
fn permuted(unit: V4, v: __m512d, places: [u32; 8]) -> f64x8 {
    cast(unit.avx512f._mm512_permutexvar_pd(unit.avx512f._mm512_cvtepu32_epi64(cast(places)), v))
}
