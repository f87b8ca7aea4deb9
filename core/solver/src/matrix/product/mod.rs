//! Rows of the product of a matrix and a vector, block by block.
//!
//! Each of the nine entries of a block has a sum of its own along the row; at the end of the row three sums make a component. Every vector
//! unit does the same operations in the same order, so bytes do not depend on the one found at run time.

pub mod f32_blocks;

use super::pattern::LowerBlock;
use crate::algebra::{Block, Vec3};
use crate::lanes::blocks::BlockUnit;
use crate::lanes::{Lanes, Work};

/// A row of a matrix in double precision.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    /// All stored blocks, by slot.
    pub values: &'a [Block],
    /// Blocks below the diagonal.
    pub lower: &'a [LowerBlock],
    /// Blocks from the diagonal on.
    pub upper: &'a [Block],
    /// Columns of the blocks `upper`.
    pub columns: &'a [u32],
}

/// Computes `out[k][i] = row(i) x[k]`.
pub struct RowsProduct<'o, F, const K: usize> {
    /// The products, as many rows of each.
    pub out: [&'o mut [Vec3]; K],
    /// The K vectors that are multiplied, a part for each node (n x 3).
    pub x: [&'o [Vec3]; K],
    /// The row of each of `out`.
    pub row: F,
}

impl<'a, F: Fn(usize) -> Row<'a>, const K: usize> Work for RowsProduct<'_, F, K> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let (Self { out, x, row }, unit) = (self, unit.f64_blocks());
        for i in 0..out.first().map_or(0, |out| out.len()) {
            let (Row { values, lower, upper, columns }, zero) = (row(i), unit.splat(0.0));
            let (mut transposed, mut direct) = ([zero; K], [zero; K]);
            for &LowerBlock { column: j, slot } in lower {
                let block = unit.load(&values[slot as usize]);
                for k in 0..K {
                    let x = unit.by_row(&padded(x[k][j as usize]));
                    transposed[k] = unit.add(transposed[k], unit.mul(block, x));
                }
            }
            for (block, &j) in upper.iter().zip(columns) {
                let block = unit.load(block);
                for k in 0..K {
                    let x = unit.by_column(&padded(x[k][j as usize]));
                    direct[k] = unit.add(direct[k], unit.mul(block, x));
                }
            }
            for k in 0..K {
                out[k][i] = add_up(&unit.store(transposed[k]), &unit.store(direct[k]));
            }
        }
    }
}

/// A vector and a zero.
#[inline(always)]
fn padded(v: Vec3) -> [f64; 4] {
    [v.x, v.y, v.z, 0.0]
}

/// The product of a row, from the sums of transposed blocks and of blocks as they are stored.
#[inline(always)]
fn add_up(transposed: &Block, direct: &Block) -> Vec3 {
    let [a, b, c, d, e, f, g, h, i] = *transposed;
    let [j, k, l, m, n, o, p, q, r] = *direct;
    Vec3::new((a + d + g) + (j + k + l), (b + e + h) + (m + n + o), (c + f + i) + (p + q + r))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Unit;

    #[test]
    fn every_vector_unit_gives_the_same_bytes_and_the_product() {
        let wave = |i: usize| (1.7 * i as f64).sin() * 10_f64.powi((i % 7) as i32 - 3);
        let values: Vec<Block> = (0..40).map(|b| std::array::from_fn(|e| wave(9 * b + e))).collect();
        let x: Vec<Vec3> = (0..31).map(|j| Vec3::from_fn(|e, _| wave(1000 + 3 * j + e))).collect();
        let lower: Vec<LowerBlock> = (0..12).map(|k| LowerBlock { column: 29 - k, slot: 3 * k }).collect();
        let columns: Vec<u32> = (0..9).map(|k| 2 * k + 3).collect();
        let row =
            |i: usize| Row { values: &values, lower: &lower[i..], upper: &values[20 + i..29], columns: &columns[i..] };
        let products = Unit::ALL.map(|unit| {
            let mut out = [vec![Vec3::zeros(); 9], vec![Vec3::zeros(); 9]];
            unit.run(RowsProduct { out: out.each_mut().map(|out| &mut out[..]), x: [&x, &x[1..]], row });
            out
        });
        let bits = |out: &[Vec<Vec3>; 2]| out.iter().flatten().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert!(products.iter().all(|out| bits(out) == bits(&products[0])));
        for (i, (k, out)) in (0..9).flat_map(|i| products[0].iter().enumerate().map(move |out| (i, out))) {
            let mut want = [0.0; 3];
            for &LowerBlock { column, slot } in row(i).lower {
                (0..9).for_each(|e| want[e % 3] += values[slot as usize][e] * x[k + column as usize][e / 3]);
            }
            for (block, &j) in row(i).upper.iter().zip(row(i).columns) {
                (0..9).for_each(|e| want[e / 3] += block[e] * x[k + j as usize][e % 3]);
            }
            assert!((0..3).all(|c| (out[i][c] - want[c]).abs() < 1e-6), "{out:?} {want:?}");
        }
    }
}
