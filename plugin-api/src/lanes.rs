//! Numbers a kernel is written for: one, or as many as the vector unit takes at once.
//!
//! A kernel is written once, for [`Real`]. On `f64` it is the scalar path; on [`Wide`] each operation is that of all lanes. Both do the
//! same operations in the same order on each element, and there is no fused multiply-add, so bytes do not depend on the vector
//! unit found at run time (`pulp::Arch::new().dispatch`).
//!
//! What stands between a kernel and the vector unit has to be inlined into it, and closures are not always: kernels have none, but
//! where few elements go ([`Real::each`]).

use core::ops::{Add, Div, Mul, Neg, Sub};
pub use pulp;
use pulp::Simd;

/// See above.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// A constant, as many times as there are lanes.
    fn of(self, value: f64) -> Self;
    /// The least number above zero that all can tell from it.
    fn least(self) -> Self;
    /// Of each.
    fn sqrt(self) -> Self;
    /// `less` where `self < other`, else `not`.
    fn if_less(self, other: Self, less: Self, not: Self) -> Self;
    /// Whether any lane is below a value.
    fn any_below(self, value: f64) -> bool;
    /// What `f` makes of each lane.
    fn each<const N: usize>(of: [Self; N], f: impl Fn([f64; N]) -> [f64; N]) -> [Self; N];

    /// The greater one.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        other.if_less(self, self, other)
    }

    /// Without its sign.
    #[inline(always)]
    fn abs(self) -> Self {
        self.if_less(self.of(0.0), -self, self)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn of(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn least(self) -> Self {
        Self::MIN_POSITIVE
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn if_less(self, other: Self, less: Self, not: Self) -> Self {
        if self < other { less } else { not }
    }

    #[inline(always)]
    fn any_below(self, value: f64) -> bool {
        self < value
    }

    #[inline(always)]
    fn each<const N: usize>(of: [Self; N], f: impl Fn([f64; N]) -> [f64; N]) -> [Self; N] {
        f(of)
    }
}

/// As many numbers as `S` takes at once.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub struct Wide<S: Simd>(pub S::f64s, pub S);

/// Lanes there are at most.
pub const MOST_LANES: usize = 8;

impl<S: Simd> Wide<S> {
    /// The first numbers of a buffer.
    #[inline(always)]
    pub fn load(simd: S, from: &[f64]) -> Self {
        let bytes = pulp::bytemuck::cast_slice::<f64, u8>(&from[..S::F64_LANES]);
        Self(pulp::bytemuck::pod_read_unaligned(bytes), simd)
    }

    /// Numbers `e ..` of as many as there are elements; lanes past the end repeat the last one.
    #[inline(always)]
    pub fn read(simd: S, of: &[f64], e: usize) -> Self {
        if e + S::F64_LANES <= of.len() {
            return Self::load(simd, &of[e..]);
        }
        let mut lanes = [0.0; MOST_LANES];
        for lane in 0..S::F64_LANES {
            lanes[lane] = of[(e + lane).min(of.len() - 1)];
        }
        Self::load(simd, &lanes)
    }

    /// Its numbers to the beginning of a buffer.
    #[inline(always)]
    pub fn store(self, to: &mut [f64]) {
        let bytes = pulp::bytemuck::bytes_of(&self.0);
        pulp::bytemuck::cast_slice_mut::<f64, u8>(&mut to[..S::F64_LANES]).copy_from_slice(bytes);
    }

    /// Its numbers, and zeros where there are less lanes.
    #[inline(always)]
    pub fn lanes(self) -> [f64; MOST_LANES] {
        let mut lanes = [0.0; MOST_LANES];
        self.store(&mut lanes);
        lanes
    }
}

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
        self * self.of(other)
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
    fn of(self, value: f64) -> Self {
        Self(self.1.splat_f64s(value), self.1)
    }

    #[inline(always)]
    fn least(self) -> Self {
        self.of(f64::MIN_POSITIVE)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.1.sqrt_f64s(self.0), self.1)
    }

    #[inline(always)]
    fn if_less(self, other: Self, less: Self, not: Self) -> Self {
        Self(self.1.select_f64s(self.1.less_than_f64s(self.0, other.0), less.0, not.0), self.1)
    }

    #[inline(always)]
    fn any_below(self, value: f64) -> bool {
        let below = self.1.less_than_f64s(self.0, self.1.splat_f64s(value));
        self.1.first_true_m64s(below) < S::F64_LANES
    }

    #[cold]
    fn each<const N: usize>(of: [Self; N], f: impl Fn([f64; N]) -> [f64; N]) -> [Self; N] {
        let mut lanes = of.map(Self::lanes);
        for lane in 0..S::F64_LANES {
            let out = f(core::array::from_fn(|i| lanes[i][lane]));
            (0..N).for_each(|i| lanes[i][lane] = out[i]);
        }
        core::array::from_fn(|i| Self::load(of[i].1, &lanes[i]))
    }
}
