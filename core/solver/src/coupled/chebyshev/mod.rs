//! A fixed polynomial in a matrix that replaces its inverse: Chebyshev's iteration (Golub and Varga 1961) from zero, scaled by the diagonal.
//!
//! Each row has up to four entries off the diagonal. On a regular mesh rows of one kind have them at the same distances: sorted by kind, the
//! entries of eight rows are in consecutive columns, a lane of the vector unit is a row, and nothing is gathered. Other matrices are
//! multiplied row by row. No operation combines lanes, so every vector unit gives the same bytes; each row is computed by one thread, so any
//! number of threads does too.

mod rows;
mod slices;
mod term;
#[cfg(test)]
mod tests;
mod vectors;

use crate::threads::Pool;
use rows::{OffDiagonals, RowFormat, StoredRows};
use vectors::{Order, Vectors};

/// A polynomial in a symmetric matrix, which is stored scaled to a unit diagonal and with its rows reordered, and the vectors of the iteration.
#[derive(Debug, Default)]
pub struct Chebyshev {
    /// Bounds of the eigenvalues of the scaled matrix.
    spectrum: [f64; 2],
    /// Number of terms.
    terms: usize,
    /// Row of the given matrix at each place of the new order (n).
    row: Vec<u32>,
    /// Inverse of the diagonal at each place; 0 where the diagonal is 0 (n).
    inverse_diagonal: Vec<f64>,
    /// Place of each row in the new order (n).
    place: Vec<u32>,
    /// Columns of the entries off the diagonal.
    format: RowFormat,
    /// Values and vectors in double precision.
    double: Vectors<f64>,
    /// Vectors in single precision, from the first use on.
    single: Option<Vectors<f32>>,
}

impl Chebyshev {
    /// The polynomial of `terms` terms for a symmetric matrix with this diagonal and off-diagonal `entries` (both triangles), sorted by row and
    /// column, at most four in a row. The eigenvalues of the Jacobi-scaled matrix lie within `spectrum`. Rows with a zero on the diagonal give
    /// zero.
    pub fn new(diagonal: &[f64], entries: &[(u32, u32, f64)], spectrum: [f64; 2], terms: usize) -> Self {
        let entries = OffDiagonals::new(diagonal.len(), entries);
        let mut this = Self { spectrum, terms, ..Self::default() };
        this.set_order(entries.by_kind(), diagonal);
        match StoredRows::sell(&entries, diagonal, &this.row, &this.place) {
            Some(rows) => this.set_rows(rows),
            None => this.set_ellpack(&entries, diagonal),
        }
        this
    }

    /// Stores rows in the order of the matrix, with column indices.
    fn set_ellpack(&mut self, entries: &OffDiagonals<'_>, diagonal: &[f64]) {
        self.set_order((0..diagonal.len() as u32).collect(), diagonal);
        self.set_rows(StoredRows::ellpack(entries, diagonal));
    }

    /// Sets the order of rows: `row` is the row at each place.
    fn set_order(&mut self, row: Vec<u32>, diagonal: &[f64]) {
        self.place = vec![0; row.len()];
        for (place, row) in row.iter().enumerate() {
            self.place[*row as usize] = place as u32;
        }
        let inverse = |row: &u32| if diagonal[*row as usize] > 0.0 { 1.0 / diagonal[*row as usize] } else { 0.0 };
        self.inverse_diagonal = row.iter().map(inverse).collect();
        self.row = row;
    }

    /// Sets the entries off the diagonal.
    fn set_rows(&mut self, rows: StoredRows) {
        (self.format, self.double, self.single) = (rows.format, Vectors::new(self.row.len(), &rows.values), None);
    }

    /// `out = p(A) b` (n), computed in single precision if `single`.
    pub fn apply(&mut self, pool: &Pool, b: &[f64], out: &mut [f64], single: bool) {
        let Self { format, row, inverse_diagonal, place, double, .. } = self;
        let (order, factors) = (Order { format, row, inverse_diagonal, place }, factors(self.spectrum, self.terms));
        if single {
            let single = self.single.get_or_insert_with(|| Vectors::new(row.len(), double.value.flat()));
            single.apply(pool, order, factors, b, out);
        } else {
            double.apply(pool, order, factors, b, out);
        }
    }
}

/// Factors of a term of the iteration.
#[derive(Clone, Copy)]
pub struct Factors {
    /// Factor of the residual.
    alpha: f64,
    /// Factor of the previous step.
    beta: f64,
}

/// Factors of each term for eigenvalues between `low` and `high`.
fn factors([low, high]: [f64; 2], terms: usize) -> impl Iterator<Item = Factors> {
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
        Factors { alpha, beta }
    })
}
