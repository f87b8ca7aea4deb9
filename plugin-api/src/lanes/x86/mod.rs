//! Moves between the lanes of AVX2 and AVX-512. Every function returns `None` on other vector units; nothing is computed here.

mod avx2;
mod avx512;

use super::Wide;
use core::any::Any;
use pulp::Simd;
use pulp::bytemuck::{Pod, Zeroable, cast};
use pulp::x86::{V3 as Avx2, V4 as Avx512};

/// `simd` as the vector unit `U`, if it is of that type. The compiler resolves this at compile time.
#[inline(always)]
fn downcast<S: Simd, U: Copy + 'static>(simd: S) -> Option<U> {
    (&simd as &dyn Any).downcast_ref().copied()
}

/// The registers themselves.
#[inline(always)]
fn registers<S: Simd, R: Pod, const N: usize>(numbers: [Wide<S>; N]) -> [R; N] {
    let mut registers = [R::zeroed(); N];
    for k in 0..N {
        registers[k] = cast(numbers[k].0);
    }
    registers
}

/// Registers as numbers of a vector unit.
#[inline(always)]
fn wide<S: Simd, R: Pod, const N: usize>(simd: S, registers: [R; N]) -> [Wide<S>; N] {
    let mut numbers = [Wide(S::f64s::zeroed(), simd); N];
    for k in 0..N {
        numbers[k].0 = cast(registers[k]);
    }
    numbers
}

/// The components of vectors one behind the other.
#[inline(always)]
pub(super) fn components<S: Simd>(simd: S, vectors: [Wide<S>; 3]) -> Option<[Wide<S>; 3]> {
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        return Some(wide(simd, avx512::components(unit, registers(vectors))));
    }
    let unit = downcast::<S, Avx2>(simd)?;
    Some(wide(simd, avx2::components(unit, registers(vectors))))
}

/// Each lane three times.
#[inline(always)]
pub(super) fn thrice<S: Simd>(simd: S, numbers: Wide<S>) -> Option<[Wide<S>; 3]> {
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        return Some(wide(simd, avx512::thrice(unit, cast(numbers.0))));
    }
    let unit = downcast::<S, Avx2>(simd)?;
    Some(wide(simd, avx2::thrice(unit, cast(numbers.0))))
}
