//! Registers of single-precision numbers: [`pliant_plugin_api::lanes::Wide`] for f32.

use core::ops::{Add, Div, Mul, Neg, Sub};
use pliant_plugin_api::lanes::Real;
use pulp::{Simd, bytemuck};

/// The most lanes a [`WideSingle`] has on any vector unit.
pub(crate) const MAX_SINGLE_LANES: usize = 16;

/// A register of the vector unit `S`: one `f32` per lane.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(crate) struct WideSingle<S: Simd>(pub(crate) S::f32s, pub(crate) S);

impl<S: Simd> WideSingle<S> {
    /// The first numbers of a buffer, one per lane.
    #[inline(always)]
    pub(crate) fn load(simd: S, from: &[f32; MAX_SINGLE_LANES]) -> Self {
        Self(bytemuck::pod_read_unaligned(bytemuck::cast_slice(&from[..S::F32_LANES])), simd)
    }

    /// The lanes, followed by zeros on narrower vector units.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f32; MAX_SINGLE_LANES] {
        let mut lanes = [0.0; MAX_SINGLE_LANES];
        bytemuck::cast_slice_mut::<f32, u8>(&mut lanes[..S::F32_LANES]).copy_from_slice(bytemuck::bytes_of(&self.0));
        lanes
    }
}

/// Implements an arithmetic operator by an instruction of `pulp`.
macro_rules! operator {
    ($operator:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $operator for WideSingle<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.1.$simd(self.0, other.0), self.1)
            }
        }
    };
}
operator!(Add, add, add_f32s);
operator!(Sub, sub, sub_f32s);
operator!(Mul, mul, mul_f32s);
operator!(Div, div, div_f32s);

impl<S: Simd> Mul<f64> for WideSingle<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self * self.splat(other)
    }
}

impl<S: Simd> Neg for WideSingle<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.1.neg_f32s(self.0), self.1)
    }
}

impl<S: Simd> Real for WideSingle<S> {
    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self(self.1.splat_f32s(value as f32), self.1)
    }

    #[inline(always)]
    fn min_positive(self) -> Self {
        Self(self.1.splat_f32s(f32::MIN_POSITIVE), self.1)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.1.sqrt_f32s(self.0), self.1)
    }

    #[inline(always)]
    fn if_less(self, other: Self, less: Self, otherwise: Self) -> Self {
        Self(self.1.select_f32s(self.1.less_than_f32s(self.0, other.0), less.0, otherwise.0), self.1)
    }

    #[inline(always)]
    fn any_below(self, value: f64) -> bool {
        let below = self.1.less_than_f32s(self.0, self.1.splat_f32s(value as f32));
        self.1.first_true_m32s(below) < S::F32_LANES
    }

    #[cold]
    fn map_lanes<const N: usize>(values: [Self; N], f: impl Fn([f64; N]) -> [f64; N]) -> [Self; N] {
        let mut lanes = values.map(Self::to_array);
        for lane in 0..S::F32_LANES {
            let out = f(core::array::from_fn(|i| f64::from(lanes[i][lane])));
            (0..N).for_each(|i| lanes[i][lane] = out[i] as f32);
        }
        core::array::from_fn(|i| Self::load(values[i].1, &lanes[i]))
    }
}
