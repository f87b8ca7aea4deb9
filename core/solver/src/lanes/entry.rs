//! Block entries in single or double precision, as they are loaded.

#[cfg(target_arch = "x86_64")]
use pulp::{
    cast, f32x8, f32x16,
    x86::{V3, V4},
};

/// An entry in single or double precision.
pub trait Entry: Copy + Default + Sync {
    /// The entry times `scale`, a power of two, rounded to single precision.
    fn rounded(self, scale: f64) -> f32;
    /// The entry in double precision.
    fn exact(self) -> f64;
    /// The first eight of two blocks, [`Entry::rounded`].
    #[cfg(target_arch = "x86_64")]
    fn eights(unit: V4, low: &[Self; 9], high: &[Self; 9], scale: f64) -> f32x16;
    /// The first eight of one block, [`Entry::rounded`].
    #[cfg(target_arch = "x86_64")]
    fn eight(unit: V3, block: &[Self; 9], scale: f64) -> f32x8;
}

impl Entry for f64 {
    #[inline(always)]
    fn rounded(self, scale: f64) -> f32 {
        (scale * self) as f32
    }

    #[inline(always)]
    fn exact(self) -> f64 {
        self
    }

    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn eights(unit: V4, low: &[f64; 9], high: &[f64; 9], scale: f64) -> f32x16 {
        let (avx, scale) = (unit.avx512f, unit.splat_f64x8(scale));
        let ([a, b, c, d, e, f, g, h, _], [i, j, k, l, m, n, o, p, _]) = (*low, *high);
        let low = avx._mm512_cvtpd_ps(cast(unit.mul_f64x8(scale, cast([a, b, c, d, e, f, g, h]))));
        let high = avx._mm512_cvtpd_ps(cast(unit.mul_f64x8(scale, cast([i, j, k, l, m, n, o, p]))));
        cast(unit.avx512dq._mm512_insertf32x8::<1>(avx._mm512_castps256_ps512(low), high))
    }

    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn eight(unit: V3, block: &[f64; 9], scale: f64) -> f32x8 {
        let ([a, b, c, d, e, f, g, h, _], scale) = (*block, unit.splat_f64x4(scale));
        let low = unit.avx._mm256_cvtpd_ps(cast(unit.mul_f64x4(scale, cast([a, b, c, d]))));
        cast([low, unit.avx._mm256_cvtpd_ps(cast(unit.mul_f64x4(scale, cast([e, f, g, h]))))])
    }
}

impl Entry for f32 {
    #[inline(always)]
    fn rounded(self, scale: f64) -> f32 {
        scale as f32 * self
    }

    #[inline(always)]
    fn exact(self) -> f64 {
        f64::from(self)
    }

    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn eights(unit: V4, low: &[f32; 9], high: &[f32; 9], scale: f64) -> f32x16 {
        let ([a, b, c, d, e, f, g, h, _], [i, j, k, l, m, n, o, p, _]) = (*low, *high);
        unit.mul_f32x16(unit.splat_f32x16(scale as f32), cast([a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p]))
    }

    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn eight(unit: V3, block: &[f32; 9], scale: f64) -> f32x8 {
        let [a, b, c, d, e, f, g, h, _] = *block;
        unit.mul_f32x8(unit.splat_f32x8(scale as f32), cast([a, b, c, d, e, f, g, h]))
    }
}
