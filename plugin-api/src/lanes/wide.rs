//! Registers of double-precision numbers.

use super::Real;
use core::ops::{Add, Div, Mul, Neg, Sub};
use pulp::Simd;

/// A register of the vector unit `S`: one `f64` per lane.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Wide<S: Simd>(pub S::f64s, pub S);

/// The most lanes a [`Wide`] has on any vector unit.
pub const MAX_LANES: usize = 8;

impl<S: Simd> Wide<S> {
    /// The first numbers of a buffer, one per lane.
    ///
    /// # Panics
    /// If the buffer has fewer numbers than there are lanes.
    #[inline(always)]
    pub fn load(simd: S, from: &[f64]) -> Self {
        let bytes = pulp::bytemuck::cast_slice::<f64, u8>(&from[..S::F64_LANES]);
        Self(pulp::bytemuck::pod_read_unaligned(bytes), simd)
    }

    /// The numbers of elements `e, e + 1, ..`; lanes past the end of `values` repeat the last number.
    #[inline(always)]
    pub fn load_clamped(simd: S, values: &[f64], e: usize) -> Self {
        if e + S::F64_LANES <= values.len() {
            return Self::load(simd, &values[e..]);
        }
        let mut lanes = [0.0; MAX_LANES];
        for lane in 0..S::F64_LANES {
            lanes[lane] = values[(e + lane).min(values.len() - 1)];
        }
        Self::load(simd, &lanes)
    }

    /// Writes the lanes to the beginning of a buffer.
    ///
    /// # Panics
    /// If the buffer is shorter than the number of lanes.
    #[inline(always)]
    pub fn store(self, to: &mut [f64]) {
        let bytes = pulp::bytemuck::bytes_of(&self.0);
        pulp::bytemuck::cast_slice_mut::<f64, u8>(&mut to[..S::F64_LANES]).copy_from_slice(bytes);
    }

    /// The lanes, followed by zeros on narrower vector units.
    #[inline(always)]
    pub fn to_array(self) -> [f64; MAX_LANES] {
        let mut lanes = [0.0; MAX_LANES];
        self.store(&mut lanes);
        lanes
    }
}

/// Implements an arithmetic operator by an instruction of `pulp`.
macro_rules! operator {
    ($operator:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $operator for Wide<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.1.$simd(self.0, other.0), self.1)
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Mul<f64> for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self * self.splat(other)
    }
}

impl<S: Simd> Neg for Wide<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.1.neg_f64s(self.0), self.1)
    }
}

impl<S: Simd> Real for Wide<S> {
    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self(self.1.splat_f64s(value), self.1)
    }

    #[inline(always)]
    fn min_positive(self) -> Self {
        self.splat(f64::MIN_POSITIVE)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.1.sqrt_f64s(self.0), self.1)
    }

    #[inline(always)]
    fn if_less(self, other: Self, less: Self, otherwise: Self) -> Self {
        Self(self.1.select_f64s(self.1.less_than_f64s(self.0, other.0), less.0, otherwise.0), self.1)
    }

    #[inline(always)]
    fn any_below(self, value: f64) -> bool {
        let below = self.1.less_than_f64s(self.0, self.1.splat_f64s(value));
        self.1.first_true_m64s(below) < S::F64_LANES
    }

    #[cold]
    fn map_lanes<const N: usize>(values: [Self; N], f: impl Fn([f64; N]) -> [f64; N]) -> [Self; N] {
        let mut lanes = values.map(Self::to_array);
        for lane in 0..S::F64_LANES {
            let out = f(core::array::from_fn(|i| lanes[i][lane]));
            (0..N).for_each(|i| lanes[i][lane] = out[i]);
        }
        core::array::from_fn(|i| Self::load(values[i].1, &lanes[i]))
    }
}
