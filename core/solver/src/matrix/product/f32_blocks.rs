//! Rows of a product in double precision, of blocks that are stored in single precision ([`crate::matrix::f32_blocks`]).

use super::{add_up, padded};
use crate::algebra::{Block, SingleBlock, Vec3};
use crate::lanes::blocks::BlockUnit;
use crate::lanes::{Lanes, Work};
use crate::matrix::pattern::LowerBlock;

/// A row of a matrix in single precision.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    /// Sum of all blocks of the row.
    pub sum: Block,
    /// All stored blocks, by slot.
    pub values: &'a [SingleBlock],
    /// Blocks below the diagonal.
    pub lower: &'a [LowerBlock],
    /// Blocks above the diagonal.
    pub upper: &'a [SingleBlock],
    /// Columns of the blocks `upper`.
    pub columns: &'a [u32],
}

/// Computes `out[k][i] = row(i) x[k]`, where `row(i)` is the row of node `first + i`.
pub struct RowsProduct<'o, F, const K: usize> {
    /// The products, as many rows of each.
    pub out: [&'o mut [Vec3]; K],
    /// The node of the first row.
    pub first: usize,
    /// The K vectors that are multiplied, a part for each node (n x 3).
    pub x: [&'o [Vec3]; K],
    /// The row of each of `out`.
    pub row: F,
}

impl<'a, F: Fn(usize) -> Row<'a>, const K: usize> Work for RowsProduct<'_, F, K> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        let (Self { out, first, x, row }, unit) = (self, unit.f64_blocks());
        for i in 0..out.first().map_or(0, |out| out.len()) {
            let (Row { sum, values, lower, upper, columns }, zero) = (row(i), unit.splat(0.0));
            let (mut transposed, mut direct, mut own) = ([zero; K], [zero; K], [Vec3::zeros(); K]);
            for k in 0..K {
                own[k] = x[k][first + i];
                direct[k] = unit.add(zero, unit.mul(unit.load(&sum), unit.by_column(&padded(own[k]))));
            }
            for &LowerBlock { column: j, slot } in lower {
                let block = unit.load_f32(&values[slot as usize]);
                for k in 0..K {
                    let difference = unit.by_row(&padded(x[k][j as usize] - own[k]));
                    transposed[k] = unit.add(transposed[k], unit.mul(block, difference));
                }
            }
            for (block, &j) in upper.iter().zip(columns) {
                let block = unit.load_f32(block);
                for k in 0..K {
                    let difference = unit.by_column(&padded(x[k][j as usize] - own[k]));
                    direct[k] = unit.add(direct[k], unit.mul(block, difference));
                }
            }
            for k in 0..K {
                out[k][i] = add_up(&unit.store(transposed[k]), &unit.store(direct[k]));
            }
        }
    }
}
