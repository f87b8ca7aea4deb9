//! Numbers eight at a time, in one precision or the other.

use crate::lanes::aligned::Lines;
use pulp::bytemuck::Pod;
use pulp::{Arch, Simd};
use std::ops::{Add, Mul, Sub};

/// Rows of a slice.
pub const LANES: usize = 8;
/// Numbers of the rows of a slice.
pub type Slice<T> = [T; LANES];

/// What vectors are made of.
pub trait Number: Pod + Default + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// Some of them in a register.
    type V<S: Simd>: Pod;

    /// Rounded, and without what is next to nothing.
    fn of(value: f64) -> Self;
    /// In double precision.
    fn exact(self) -> f64;
    /// The widest unit whose registers hold no more than a slice.
    fn arch() -> Arch;
    /// All of one number.
    fn all<S: Simd>(simd: S, value: Self) -> Self::V<S>;
    /// `a + b`
    fn plus<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// `a - b`
    fn minus<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// `a b`
    fn times<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
}

impl Number for f64 {
    type V<S: Simd> = S::f64s;

    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn exact(self) -> f64 {
        self
    }

    fn arch() -> Arch {
        Arch::new()
    }

    #[inline(always)]
    fn all<S: Simd>(simd: S, value: f64) -> S::f64s {
        simd.splat_f64s(value)
    }

    #[inline(always)]
    fn plus<S: Simd>(simd: S, a: S::f64s, b: S::f64s) -> S::f64s {
        simd.add_f64s(a, b)
    }

    #[inline(always)]
    fn minus<S: Simd>(simd: S, a: S::f64s, b: S::f64s) -> S::f64s {
        simd.sub_f64s(a, b)
    }

    #[inline(always)]
    fn times<S: Simd>(simd: S, a: S::f64s, b: S::f64s) -> S::f64s {
        simd.mul_f64s(a, b)
    }
}

/// What is smaller is zero: a polynomial takes it through smaller ones yet, and processors take a hundred times as long over the
/// smallest numbers.
const NOTHING: f64 = 1e-30;

impl Number for f32 {
    type V<S: Simd> = S::f32s;

    #[inline(always)]
    fn of(value: f64) -> Self {
        if value.abs() < NOTHING { 0.0 } else { value as Self }
    }

    #[inline(always)]
    fn exact(self) -> f64 {
        f64::from(self)
    }

    fn arch() -> Arch {
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = pulp::x86::V3::try_new() {
            return Arch::V3(unit);
        }
        Arch::Scalar
    }

    #[inline(always)]
    fn all<S: Simd>(simd: S, value: f32) -> S::f32s {
        simd.splat_f32s(value)
    }

    #[inline(always)]
    fn plus<S: Simd>(simd: S, a: S::f32s, b: S::f32s) -> S::f32s {
        simd.add_f32s(a, b)
    }

    #[inline(always)]
    fn minus<S: Simd>(simd: S, a: S::f32s, b: S::f32s) -> S::f32s {
        simd.sub_f32s(a, b)
    }

    #[inline(always)]
    fn times<S: Simd>(simd: S, a: S::f32s, b: S::f32s) -> S::f32s {
        simd.mul_f32s(a, b)
    }
}

/// Slices that lie where memory is read at once.
#[derive(Debug, Default)]
pub struct Slices<T>(Lines<T>);

impl<T: Copy + Default> Slices<T> {
    /// So many zeros.
    pub fn new(len: usize) -> Self {
        Self(Lines::new(len))
    }

    #[inline(always)]
    pub fn flat(&self) -> &[T] {
        self.0.flat()
    }

    #[inline(always)]
    pub fn flat_mut(&mut self) -> &mut [T] {
        self.0.flat_mut()
    }

    #[inline(always)]
    pub fn all(&self) -> &[Slice<T>] {
        self.flat().as_chunks().0
    }

    pub fn all_mut(&mut self) -> &mut [Slice<T>] {
        self.flat_mut().as_chunks_mut().0
    }
}
