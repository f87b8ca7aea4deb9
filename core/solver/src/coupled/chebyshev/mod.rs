//! A fixed polynomial in a matrix that replaces its inverse (Chebyshev's iteration from zero, on rows over their diagonal).
//!
//! Csr row has up to four partners. On a regular mesh rows of one kind have theirs at the same distances: put kind by kind, eight
//! rows have them side by side, a lane is a row and nothing is gathered. Elsewhere it goes row by row. Lanes never meet, so every
//! vector unit gives the same bytes, and each row is computed in one place, so does any number of threads.

mod rows;
mod slices;
mod term;
#[cfg(test)]
mod tests;
mod vectors;

use crate::threads::Pool;
use rows::{Partners, RowValues, Rows};
use vectors::{Order, Vectors};

/// A matrix scaled to a unit diagonal, with its rows in an order of their own, and the vectors of the iteration.
#[derive(Debug, Default)]
pub struct Chebyshev {
    /// Bounds of the eigenvalues.
    spectrum: [f64; 2],
    terms: usize,
    /// Row of the given matrix at each place (n).
    row: Vec<u32>,
    /// Inverse of the diagonal at each place; 0 without one (n).
    over: Vec<f64>,
    /// Place of each row (n).
    place: Vec<u32>,
    rows: Rows,
    double: Vectors<f64>,
    /// Vectors in single precision, from the first use on.
    single: Option<Vectors<f32>>,
}

impl Chebyshev {
    /// The polynomial of `terms` terms for a symmetric matrix with this diagonal and off-diagonal `entries` (row, column, value), sorted by row
    /// and column, at most four a row. The Jacobi-scaled matrix has its eigenvalues within `spectrum`. Rows without a diagonal are skipped.
    pub fn new(diagonal: &[f64], entries: &[(u32, u32, f64)], spectrum: [f64; 2], terms: usize) -> Self {
        let partners = Partners::new(diagonal.len(), entries);
        let mut this = Self { spectrum, terms, ..Self::default() };
        this.set_order(partners.by_kind(), diagonal);
        match Rows::banded(&partners, diagonal, &this.row, &this.place) {
            Some(banded) => this.set_rows(banded),
            None => this.set_csr(&partners, diagonal),
        }
        this
    }

    /// Stores rows in the order of the matrix.
    fn set_csr(&mut self, partners: &Partners<'_>, diagonal: &[f64]) {
        self.set_order((0..diagonal.len() as u32).collect(), diagonal);
        self.set_rows(Rows::csr(partners, diagonal));
    }

    fn set_order(&mut self, row: Vec<u32>, diagonal: &[f64]) {
        self.place = vec![0; row.len()];
        for (place, row) in row.iter().enumerate() {
            self.place[*row as usize] = place as u32;
        }
        let over = |row: &u32| if diagonal[*row as usize] > 0.0 { 1.0 / diagonal[*row as usize] } else { 0.0 };
        self.over = row.iter().map(over).collect();
        self.row = row;
    }

    fn set_rows(&mut self, rows: RowValues) {
        (self.rows, self.double, self.single) = (rows.rows, Vectors::new(self.row.len(), &rows.values), None);
    }

    /// `out = p(A) b`, in single precision if `single`.
    pub fn apply(&mut self, pool: &Pool, b: &[f64], out: &mut [f64], single: bool) {
        let Self { rows, row, over, place, double, .. } = self;
        let (order, factors) = (Order { rows, row, over, place }, factors(self.spectrum, self.terms));
        if single {
            let single = self.single.get_or_insert_with(|| Vectors::new(row.len(), double.value.flat()));
            single.apply(pool, order, factors, b, out);
        } else {
            double.apply(pool, order, factors, b, out);
        }
    }
}

/// Factors of the residual and of the previous step in each term.
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
