//! Vectors of slices of eight numbers, in single or double precision.

use crate::lanes::aligned::Lines;
use crate::lanes::arch_of_256_bits;
use pliant_plugin_api::lanes::vector_unit;
use pulp::bytemuck::Pod;
use pulp::{Arch, Simd};
use std::ops::{Add, Mul, Sub};

/// Rows of a slice.
pub const LANES: usize = 8;
/// A number for each row of a slice.
pub type Slice<T> = [T; LANES];

/// A precision: `f64` or `f32`, with operations on vector registers.
pub trait Number: Pod + Default + Send + Sync + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> {
    /// A vector register.
    type V<S: Simd>: Pod;

    /// Rounds to this precision; `f32` sets numbers below 1e-30 to zero.
    fn of(value: f64) -> Self;
    /// The number in double precision.
    fn exact(self) -> f64;
    /// The widest vector unit whose registers hold at most a slice.
    fn arch() -> Arch;
    /// A register filled with one number.
    fn all<S: Simd>(simd: S, value: Self) -> Self::V<S>;
    /// `a + b`.
    fn plus<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// `a - b`.
    fn minus<S: Simd>(simd: S, a: Self::V<S>, b: Self::V<S>) -> Self::V<S>;
    /// `a b`.
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
        vector_unit()
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

/// Numbers below this are set to zero in single precision: the terms of a polynomial make them smaller still, and processors take a hundred
/// times as long for denormal numbers.
const TINY: f64 = 1e-30;

impl Number for f32 {
    type V<S: Simd> = S::f32s;

    #[inline(always)]
    fn of(value: f64) -> Self {
        if value.abs() < TINY { 0.0 } else { value as Self }
    }

    #[inline(always)]
    fn exact(self) -> f64 {
        f64::from(self)
    }

    fn arch() -> Arch {
        arch_of_256_bits()
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

/// Slices at addresses aligned to cache lines.
#[derive(Debug, Default)]
pub struct Slices<T>(Lines<T>);

impl<T: Copy + Default> Slices<T> {
    /// A vector of `len` zeros, divided into slices.
    pub fn new(len: usize) -> Self {
        Self(Lines::new(len))
    }

    /// All numbers, in the order of the vector.
    #[inline(always)]
    pub fn flat(&self) -> &[T] {
        self.0.flat()
    }

    /// All numbers, mutable.
    #[inline(always)]
    pub fn flat_mut(&mut self) -> &mut [T] {
        self.0.flat_mut()
    }

    /// All slices, in the order of the vector.
    #[inline(always)]
    pub fn all(&self) -> &[Slice<T>] {
        self.flat().as_chunks().0
    }

    /// All slices, mutable.
    pub fn all_mut(&mut self) -> &mut [Slice<T>] {
        self.flat_mut().as_chunks_mut().0
    }
}
