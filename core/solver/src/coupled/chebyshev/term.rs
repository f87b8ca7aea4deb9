//! The loop of one term of the iteration, for any vector unit.

use super::rows::RowFormat;
use super::slices::{LANES, Number, Slice, Slices};
use pulp::bytemuck::{bytes_of, cast_slice, cast_slice_mut, pod_read_unaligned};
use pulp::{Simd, WithSimd};

/// Computes the next iterate `x + alpha (b - A x) + beta (x - before)` of some slices from the iterates x and before, in the place of before.
pub struct Term<'a, T> {
    /// Columns of the entries off the diagonal.
    pub format: &'a RowFormat,
    /// Entries over the diagonal of their rows, in the order of the columns.
    pub value: &'a Slices<T>,
    /// Right side b over the diagonal, with a slice of zeros before and after.
    pub load: &'a Slices<T>,
    /// The iterate x, with a slice of zeros before and after.
    pub solution: &'a Slices<T>,
    /// The first slice that is computed.
    pub first: usize,
    /// The previous iterate, which becomes the next one.
    pub next: &'a mut [Slice<T>],
    /// Factor of the residual.
    pub alpha: T,
    /// Factor of the previous step.
    pub beta: T,
}

impl<T: Number> WithSimd for Term<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { format, value, load, solution, first, next, alpha, beta } = self;
        let (load, solution) = (&load.all()[1 + first..], solution.flat());
        match format {
            RowFormat::Sell { start, column } => {
                let value = value.all();
                for (at, (next, load)) in next.iter_mut().zip(load).enumerate() {
                    let (slice, own) = (first + at, LANES * (first + at + 1));
                    let all = start[slice]..start[slice + 1];
                    let (column, value) = (&column[all.clone()], &value[all]);
                    for part in (0..LANES).step_by(lanes::<S, T>()) {
                        let x = read::<S, T>(solution, own + part);
                        let mut sum = x;
                        if let (Ok(column), Ok(value)) = (column.try_into(), value.try_into()) {
                            // Most slices have four distances. Without a loop no branch is mispredicted at its end.
                            sum = T::plus(simd, sum, four(simd, solution, column, value, part));
                        } else {
                            let ((columns, rest), (values, rest_values)) = (column.as_chunks(), value.as_chunks());
                            for (column, value) in columns.iter().zip(values) {
                                sum = T::plus(simd, sum, four(simd, solution, column, value, part));
                            }
                            for (&column, value) in rest.iter().zip(rest_values) {
                                sum = T::plus(simd, sum, product(simd, solution, column, value, part));
                            }
                        }
                        let residual = T::minus(simd, read::<S, T>(load, part), sum);
                        let last_step = T::minus(simd, x, read::<S, T>(next, part));
                        let momentum = T::times(simd, T::all(simd, beta), last_step);
                        let step = T::plus(simd, T::times(simd, T::all(simd, alpha), residual), momentum);
                        let sum = T::plus(simd, x, step);
                        let bytes = cast_slice_mut::<T, u8>(&mut next[part..part + lanes::<S, T>()]);
                        bytes.copy_from_slice(bytes_of(&sum));
                    }
                }
            }
            RowFormat::Ellpack { column } => {
                let (from, value) = (LANES * first, value.flat().as_chunks::<4>().0);
                let rows = next.as_flattened_mut().iter_mut().zip(load.as_flattened()).zip(&solution[LANES + from..]);
                for (((next, load), x), (at, v)) in rows.zip(column[from..].iter().zip(&value[from..])) {
                    let sum = (v[0] * solution[at[0] as usize] + v[1] * solution[at[1] as usize])
                        + (v[2] * solution[at[2] as usize] + v[3] * solution[at[3] as usize]);
                    *next = *x + (alpha * (*load - (*x + sum)) + beta * (*x - *next));
                }
            }
        }
    }
}

/// Sum of the products of the entries at four distances, for the rows of a register from row `part` of the slice on.
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

/// Product of the entries at one distance and their columns, for the rows of a register from row `part` of the slice on.
#[inline(always)]
fn product<S: Simd, T: Number>(simd: S, solution: &[T], column: u32, value: &Slice<T>, part: usize) -> T::V<S> {
    T::times(simd, read::<S, T>(value, part), read::<S, T>(solution, column as usize + part))
}

/// Number of numbers in a register.
#[inline(always)]
fn lanes<S: Simd, T: Number>() -> usize {
    size_of::<T::V<S>>() / size_of::<T>()
}

/// Reads a register from number `at` on.
#[inline(always)]
fn read<S: Simd, T: Number>(from: &[T], at: usize) -> T::V<S> {
    pod_read_unaligned(cast_slice::<T, u8>(&from[at..at + lanes::<S, T>()]))
}
