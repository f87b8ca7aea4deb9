//! One term of the iteration, on any vector unit.

use super::rows::Rows;
use super::slices::{LANES, Number, Slice, Slices};
use pulp::bytemuck::{bytes_of, cast_slice, cast_slice_mut, pod_read_unaligned};
use pulp::{Simd, WithSimd};

/// From the solution so far, and the one before in whose place it is put, the next one.
pub struct Term<'a, T> {
    pub rows: &'a Rows,
    pub value: &'a Slices<T>,
    pub load: &'a Slices<T>,
    pub solution: &'a Slices<T>,
    pub first: usize,
    pub next: &'a mut [Slice<T>],
    pub factors: (T, T),
}

impl<T: Number> WithSimd for Term<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { rows, value, load, solution, first, next, factors } = self;
        let (load, solution) = (&load.all()[1 + first..], solution.flat());
        match rows {
            Rows::Banded { start, partner } => {
                let value = value.all();
                for (at, (next, load)) in next.iter_mut().zip(load).enumerate() {
                    let (slice, own) = (first + at, LANES * (first + at + 1));
                    let all = start[slice]..start[slice + 1];
                    let (partner, value) = (&partner[all.clone()], &value[all]);
                    for part in (0..LANES).step_by(lanes::<S, T>()) {
                        let m = read::<S, T>(solution, own + part);
                        let mut sum = m;
                        if let (Ok(partner), Ok(value)) = (partner.try_into(), value.try_into()) {
                            // Most slices: without a loop, whose end is guessed wrong where the next one is longer.
                            sum = T::plus(simd, sum, four(simd, solution, partner, value, part));
                        } else {
                            let ((fours, rest), (of_four, of_rest)) = (partner.as_chunks(), value.as_chunks());
                            for (partner, value) in fours.iter().zip(of_four) {
                                sum = T::plus(simd, sum, four(simd, solution, partner, value, part));
                            }
                            for (&partner, value) in rest.iter().zip(of_rest) {
                                sum = T::plus(simd, sum, product(simd, solution, partner, value, part));
                            }
                        }
                        let rest = T::minus(simd, read::<S, T>(load, part), sum);
                        let change = T::minus(simd, m, read::<S, T>(next, part));
                        let turn = T::times(simd, T::all(simd, factors.1), change);
                        let step = T::plus(simd, T::times(simd, T::all(simd, factors.0), rest), turn);
                        let whole = T::plus(simd, m, step);
                        let bytes = cast_slice_mut::<T, u8>(&mut next[part..part + lanes::<S, T>()]);
                        bytes.copy_from_slice(bytes_of(&whole));
                    }
                }
            }
            Rows::Csr { partner } => {
                let (from, value) = (LANES * first, value.flat().as_chunks::<4>().0);
                let rows = next.as_flattened_mut().iter_mut().zip(load.as_flattened()).zip(&solution[LANES + from..]);
                for (((next, load), m), (at, v)) in rows.zip(partner[from..].iter().zip(&value[from..])) {
                    let sum = (v[0] * solution[at[0] as usize] + v[1] * solution[at[1] as usize])
                        + (v[2] * solution[at[2] as usize] + v[3] * solution[at[3] as usize]);
                    *next = *m + (factors.0 * (*load - (*m + sum)) + factors.1 * (*m - *next));
                }
            }
        }
    }
}

/// Values times what four partners have, in all.
#[inline(always)]
fn four<S: Simd, T: Number>(
    simd: S,
    solution: &[T],
    [a, b, c, d]: &[u32; 4],
    [u, v, w, x]: &[Slice<T>; 4],
    part: usize,
) -> T::V<S> {
    let one = T::plus(simd, product(simd, solution, *a, u, part), product(simd, solution, *b, v, part));
    let two = T::plus(simd, product(simd, solution, *c, w, part), product(simd, solution, *d, x, part));
    T::plus(simd, one, two)
}

/// Values times what partners have.
#[inline(always)]
fn product<S: Simd, T: Number>(simd: S, solution: &[T], partner: u32, value: &Slice<T>, part: usize) -> T::V<S> {
    T::times(simd, read::<S, T>(value, part), read::<S, T>(solution, partner as usize + part))
}

/// Numbers in a register.
#[inline(always)]
fn lanes<S: Simd, T: Number>() -> usize {
    size_of::<T::V<S>>() / size_of::<T>()
}

#[inline(always)]
fn read<S: Simd, T: Number>(from: &[T], at: usize) -> T::V<S> {
    pod_read_unaligned(cast_slice::<T, u8>(&from[at..at + lanes::<S, T>()]))
}
