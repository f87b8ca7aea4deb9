//! The iteration and its vectors, in single or double precision.

use super::Factors;
use super::rows::RowFormat;
use super::slices::{LANES, Number, Slices};
use super::term::Term;
use crate::threads::Pool;

/// Fewest slices in a chunk of work for a thread.
const CHUNK: usize = 128;

/// Values of the matrix and vectors of the iteration, in the new order of rows.
#[derive(Debug, Default)]
pub struct Vectors<T> {
    /// Off-diagonal entries over the diagonal of their row.
    pub value: Slices<T>,
    /// Right side over the diagonal. This and the next vectors have a slice of zeros before and after.
    pub load: Slices<T>,
    /// The solution so far.
    pub solution: Slices<T>,
    /// The previous iterate.
    pub before: Slices<T>,
}

/// The reordered matrix without values.
#[derive(Clone, Copy)]
pub struct Order<'a> {
    /// Columns of the entries off the diagonal.
    pub format: &'a RowFormat,
    /// Row of the matrix at each place (n).
    pub row: &'a [u32],
    /// Inverse of the diagonal at each place (n).
    pub inverse_diagonal: &'a [f64],
    /// Place of each row (n).
    pub place: &'a [u32],
}

impl<T: Number> Vectors<T> {
    /// Vectors for `n` rows whose entries have the given values.
    pub fn new(n: usize, values: &[f64]) -> Self {
        let mut value = Slices::new(values.len());
        for (to, from) in value.flat_mut().iter_mut().zip(values) {
            *to = T::of(*from);
        }
        let zeros = || Slices::new(LANES * (n.div_ceil(LANES) + 2));
        Self { value, load: zeros(), solution: zeros(), before: zeros() }
    }

    /// `out = p(A) b` (n) with the factors of each term.
    pub fn apply(
        &mut self,
        pool: &Pool,
        order: Order<'_>,
        mut factors: impl Iterator<Item = Factors>,
        b: &[f64],
        out: &mut [f64],
    ) {
        let Order { format, row, inverse_diagonal, place } = order;
        let inner = 1..row.len().div_ceil(LANES) + 1;
        let alpha = factors.next().map_or(0.0, |factors| factors.alpha);
        let vectors = (
            &mut self.load.all_mut()[inner.clone()],
            (&mut self.solution.all_mut()[inner.clone()], &mut self.before.all_mut()[inner.clone()]),
        );
        pool.par_chunks(vectors, CHUNK, &|first, (load, (solution, before))| {
            let places = row[LANES * first..].iter().zip(&inverse_diagonal[LANES * first..]);
            let rows = load.as_flattened_mut().iter_mut().zip(solution.as_flattened_mut());
            for ((load, solution), (row, inverse)) in rows.zip(places) {
                let value = b[*row as usize] * inverse;
                (*load, *solution) = (T::of(value), T::of(alpha * value));
            }
            before.fill([T::default(); LANES]);
        });
        for Factors { alpha, beta } in factors {
            let Self { value, load, solution, before } = self;
            pool.par_chunks(&mut before.all_mut()[inner.clone()], CHUNK, &|first, next| {
                let (alpha, beta) = (T::of(alpha), T::of(beta));
                T::arch().dispatch(Term { format, value, load, solution, first, next, alpha, beta });
            });
            std::mem::swap(solution, before);
        }
        let solution = &self.solution.flat()[LANES..];
        pool.par_chunks(out, LANES * CHUNK, &|first, out| {
            for (out, place) in out.iter_mut().zip(&place[first..]) {
                *out = solution[*place as usize].exact();
            }
        });
    }
}
