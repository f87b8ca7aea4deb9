//! The loop of a product on irregular patterns ([`super`]).

use super::Band;
use crate::f32_matrix::sell::product::{DIRECT, TRANSPOSED, add, subtract};
use crate::lanes::{LANES, Lanes, Quad, Work, load, store};

/// Multiplies the rows of a band by the search direction.
pub struct Multiply<'a> {
    /// Rows that are multiplied, with the product they get.
    pub band: &'a mut Band,
    /// Search direction of all nodes.
    pub p: &'a [Quad],
}

impl Work for Multiply<'_> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let Band { first, start, column, values, diagonal, y, dot, .. } = self.band;
        y.fill([0.0; 4]);
        let x = &self.p[*first..*first + y.len()];
        let zero = unit.load(&[0.0; LANES]);
        let mut dots = zero;
        let mut blocks = values.flat().as_chunks::<LANES>().0.chunks_exact(9);
        for (slice, ends) in start.windows(2).enumerate() {
            let at = LANES * slice;
            let own = unit.planes(load(unit, x[at..].first_chunk().expect("vectors reach past the rows")));
            let mut sum = diagonal.times(unit, slice, own);
            for (column, block) in column[ends[0]..ends[1]].iter().zip(&mut blocks) {
                let [a, b, c] = unit.planes(gather(unit, x, column));
                let difference = [unit.sub(a, own[0]), unit.sub(b, own[1]), unit.sub(c, own[2])];
                add(unit, block, DIRECT, difference, &mut sum);
                // The block below the diagonal is the transpose, and its difference the negative.
                let mut other = [zero; 3];
                subtract(unit, block, TRANSPOSED, difference, &mut other);
                scatter_add(unit, y, column, unit.vectors(other));
            }
            let rows = y[at..].first_chunk_mut().expect("vectors reach past the rows");
            let [a, b, c] = unit.planes(load(unit, rows));
            // All earlier rows have been added to these.
            let sum = [unit.add(a, sum[0]), unit.add(b, sum[1]), unit.add(c, sum[2])];
            store(unit, rows, unit.vectors(sum));
            for c in 0..3 {
                dots = unit.fma(own[c], sum[c], dots);
            }
        }
        let end = LANES * (start.len() - 1);
        let mut rest = [0.0_f32; 4];
        for (x, y) in x[end..].iter().zip(&y[end..]) {
            for c in 0..4 {
                rest[c] += x[c] * y[c];
            }
        }
        *dot = unit.store(dots).iter().chain(&rest).map(|v| f64::from(*v)).sum();
    }
}

/// Gathers the vectors of the columns.
#[inline(always)]
fn gather<U: Lanes>(unit: U, x: &[Quad], column: &[u32; LANES]) -> [U::V; 4] {
    let mut vectors = [unit.load(&[0.0; LANES]); 4];
    for k in 0..4 {
        let [a, b, c, d] = [column[4 * k], column[4 * k + 1], column[4 * k + 2], column[4 * k + 3]];
        vectors[k] = unit.four([&x[a as usize], &x[b as usize], &x[c as usize], &x[d as usize]]);
    }
    vectors
}

/// Adds a vector to each of the columns, one after the other, as columns may be equal.
#[inline(always)]
fn scatter_add<U: Lanes>(unit: U, y: &mut [Quad], column: &[u32; LANES], vectors: [U::V; 4]) {
    for k in 0..4 {
        let four = unit.store(vectors[k]);
        for lane in 0..4 {
            let y = &mut y[column[4 * k + lane] as usize];
            for c in 0..4 {
                y[c] += four[4 * lane + c];
            }
        }
    }
}
