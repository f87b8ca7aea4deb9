//! The matrix of a body in single precision, for the iterations of a solve, and the vectors it is multiplied
//! with.
//!
//! Blocks off the diagonal are those of [`Matrix`], rounded. On the diagonal stands what the others leave of it, and the product
//! is one of differences, `y_i = D_i x_i + sum_j A_ij (x_j - x_i)`: so a motion of the whole costs what its masses say, however
//! stiff the body is, where plain rounding would drown them.

mod each;
pub mod sliced;
pub mod update;

use super::algebra::{SingleBlock, Vec3};
use super::constraint::Constraint;
use super::lanes::Vectors;
use super::matrix::{Matrix, Values};
use super::threads::Pool;
use each::Each;
use sliced::Sliced;
use sliced::update::Update;
use std::ops::Range;
use update::round;

/// `scale A`, and how far a descent with it has come.
#[derive(Debug, Default)]
pub struct Single {
    /// A power of two that brings the mean of the diagonal to about 1.
    scale: f64,
    /// What coarse levels are made of, as in [`Matrix`], and one more that is never used: blocks are read 16 numbers at a time.
    values: Vec<SingleBlock>,
    /// `None` until the pattern is known.
    descent: Option<Descent>,
}

/// Where the pattern decides how to multiply.
#[derive(Debug)]
enum Descent {
    Alike(Sliced),
    Each(Each),
}

/// The power of two at or below a number above zero.
pub fn power_of_two(value: f64) -> f64 {
    f64::from_bits(value.to_bits() & (0x7ff << 52))
}

impl Single {
    /// `scale`
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Blocks, and one more.
    pub fn values(&self) -> &[SingleBlock] {
        &self.values
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        let descent = match &self.descent {
            Some(Descent::Alike(sliced)) => sliced.bytes(),
            Some(Descent::Each(each)) => each.bytes(),
            None => 0,
        };
        self.values.len() * size_of::<SingleBlock>() + descent
    }

    /// The next matrix has another pattern.
    pub fn forget(&mut self) {
        self.descent = None;
    }

    /// Takes over new values.
    pub fn update(&mut self, pool: &Pool, matrix: &Matrix) {
        let n = matrix.rows();
        let traces = pool.fold(0..n, &|_, rows: Range<usize>| {
            rows.map(|i| matrix.diagonal(i)).map(|block| block[0] + block[4] + block[8]).sum::<f64>()
        });
        let mean = traces / (3 * n) as f64;
        self.scale = if mean.is_normal() && mean > 0.0 { 1.0 / power_of_two(mean) } else { 1.0 };
        self.values.resize(matrix.blocks() + 1, [0.0; 9]);
        let descent = self.descent.get_or_insert_with(|| match Sliced::new(n, matrix.pattern()) {
            Some(sliced) => Descent::Alike(sliced),
            None => Descent::Each(Each::new(n, matrix.pattern())),
        });
        match descent {
            Descent::Alike(sliced) => sliced.update(pool, matrix, self.scale),
            Descent::Each(each) => each.update(pool, matrix, self.scale),
        }
    }

    /// A descent begins, with the direction zero.
    pub fn start(&mut self) {
        match &mut self.descent {
            Some(Descent::Alike(sliced)) => sliced.start(),
            Some(Descent::Each(each)) => each.start(),
            None => {}
        }
    }

    /// Goes by `a` along the direction p, which then becomes `h + beta p`.
    pub fn turn(&mut self, pool: &Pool, h: &[Vectors], a: f32, beta: f32) {
        match &mut self.descent {
            Some(Descent::Alike(sliced)) => sliced.turn(pool, h, a, beta),
            Some(Descent::Each(each)) => each.turn(pool, h, a, beta),
            None => {}
        }
    }

    /// Finds `scale A p`, for [`Single::take`]; gives `p . scale A p`.
    pub fn product(&mut self, pool: &Pool) -> f64 {
        match &mut self.descent {
            Some(Descent::Alike(sliced)) => sliced.product(pool),
            Some(Descent::Each(each)) => each.product(pool),
            None => 0.0,
        }
    }

    /// `out[k] = A x[k]` in double precision, of the matrix that was taken over last.
    pub fn exact_products<const K: usize>(
        &mut self,
        pool: &Pool,
        matrix: &Matrix,
        x: [&[Vec3]; K],
        out: [&mut [Vec3]; K],
    ) {
        match (&mut self.descent, matrix.values()) {
            (Some(Descent::Alike(sliced)), Values::Rounded(of)) => {
                sliced.exact_products(pool, (of, 1.0 / self.scale), x, out);
            }
            _ => matrix.products(pool, x, out),
        }
    }

    /// `r -= a scale A p` of the last product, sixteens of rows from `first` on.
    pub fn take(&self, first: usize, a: f32, r: &mut [Vectors]) {
        match &self.descent {
            Some(Descent::Alike(sliced)) => sliced.take(first, a, r),
            Some(Descent::Each(each)) => each.take(first, a, r),
            None => {}
        }
    }

    /// Adds `scale` times the way that was gone to rows `first` on.
    pub fn add_to(&self, first: usize, scale: f64, x: &mut [Vec3]) {
        match &self.descent {
            Some(Descent::Alike(sliced)) => sliced.add_to(first, scale, x),
            Some(Descent::Each(each)) => each.add_to(first, scale, x),
            None => {}
        }
    }

    /// Rounds the blocks in `slots` as they would be if fixed nodes were joined to no other and to nothing.
    pub fn without_fixed(&mut self, pool: &Pool, matrix: &Matrix, constraints: &[Constraint], slots: Range<usize>) {
        round(pool, (self.scale, matrix), slots.clone(), &mut self.values[slots.clone()]);
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
        for is_rounded in [false, true] {
            if is_rounded {
                matrix.round();
            }
            let (pool, mut single) = (Pool::new(1), Single::default());
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
