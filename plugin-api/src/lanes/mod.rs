//! Kernels written once for a scalar and for a vector register.
//!
//! A kernel is generic over [`Real`]. With `f64` it computes one element; with `Wide` or `SingleWide` (feature `lanes`) it computes one
//! element per lane of a vector register. Both do the same operations in the same order on each element and use no fused multiply-add, so
//! the bytes do not depend on the vector unit found at run time (`vector_unit().dispatch`).
//!
//! Everything between `dispatch` and the arithmetic must be inlined, or it is not compiled for the vector unit. Closures are not
//! always inlined, so kernels use none, except on rare paths ([`Real::map_lanes`]).

#[cfg(feature = "lanes")]
mod gather;
#[cfg(feature = "lanes")]
mod interleaved;
mod prefetch;
#[cfg(feature = "lanes")]
mod rows;
#[cfg(feature = "lanes")]
mod units;
mod vec3;
#[cfg(feature = "lanes")]
mod wide;
#[cfg(all(feature = "lanes", target_arch = "x86_64"))]
mod x86;

use core::ops::{Add, Div, Mul, Neg, Sub};
#[cfg(feature = "lanes")]
pub use gather::{NodeVectorsView, gather};
#[cfg(feature = "lanes")]
pub use interleaved::Interleaved;
pub use prefetch::prefetch;
#[cfg(feature = "lanes")]
pub use pulp;
#[cfg(feature = "lanes")]
pub use rows::{RowScalar, SplitBlock, add_block};
#[cfg(feature = "lanes")]
pub use units::{check_vector_unit, units, vector_unit};
pub use vec3::Vec3;
#[cfg(feature = "lanes")]
pub use wide::{MAX_LANES, MAX_SINGLE_LANES, SingleWide, Wide};

/// A real number, or one for each lane of a vector register; operations act lane by lane.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// `value` in every lane; the vector unit is that of `self`.
    fn splat(self, value: f64) -> Self;
    /// The least positive normal number of this precision, in every lane.
    fn min_positive(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// `less` where `self < other`, else `otherwise`; both are evaluated. A NaN is not less.
    fn if_less(self, other: Self, less: Self, otherwise: Self) -> Self;
    /// Whether any lane is below `value`.
    fn any_below(self, value: f64) -> bool;
    /// Applies a scalar function of `N` numbers to each lane. Slow: for lanes that need an algorithm with branches.
    fn map_lanes<const N: usize>(values: [Self; N], f: impl Fn([f64; N]) -> [f64; N]) -> [Self; N];

    /// The greater of both; `other` where either is NaN.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        other.if_less(self, self, other)
    }

    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        self.if_less(self.splat(0.0), -self, self)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn min_positive(self) -> Self {
        Self::MIN_POSITIVE
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn if_less(self, other: Self, less: Self, otherwise: Self) -> Self {
        if self < other { less } else { otherwise }
    }

    #[inline(always)]
    fn any_below(self, value: f64) -> bool {
        self < value
    }

    #[inline(always)]
    fn map_lanes<const N: usize>(values: [Self; N], f: impl Fn([f64; N]) -> [f64; N]) -> [Self; N] {
        f(values)
    }
}
