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
mod vectors;

use crate::threads::Pool;
use rows::{Partners, Rows};
use vectors::Vectors;

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
    double: Vectors<f64>,
    /// From the first time it was asked for on.
    single: Option<Vectors<f32>>,
}

impl Chebyshev {
    /// Of a matrix with this diagonal, whose rows over their diagonal have eigenvalues within `spectrum`; `entries` are the others by
    /// row and column, rising, at most four a row. Rows without a diagonal are as if they were not there.
    pub fn new(diagonal: &[f64], entries: &[(u32, u32, f64)], spectrum: [f64; 2], terms: usize) -> Self {
        let partners = Partners::new(diagonal.len(), entries);
        let mut this = Self { spectrum, terms, ..Self::default() };
        this.take_order(partners.by_kind(), diagonal);
        match Rows::alike(&partners, diagonal, (&this.row, &this.place)) {
            Some(alike) => this.take_rows(alike),
            None => this.take_each(&partners, diagonal),
        }
        this
    }

    /// Row by row, in the order of the matrix.
    fn take_each(&mut self, partners: &Partners<'_>, diagonal: &[f64]) {
        self.take_order((0..diagonal.len() as u32).collect(), diagonal);
        self.take_rows(Rows::each(partners, diagonal));
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

    fn take_rows(&mut self, (rows, values): (Rows, Vec<f64>)) {
        (self.rows, self.double, self.single) = (rows, Vectors::new(self.row.len(), &values), None);
    }

    /// `out = p(A) b`; in single precision, if that will do.
    pub fn apply(&mut self, pool: &Pool, b: &[f64], out: &mut [f64], single: bool) {
        let Self { rows, row, over, place, double, .. } = self;
        let (of, factors) = ((&*rows, (&row[..], &over[..]), &place[..]), factors(self.spectrum, self.terms));
        if single {
            let single = self.single.get_or_insert_with(|| Vectors::new(row.len(), double.value.flat()));
            single.apply(pool, of, factors, (b, out));
        } else {
            double.apply(pool, of, factors, (b, out));
        }
    }
}

/// What each term takes of what is left, and of the step before.
fn factors([low, high]: [f64; 2], terms: usize) -> impl Iterator<Item = [f64; 2]> {
    let (centre, half) = (0.5 * (high + low), 0.5 * (high - low));
    let mut alpha = 1.0 / centre;
    (0..terms.max(1)).map(move |k| {
        let beta = match k {
            0 => 0.0,
            1 => 0.5 * (half * alpha).powi(2),
            _ => (0.5 * half * alpha).powi(2),
        };
        if k > 0 {
            alpha = 1.0 / (centre - beta / alpha);
        }
        [alpha, beta]
    })
}
