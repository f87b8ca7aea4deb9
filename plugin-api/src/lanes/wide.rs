//! Registers of numbers in double and in single precision.

use super::Real;
use core::ops::{Add, Div, Mul, Neg, Sub};
use pulp::Simd;

/// The most lanes a [`Wide`] has on any vector unit.
pub const MAX_LANES: usize = 8;
/// The most lanes a [`SingleWide`] has on any vector unit.
pub const MAX_SINGLE_LANES: usize = 16;

/// Defines the registers of a precision: type, number, `pulp`'s type and number of lanes, the most lanes, and `pulp`'s operations.
macro_rules! registers {
    (
        $(#[$doc:meta])*
        $wide:ident, $number:ident, $register:ident, $lanes:ident, $max:ident,
        [$add:ident, $sub:ident, $mul:ident, $div:ident, $neg:ident, $sqrt:ident],
        [$splat:ident, $less:ident, $select:ident, $first_true:ident]
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        #[repr(align(64))]
        pub struct $wide<S: Simd>(pub S::$register, pub S);

        impl<S: Simd> $wide<S> {
            /// The first numbers of a buffer, one per lane.
            ///
            /// # Panics
            /// If the buffer has fewer numbers than there are lanes.
            #[inline(always)]
            pub fn load(simd: S, from: &[$number]) -> Self {
                let bytes = pulp::bytemuck::cast_slice::<$number, u8>(&from[..S::$lanes]);
                Self(pulp::bytemuck::pod_read_unaligned(bytes), simd)
            }

            /// The numbers of elements `e, e + 1, ..`; lanes past the end of `values` repeat the last number.
            #[inline(always)]
            pub fn load_clamped(simd: S, values: &[$number], e: usize) -> Self {
                if e + S::$lanes <= values.len() {
                    return Self::load(simd, &values[e..]);
                }
                let mut lanes = [0.0; $max];
                for lane in 0..S::$lanes {
                    lanes[lane] = values[(e + lane).min(values.len() - 1)];
                }
                Self::load(simd, &lanes)
            }

            /// Writes the lanes to the beginning of a buffer.
            ///
            /// # Panics
            /// If the buffer is shorter than the number of lanes.
            #[inline(always)]
            pub fn store(self, to: &mut [$number]) {
                let bytes = pulp::bytemuck::bytes_of(&self.0);
                pulp::bytemuck::cast_slice_mut::<$number, u8>(&mut to[..S::$lanes]).copy_from_slice(bytes);
            }

            /// The lanes, followed by zeros on narrower vector units.
            #[inline(always)]
            pub fn to_array(self) -> [$number; $max] {
                let mut lanes = [0.0; $max];
                self.store(&mut lanes);
                lanes
            }
        }

        operator!($wide, Add, add, $add);
        operator!($wide, Sub, sub, $sub);
        operator!($wide, Mul, mul, $mul);
        operator!($wide, Div, div, $div);

        impl<S: Simd> Mul<f64> for $wide<S> {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: f64) -> Self {
                self * self.splat(other)
            }
        }

        impl<S: Simd> Neg for $wide<S> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(self.1.$neg(self.0), self.1)
            }
        }

        impl<S: Simd> Real for $wide<S> {
            #[inline(always)]
            fn splat(self, value: f64) -> Self {
                Self(self.1.$splat(value as $number), self.1)
            }

            #[inline(always)]
            fn min_positive(self) -> Self {
                Self(self.1.$splat($number::MIN_POSITIVE), self.1)
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.1.$sqrt(self.0), self.1)
            }

            #[inline(always)]
            fn if_less(self, other: Self, less: Self, otherwise: Self) -> Self {
                Self(self.1.$select(self.1.$less(self.0, other.0), less.0, otherwise.0), self.1)
            }

            #[inline(always)]
            fn any_below(self, value: f64) -> bool {
                let below = self.1.$less(self.0, self.1.$splat(value as $number));
                self.1.$first_true(below) < S::$lanes
            }

            #[cold]
            fn map_lanes<const N: usize>(values: [Self; N], f: impl Fn([f64; N]) -> [f64; N]) -> [Self; N] {
                let mut lanes = values.map(Self::to_array);
                for lane in 0..S::$lanes {
                    let out = f(core::array::from_fn(|i| f64::from(lanes[i][lane])));
                    (0..N).for_each(|i| lanes[i][lane] = out[i] as $number);
                }
                core::array::from_fn(|i| Self::load(values[i].1, &lanes[i]))
            }
        }
    };
}

/// Implements an arithmetic operator by an instruction of `pulp`.
macro_rules! operator {
    ($wide:ident, $operator:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $operator for $wide<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.1.$simd(self.0, other.0), self.1)
            }
        }
    };
}

registers!(
    /// A register of the vector unit `S`: one `f64` per lane.
    Wide, f64, f64s, F64_LANES, MAX_LANES,
    [add_f64s, sub_f64s, mul_f64s, div_f64s, neg_f64s, sqrt_f64s],
    [splat_f64s, less_than_f64s, select_f64s, first_true_m64s]
);
registers!(
    /// A register of the vector unit `S` in single precision: one `f32` per lane.
    SingleWide, f32, f32s, F32_LANES, MAX_SINGLE_LANES,
    [add_f32s, sub_f32s, mul_f32s, div_f32s, neg_f32s, sqrt_f32s],
    [splat_f32s, less_than_f32s, select_f32s, first_true_m32s]
);
