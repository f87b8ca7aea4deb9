//! What the iteration goes through, in one precision or the other.

use super::rows::Rows;
use super::slices::{LANES, Number, Slices};
use super::term::Term;
use crate::threads::Pool;

/// Slices in a piece of work for a thread.
const PIECE: usize = 128;

/// Values of a matrix, and vectors by place.
#[derive(Debug, Default)]
pub struct Vectors<T> {
    /// Of partners, over the diagonal of the row: as many for a slice or a row as there are.
    pub value: Slices<T>,
    /// All between two slices of nothing.
    pub load: Slices<T>,
    pub solution: Slices<T>,
    pub before: Slices<T>,
}

impl<T: Number> Vectors<T> {
    /// Of `n` rows.
    pub fn new(n: usize, values: &[f64]) -> Self {
        let mut value = Slices::new(values.len());
        for (to, from) in value.flat_mut().iter_mut().zip(values) {
            *to = T::of(*from);
        }
        let nothing = || Slices::new(LANES * (n.div_ceil(LANES) + 2));
        Self { value, load: nothing(), solution: nothing(), before: nothing() }
    }

    /// `out = p(A) b`, for rows at these places over these diagonals, with the factors of each term in turn.
    pub fn apply(
        &mut self,
        pool: &Pool,
        (rows, row, place): (&Rows, (&[u32], &[f64]), &[u32]),
        mut factors: impl Iterator<Item = [f64; 2]>,
        (b, out): (&[f64], &mut [f64]),
    ) {
        let inner = 1..row.0.len().div_ceil(LANES) + 1;
        let alpha = factors.next().map_or(0.0, |[alpha, _]| alpha);
        let vectors = (
            &mut self.load.all_mut()[inner.clone()],
            (&mut self.solution.all_mut()[inner.clone()], &mut self.before.all_mut()[inner.clone()]),
        );
        pool.pieces(vectors, PIECE, &|first, (load, (solution, before))| {
            let places = row.0[LANES * first..].iter().zip(&row.1[LANES * first..]);
            let rows = load.as_flattened_mut().iter_mut().zip(solution.as_flattened_mut());
            for ((load, solution), (row, over)) in rows.zip(places) {
                let value = b[*row as usize] * over;
                (*load, *solution) = (T::of(value), T::of(alpha * value));
            }
            before.fill([T::default(); LANES]);
        });
        for [alpha, beta] in factors {
            let Self { value, load, solution, before } = self;
            pool.pieces(&mut before.all_mut()[inner.clone()], PIECE, &|first, next| {
                let factors = (T::of(alpha), T::of(beta));
                T::arch().dispatch(Term { rows, value, load, solution, first, next, factors });
            });
            std::mem::swap(solution, before);
        }
        let solution = &self.solution.flat()[LANES..];
        pool.pieces(out, LANES * PIECE, &|first, out| {
            for (out, place) in out.iter_mut().zip(&place[first..]) {
                *out = solution[*place as usize].exact();
            }
        });
    }
}
