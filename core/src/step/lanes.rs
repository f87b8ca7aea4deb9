//! Sixteen numbers in single precision, in whatever vector unit there is.
//!
//! Operations are on each number by itself and never fused, so every unit gives the same bytes.

use pulp::{NullaryFnOnce, cast};
#[cfg(target_arch = "x86_64")]
use pulp::{
    Simd, f32x8, f32x16,
    x86::{V3, V4},
};

/// In memory.
pub type Sixteen = [f32; 16];

/// A vector unit.
pub trait Lanes: Copy {
    /// Sixteen numbers in its registers.
    type V: Copy;
    /// From memory.
    fn load(self, from: &Sixteen) -> Self::V;
    /// To memory.
    fn store(self, v: Self::V) -> Sixteen;
    /// `a + b`
    fn add(self, a: Self::V, b: Self::V) -> Self::V;
    /// `a - b`
    fn sub(self, a: Self::V, b: Self::V) -> Self::V;
    /// `a b`
    fn mul(self, a: Self::V, b: Self::V) -> Self::V;
}

/// Work that any vector unit can do.
pub trait Work {
    /// Does it.
    fn on(self, unit: impl Lanes);
}

/// Does `work` on the widest vector unit there is.
pub fn widest(work: impl Work) {
    match pulp::Arch::new() {
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V4(unit) => unit.vectorize(On { work, unit }),
        #[cfg(target_arch = "x86_64")]
        pulp::Arch::V3(unit) => unit.vectorize(On { work, unit }),
        _ => work.on(Plain),
    }
}

struct On<W, U> {
    work: W,
    unit: U,
}

impl<W: Work, U: Lanes> NullaryFnOnce for On<W, U> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.work.on(self.unit);
    }
}

/// No vector unit that is known here.
#[derive(Clone, Copy)]
pub struct Plain;

impl Lanes for Plain {
    type V = Sixteen;

    #[inline(always)]
    fn load(self, from: &Sixteen) -> Sixteen {
        *from
    }

    #[inline(always)]
    fn store(self, v: Sixteen) -> Sixteen {
        v
    }

    #[inline(always)]
    fn add(self, mut a: Sixteen, b: Sixteen) -> Sixteen {
        (0..16).for_each(|l| a[l] += b[l]);
        a
    }

    #[inline(always)]
    fn sub(self, mut a: Sixteen, b: Sixteen) -> Sixteen {
        (0..16).for_each(|l| a[l] -= b[l]);
        a
    }

    #[inline(always)]
    fn mul(self, mut a: Sixteen, b: Sixteen) -> Sixteen {
        (0..16).for_each(|l| a[l] *= b[l]);
        a
    }
}

#[cfg(target_arch = "x86_64")]
impl Lanes for V3 {
    type V = [f32x8; 2];

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
}

#[cfg(target_arch = "x86_64")]
impl Lanes for V4 {
    type V = f32x16;

    #[inline(always)]
    fn load(self, from: &Sixteen) -> f32x16 {
        cast(*from)
    }

    #[inline(always)]
    fn store(self, v: f32x16) -> Sixteen {
        cast(v)
    }

    #[inline(always)]
    fn add(self, a: f32x16, b: f32x16) -> f32x16 {
        self.add_f32s(a, b)
    }

    #[inline(always)]
    fn sub(self, a: f32x16, b: f32x16) -> f32x16 {
        self.sub_f32s(a, b)
    }

    #[inline(always)]
    fn mul(self, a: f32x16, b: f32x16) -> f32x16 {
        self.mul_f32s(a, b)
    }
}
