//! The matrix of a body in single precision, with the vectors of the conjugate gradient iterations.
//!
//! Blocks off the diagonal are those of [`Matrix`], rounded. In place of the diagonal blocks the sum D_i of the blocks of each row is stored,
//! and products are formed from differences: `y_i = D_i x_i + sum_j A_ij (x_j - x_i)`. A rigid translation is thus multiplied by the masses
//! alone, which rounding errors of the elastic blocks would otherwise exceed in a stiff body. The pattern decides the format: SELL-16 with
//! distances from the diagonal for regular meshes, else SELL-16 with column indices.

pub mod sell;
mod sell_columns;
pub mod update;

use super::algebra::{SingleBlock, Vec3};
use super::constraint::Constraint;
use super::lanes::Vectors;
use super::matrix::{Matrix, Values};
use super::threads::Pool;
use sell::SellDistances;
use sell::update::Update;
use sell_columns::SellColumns;
use std::ops::Range;
use update::round;

/// `scale A` in single precision, with two vectors of the conjugate gradient iteration: the search direction p and the sum of the steps.
#[derive(Debug, Default)]
pub struct F32Matrix {
    /// A power of two that brings the mean of the diagonal to about 1.
    scale: f64,
    /// Blocks for the coarse levels, by slot as in [`Matrix`], and one more, so that 16 numbers can be read from the start of any.
    values: Vec<SingleBlock>,
    /// `None` until the pattern is known.
    format: Option<Format>,
}

/// Storage format of the matrix.
#[derive(Debug)]
enum Format {
    /// SELL-16 with distances from the diagonal.
    Distances(SellDistances),
    /// SELL-16 with column indices.
    Columns(SellColumns),
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

    /// Blocks by slot, and one more, so that 16 numbers can be read from the start of any.
    pub fn values(&self) -> &[SingleBlock] {
        &self.values
    }

    /// Memory of the values and indices, bytes.
    pub fn bytes(&self) -> usize {
        let format = match &self.format {
            Some(Format::Distances(matrix)) => matrix.bytes(),
            Some(Format::Columns(matrix)) => matrix.bytes(),
            None => 0,
        };
        self.values.len() * size_of::<SingleBlock>() + format
    }

    /// Discards the format, for a matrix with another pattern.
    pub fn forget(&mut self) {
        self.format = None;
    }

    /// Loads the blocks of a matrix. Until [`F32Matrix::forget`] is called, all matrices must have the same pattern.
    pub fn update(&mut self, pool: &Pool, matrix: &Matrix) {
        let n = matrix.rows();
        let traces = pool.fold(0..n, &|_, rows: Range<usize>| {
            rows.map(|i| matrix.diagonal(i)).map(|block| block[0] + block[4] + block[8]).sum::<f64>()
        });
        let mean = traces / (3 * n) as f64;
        self.scale = if mean.is_normal() && mean > 0.0 { 1.0 / power_of_two(mean) } else { 1.0 };
        self.values.resize(matrix.blocks() + 1, [0.0; 9]);
        let format = self.format.get_or_insert_with(|| match SellDistances::new(n, matrix.pattern()) {
            Some(distances) => Format::Distances(distances),
            None => Format::Columns(SellColumns::new(n, matrix.pattern())),
        });
        match format {
            Format::Distances(format) => format.update(pool, matrix, self.scale),
            Format::Columns(format) => format.update(pool, matrix, self.scale),
        }
    }

    /// Sets the search direction and the sum of steps to zero, for a new inner solve.
    pub fn start(&mut self) {
        match &mut self.format {
            Some(Format::Distances(matrix)) => matrix.start(),
            Some(Format::Columns(matrix)) => matrix.start(),
            None => {}
        }
    }

    /// Adds `a p` to the sum of steps, then sets `p = h + beta p`. `h` is the preconditioned residual, by sixteen nodes.
    pub fn update_direction(&mut self, pool: &Pool, h: &[Vectors], a: f32, beta: f32) {
        match &mut self.format {
            Some(Format::Distances(matrix)) => matrix.update_direction(pool, h, a, beta),
            Some(Format::Columns(matrix)) => matrix.update_direction(pool, h, a, beta),
            None => {}
        }
    }

    /// Computes `scale A p`, which [`F32Matrix::update_residual`] uses. Returns `p . scale A p`.
    pub fn product(&mut self, pool: &Pool) -> f64 {
        match &mut self.format {
            Some(Format::Distances(matrix)) => matrix.product(pool),
            Some(Format::Columns(matrix)) => matrix.product(pool),
            None => 0.0,
        }
    }

    /// `out[k] = A x[k]` in double precision. `matrix` must be the one that was loaded last.
    pub fn exact_products<const K: usize>(
        &mut self,
        pool: &Pool,
        matrix: &Matrix,
        x: [&[Vec3]; K],
        out: [&mut [Vec3]; K],
    ) {
        match (&mut self.format, matrix.values()) {
            (Some(Format::Distances(distances)), Values::F32(blocks)) => {
                distances.exact_products(pool, blocks, 1.0 / self.scale, x, out);
            }
            _ => matrix.products(pool, x, out),
        }
    }

    /// `r -= a scale A p` with the last product, for the rows from `16 first` on, by sixteen.
    pub fn update_residual(&self, first: usize, a: f32, r: &mut [Vectors]) {
        match &self.format {
            Some(Format::Distances(matrix)) => matrix.update_residual(first, a, r),
            Some(Format::Columns(matrix)) => matrix.update_residual(first, a, r),
            None => {}
        }
    }

    /// Adds `scale` times the sum of steps to `x`, whose first row is `first`.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [Vec3]) {
        match &self.format {
            Some(Format::Distances(matrix)) => matrix.add_to(first, scale, x),
            Some(Format::Columns(matrix)) => matrix.add_to(first, scale, x),
            None => {}
        }
    }

    /// Loads the blocks in `slots` for the coarse levels; those of fixed nodes are set to zero.
    pub fn without_fixed(&mut self, pool: &Pool, matrix: &Matrix, constraints: &[Constraint], slots: Range<usize>) {
        round(pool, self.scale, matrix, slots.clone(), &mut self.values[slots.clone()]);
        let is_fixed = |i: usize| constraints[i] == Constraint::Fixed;
        for (i, slots) in matrix.rows_of(slots) {
            for slot in slots.filter(|slot| is_fixed(i) || is_fixed(matrix.column(*slot))) {
                self.values[slot] = [0.0; 9];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_of_fixed_nodes_are_zero_and_blocks_outside_the_slots_stay() {
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
            // Ranges that begin and end within rows.
            for slots in [0..all, 20..all - 30, 20..21, 7..7] {
                single.values.fill([7.0; 9]);
                single.without_fixed(&pool, &matrix, &constraints, slots.clone());
                for (i, row_slots) in matrix.rows_of(0..all) {
                    for slot in row_slots {
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
