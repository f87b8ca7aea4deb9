//! The matrix of a body in single precision, with the vectors of the conjugate gradient iterations.
//!
//! Blocks off the diagonal are those of [`Matrix`], rounded. The diagonal holds the sums of the rows, D, and a product is one of
//! differences, `y_i = D_i x_i + sum_j A_ij (x_j - x_i)`: so a rigid translation meets the masses alone, however stiff the body is, where
//! plain rounding would drown them. The pattern decides the format: SELL-16 with distances for regular meshes, else SELL-16 with columns.

mod csr;
pub mod sell;
pub mod update;

use super::algebra::{SingleBlock, Vec3};
use super::constraint::Constraint;
use super::lanes::Vectors;
use super::matrix::{Matrix, Values};
use super::threads::Pool;
use csr::CsrMatrix;
use sell::SellMatrix;
use sell::update::Update;
use std::ops::Range;
use update::round;

/// `scale A` in single precision, with the search direction p and the sum of steps along it.
#[derive(Debug, Default)]
pub struct F32Matrix {
    /// A power of two that brings the mean of the diagonal to about 1.
    scale: f64,
    /// Blocks for the coarse levels, by slot as in [`Matrix`], and one more that pads reads of 16 numbers.
    values: Vec<SingleBlock>,
    /// `None` until the pattern is known.
    format: Option<Format>,
}

/// Storage format, chosen by the pattern.
#[derive(Debug)]
enum Format {
    Sell16(SellMatrix),
    Csr(CsrMatrix),
}

/// The power of two at or below a number above zero.
pub fn power_of_two(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & (0x7ff << 52))
}

impl F32Matrix {
    /// `scale`, a power of two.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Blocks by slot, and one more that pads reads.
    pub fn values(&self) -> &[SingleBlock] {
        &self.values
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let format = match &self.format {
            Some(Format::Sell16(sell)) => sell.bytes(),
            Some(Format::Csr(each)) => each.bytes(),
            None => 0,
        };
        self.values.len() * size_of::<SingleBlock>() + format
    }

    /// Drops the format: the next matrix has another pattern.
    pub fn forget(&mut self) {
        self.format = None;
    }

    /// Loads the values of a matrix.
    pub fn update(&mut self, pool: &Pool, matrix: &Matrix) {
        let n = matrix.rows();
        let traces = pool.fold(0..n, &|_, rows: Range<usize>| {
            rows.map(|i| matrix.diagonal(i)).map(|block| block[0] + block[4] + block[8]).sum::<f64>()
        });
        let mean = traces / (3 * n) as f64;
        self.scale = if mean.is_normal() && mean > 0.0 { 1.0 / power_of_two(mean) } else { 1.0 };
        self.values.resize(matrix.blocks() + 1, [0.0; 9]);
        let format = self.format.get_or_insert_with(|| match SellMatrix::new(n, matrix.pattern()) {
            Some(sell) => Format::Sell16(sell),
            None => Format::Csr(CsrMatrix::new(n, matrix.pattern())),
        });
        match format {
            Format::Sell16(sell) => sell.update(pool, matrix, self.scale),
            Format::Csr(each) => each.update(pool, matrix, self.scale),
        }
    }

    /// Begins a correction: sets direction and sum to zero.
    pub fn start(&mut self) {
        match &mut self.format {
            Some(Format::Sell16(sell)) => sell.start(),
            Some(Format::Csr(each)) => each.start(),
            None => {}
        }
    }

    /// Steps by `a` along the direction p, then sets `p = h + beta p`.
    pub fn update_direction(&mut self, pool: &Pool, h: &[Vectors], a: f32, beta: f32) {
        match &mut self.format {
            Some(Format::Sell16(sell)) => sell.update_direction(pool, h, a, beta),
            Some(Format::Csr(each)) => each.update_direction(pool, h, a, beta),
            None => {}
        }
    }

    /// Computes `scale A p` for [`F32Matrix::update_residual`]. Returns `p . scale A p`.
    pub fn product(&mut self, pool: &Pool) -> f64 {
        match &mut self.format {
            Some(Format::Sell16(sell)) => sell.product(pool),
            Some(Format::Csr(each)) => each.product(pool),
            None => 0.0,
        }
    }

    /// `out[k] = A x[k]` in double precision, of the matrix that was loaded last.
    pub fn exact_products<const K: usize>(
        &mut self,
        pool: &Pool,
        matrix: &Matrix,
        x: [&[Vec3]; K],
        out: [&mut [Vec3]; K],
    ) {
        match (&mut self.format, matrix.values()) {
            (Some(Format::Sell16(sell)), Values::F32(of)) => {
                sell.exact_products(pool, of, 1.0 / self.scale, x, out);
            }
            _ => matrix.products(pool, x, out),
        }
    }

    /// `r -= a scale A p` of the last product, sixteens of rows from `first` on.
    pub fn update_residual(&self, first: usize, a: f32, r: &mut [Vectors]) {
        match &self.format {
            Some(Format::Sell16(sell)) => sell.update_residual(first, a, r),
            Some(Format::Csr(each)) => each.update_residual(first, a, r),
            None => {}
        }
    }

    /// Adds `scale` times the sum of steps to rows `first` on.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [Vec3]) {
        match &self.format {
            Some(Format::Sell16(sell)) => sell.add_to(first, scale, x),
            Some(Format::Csr(each)) => each.add_to(first, scale, x),
            None => {}
        }
    }

    /// Rounds the blocks in `slots`, with those of fixed nodes set to zero.
    pub fn without_fixed(&mut self, pool: &Pool, matrix: &Matrix, constraints: &[Constraint], slots: Range<usize>) {
        round(pool, self.scale, matrix, slots.clone(), &mut self.values[slots.clone()]);
        let is_fixed = |i: usize| constraints[i] == Constraint::Fixed;
        for (i, of_row) in matrix.rows_of(slots) {
            for slot in of_row.filter(|slot| is_fixed(i) || is_fixed(matrix.column(*slot))) {
                self.values[slot] = [0.0; 9];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_nodes_are_joined_to_nothing_and_other_blocks_stay() {
        let n = 40_u32;
        let mut matrix = Matrix::default();
        matrix.set_pattern(n as usize, |pair| (0..n - 5).for_each(|i| (1..6).for_each(|k| pair(i, i + k))));
        matrix.values_mut().iter_mut().enumerate().for_each(|(slot, block)| *block = [1.0 + slot as f64; 9]);
        let constraint = |i: usize| if i % 4 == 1 { Constraint::Fixed } else { Constraint::Free };
        let constraints: Vec<Constraint> = (0..n as usize).map(constraint).collect();
        for is_f32 in [false, true] {
            if is_f32 {
                matrix.round();
            }
            let (pool, mut single) = (Pool::new(1), F32Matrix::default());
            single.update(&pool, &matrix);
            let all = matrix.blocks();
            // From within a row to within another.
            for slots in [0..all, 20..all - 30, 20..21, 7..7] {
                single.values.fill([7.0; 9]);
                single.without_fixed(&pool, &matrix, &constraints, slots.clone());
                for (i, of_row) in matrix.rows_of(0..all) {
                    for slot in of_row {
                        let j = matrix.column(slot);
                        let exact = if j == i { *matrix.diagonal(i) } else { [1.0 + slot as f64; 9] };
                        let block =
                            if i % 4 == 1 || j % 4 == 1 { [0.0; 9] } else { exact.map(|v| (single.scale * v) as f32) };
                        assert_eq!(
                            single.values[slot],
                            if slots.contains(&slot) { block } else { [7.0; 9] },
                            "{i} {j}"
                        );
                    }
                }
            }
        }
    }
}
