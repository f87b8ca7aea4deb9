//! Moves between the lanes of AVX2 and AVX-512, and single additions. Every function returns `None` on vector units it is not for.

mod avx2;
mod avx512;

use super::{MAX_LANES, MAX_SINGLE_LANES, SingleWide, Wide};
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

/// The components of padded vectors, one for each lane.
#[inline(always)]
pub(super) fn padded_components<S: Simd>(simd: S, vectors: [&[f64; 4]; MAX_LANES]) -> Option<[Wide<S>; 3]> {
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        return Some(wide(simd, avx512::padded_components(unit, vectors)));
    }
    let unit = downcast::<S, Avx2>(simd)?;
    let ([a, b, c, d, ..], mut rows) = (vectors, [cast([0.0; 4]); 4]);
    for (row, vector) in rows.iter_mut().zip([a, b, c, d]) {
        *row = cast(*vector);
    }
    let [x, y, z, _] = avx2::transpose_4x4_f64(unit, rows);
    Some(wide(simd, [x, y, z]))
}

/// Eight numbers of each lane.
#[inline(always)]
pub(super) fn rows<S: Simd>(simd: S, numbers: [Wide<S>; 8]) -> Option<[[f64; 8]; MAX_LANES]> {
    let mut rows = [[0.0; 8]; MAX_LANES];
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        for (row, eight) in rows.iter_mut().zip(avx512::transpose_8x8_f64(unit, registers(numbers))) {
            *row = cast(eight);
        }
        return Some(rows);
    }
    let unit = downcast::<S, Avx2>(simd)?;
    let [a, b, c, d, e, f, g, h] = registers(numbers);
    for (half, four) in [[a, b, c, d], [e, f, g, h]].into_iter().enumerate() {
        for (row, four) in rows.iter_mut().zip(avx2::transpose_4x4_f64(unit, four)) {
            row[4 * half..4 * half + 4].copy_from_slice(&cast::<_, [f64; 4]>(four));
        }
    }
    Some(rows)
}

/// Two registers, rounded to one.
#[inline(always)]
pub(super) fn round<S: Simd>(simd: S, numbers: [Wide<S>; 2]) -> Option<SingleWide<S>> {
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        return Some(SingleWide(cast(avx512::round(unit, registers(numbers))), simd));
    }
    let unit = downcast::<S, Avx2>(simd)?;
    Some(SingleWide(cast(avx2::round(unit, registers(numbers))), simd))
}

/// [`rows`] in single precision.
#[inline(always)]
pub(super) fn single_rows<S: Simd>(simd: S, numbers: [SingleWide<S>; 8]) -> Option<[[f32; 8]; MAX_SINGLE_LANES]> {
    let mut rows = [[0.0; 8]; MAX_SINGLE_LANES];
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        let mut eight = [cast([0.0_f32; 16]); 8];
        for k in 0..8 {
            eight[k] = cast(numbers[k].0);
        }
        for (k, two) in avx512::transpose_8x16_f32(unit, eight).into_iter().enumerate() {
            let [low, high]: [[f32; 8]; 2] = cast(two);
            (rows[k % 4 + k / 4 * 8], rows[k % 4 + k / 4 * 8 + 4]) = (low, high);
        }
        return Some(rows);
    }
    let unit = downcast::<S, Avx2>(simd)?;
    let mut eight = [cast([0.0_f32; 8]); 8];
    for k in 0..8 {
        eight[k] = cast(numbers[k].0);
    }
    for (row, eight) in rows.iter_mut().zip(avx2::transpose_8x8_f32(unit, eight)) {
        *row = cast(eight);
    }
    Some(rows)
}

/// `to` plus the numbers of `eight` at `places`.
#[inline(always)]
pub(super) fn add_eight_f64<S: Simd>(simd: S, to: [f64; 8], eight: &[f64; 8], places: &[u32; 8]) -> Option<[f64; 8]> {
    let unit = downcast::<S, Avx512>(simd)?;
    Some(cast(unit.avx512f._mm512_add_pd(cast(to), avx512::permute(unit, cast(*eight), places))))
}

/// [`add_eight_f64`] in single precision.
#[inline(always)]
pub(super) fn add_eight_f32<S: Simd>(simd: S, to: [f32; 8], eight: &[f32; 8], places: &[u32; 8]) -> Option<[f32; 8]> {
    let unit = match downcast::<S, Avx512>(simd) {
        Some(unit) => *unit,
        None => downcast::<S, Avx2>(simd)?,
    };
    let moved = unit.avx2._mm256_permutevar8x32_ps(cast(*eight), cast(*places));
    Some(cast(unit.avx._mm256_add_ps(cast(to), moved)))
}
