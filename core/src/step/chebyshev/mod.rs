//! A fixed polynomial in a matrix in the place of its inverse (Chebyshev's iteration from zero, on rows over their diagonal).
//!
//! Each row has up to four partners. On a regular mesh rows of one kind have theirs at the same distances: put kind by kind, eight
//! rows have them side by side, a lane is a row and nothing is gathered. Elsewhere it goes row by row. Lanes never meet, so every
//! vector unit gives the same bytes, and each row is computed in one place, so does any number of threads.

mod rows;
mod slices;
mod term;
#[cfg(test)]
mod tests;

use super::pool::Pool;
use rows::{Partners, Rows};
use slices::{LANES, Slices};
use term::Term;

/// Slices in a piece of work for a thread.
const PIECE: usize = 128;

/// A matrix with a unit diagonal, rows by place, and vectors in its order.
#[derive(Debug, Default)]
pub struct Chebyshev {
    /// Least and greatest eigenvalue, at the widest.
    spectrum: [f64; 2],
    terms: usize,
    /// Row of the given matrix in each place, and over which diagonal; 0 where there is none.
    row: Vec<u32>,
    over: Vec<f64>,
    /// (n)
    place: Vec<u32>,
    rows: Rows,
    /// All between two slices of nothing.
    load: Slices,
    solution: Slices,
    before: Slices,
}

impl Chebyshev {
    /// Of a matrix with this diagonal, whose rows over their diagonal have eigenvalues within `spectrum`; `entries` are the others by
    /// row and column, rising, at most four a row. Rows without a diagonal are as if they were not there.
    pub fn new(diagonal: &[f64], entries: &[(u32, u32, f64)], spectrum: [f64; 2], terms: usize) -> Self {
        let n = diagonal.len();
        let partners = Partners::new(n, entries);
        let order = partners.by_kind();
        let mut this = Self { spectrum, terms, ..Self::default() };
        this.take_order(order, diagonal);
        match Rows::alike(&partners, diagonal, (&this.row, &this.place)) {
            Some(alike) => this.rows = alike,
            None => {
                this.take_order((0..n as u32).collect(), diagonal);
                this.rows = Rows::each(&partners, diagonal);
            }
        }
        let nothing = vec![[0.0; LANES]; n.div_ceil(LANES) + 2];
        (this.load, this.solution, this.before) = (Slices::new(&nothing), Slices::new(&nothing), Slices::new(&nothing));
        this
    }

    fn take_order(&mut self, row: Vec<u32>, diagonal: &[f64]) {
        self.place = vec![0; row.len()];
        for (place, row) in row.iter().enumerate() {
            self.place[*row as usize] = place as u32;
        }
        let over = |row: &u32| if diagonal[*row as usize] > 0.0 { 1.0 / diagonal[*row as usize] } else { 0.0 };
        self.over = row.iter().map(over).collect();
        self.row = row;
    }

    /// `out = p(A) b`
    pub fn apply(&mut self, pool: &Pool, b: &[f64], out: &mut [f64]) {
        let [low, high] = self.spectrum;
        let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
        let (mut alpha, n) = (1.0 / centre, self.row.len());
        let (row, over) = (&self.row, &self.over);
        let inner = 1..n.div_ceil(LANES) + 1;
        let vectors = (
            &mut self.load.all_mut()[inner.clone()],
            (&mut self.solution.all_mut()[inner.clone()], &mut self.before.all_mut()[inner.clone()]),
        );
        pool.pieces(vectors, PIECE, &|first, (load, (solution, before))| {
            let places = row[LANES * first..].iter().zip(&over[LANES * first..]);
            for ((load, solution), (row, over)) in
                load.as_flattened_mut().iter_mut().zip(solution.as_flattened_mut()).zip(places)
            {
                *load = b[*row as usize] * over;
                *solution = alpha * *load;
            }
            before.fill([0.0; LANES]);
        });
        for k in 1..self.terms {
            let beta = (if k == 1 { 0.5_f64.sqrt() } else { 0.5 } * half * alpha).powi(2);
            alpha = 1.0 / (centre - beta / alpha);
            let mut before = std::mem::take(&mut self.before);
            pool.pieces(&mut before.all_mut()[inner.clone()], PIECE, &|first, next| {
                pulp::Arch::new().dispatch(Term { of: self, first, next, factors: (alpha, beta) });
            });
            self.before = std::mem::replace(&mut self.solution, before);
        }
        let (place, solution) = (&self.place, &self.solution.flat()[LANES..]);
        pool.pieces(out, LANES * PIECE, &|first, out| {
            for (out, place) in out.iter_mut().zip(&place[first..]) {
                *out = solution[*place as usize];
            }
        });
    }
}
