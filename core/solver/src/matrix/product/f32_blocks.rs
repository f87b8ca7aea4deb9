//! Rows of a product in double precision, of blocks that are stored in single precision ([`crate::matrix::f32_blocks`]).
//!
//! As in [`crate::matrix::product`], each entry of a block has a sum of its own along the row, and every vector unit does the same
//! operations in the same order.

use super::{Sums, add_up};
use crate::algebra::{Block, SingleBlock, Vec3};
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

/// The product of row i and a vector without vector instructions.
#[inline(always)]
pub fn row_product(row: Row<'_>, i: usize, x: &[Vec3]) -> Vec3 {
    let (mut transposed, mut direct, own) = (([0.0; 8], 0.0), ([0.0; 8], 0.0), x[i]);
    add(&mut direct, &row.sum, own, DIRECT);
    for &LowerBlock { column, slot } in row.lower {
        add(&mut transposed, &row.values[slot as usize].map(f64::from), x[column as usize] - own, TRANSPOSED);
    }
    for (block, &column) in row.upper.iter().zip(row.columns) {
        add(&mut direct, &block.map(f64::from), x[column as usize] - own, DIRECT);
    }
    add_up(transposed, direct)
}

/// Component of a vector by which each of the first eight entries of a block is multiplied in `block^T x`.
const TRANSPOSED: [usize; 8] = [0, 0, 0, 1, 1, 1, 2, 2];
/// The same in `block x`.
const DIRECT: [usize; 8] = [0, 1, 2, 0, 1, 2, 0, 1];

/// Adds the products of the entries of a block and the components `spread` of x.
#[inline(always)]
fn add(sums: &mut Sums, block: &Block, x: Vec3, spread: [usize; 8]) {
    for e in 0..8 {
        sums.0[e] += block[e] * x[spread[e]];
    }
    sums.1 += block[8] * x[2];
}

/// `out[k][i] = row(i) x[k]`, where `row(i)` is the row of node `first + i`, on the widest vector unit of the processor.
pub fn rows_product<'a, const K: usize>(
    out: [&mut [Vec3]; K],
    first: usize,
    x: [&[Vec3]; K],
    row: impl Fn(usize) -> Row<'a>,
) {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(wide::Rows { simd, out, first, x, row });
    }
    for (out, x) in out.into_iter().zip(x) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = row_product(row(i), first + i, x);
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod wide {
    //! The rows of a product with AVX2.

    use super::{Row, Vec3, add_up};
    use crate::algebra::SingleBlock;
    use crate::matrix::pattern::LowerBlock;
    use crate::matrix::product::avx2::{Nine, add, spread, zero};
    use pulp::{cast, x86};

    /// Computes `out[k][i] = row(i) x[k]`, where `row(i)` is the row of node `first + i`.
    pub struct Rows<'o, F, const K: usize> {
        pub simd: x86::V3,
        pub out: [&'o mut [Vec3]; K],
        pub first: usize,
        pub x: [&'o [Vec3]; K],
        pub row: F,
    }

    impl<'a, F: Fn(usize) -> Row<'a>, const K: usize> pulp::NullaryFnOnce for Rows<'_, F, K> {
        type Output = ();

        #[inline(always)]
        fn call(self) {
            let Self { simd, out, first, x, row } = self;
            for i in 0..out.first().map_or(0, |out| out.len()) {
                let Row { sum, values, lower, upper, columns } = row(i);
                let (mut transposed, mut direct, mut own) = ([zero(simd); K], [zero(simd); K], [Vec3::zeros(); K]);
                for k in 0..K {
                    own[k] = x[k][first + i];
                    direct[k] = add(simd, zero(simd), Nine::new(&sum), spread::<false>(simd, own[k]));
                }
                for &LowerBlock { column: j, slot } in lower {
                    let block = widen(simd, &values[slot as usize]);
                    for k in 0..K {
                        let difference = x[k][j as usize] - own[k];
                        transposed[k] = add(simd, transposed[k], block, spread::<true>(simd, difference));
                    }
                }
                for (block, &j) in upper.iter().zip(columns) {
                    let block = widen(simd, block);
                    for k in 0..K {
                        let difference = x[k][j as usize] - own[k];
                        direct[k] = add(simd, direct[k], block, spread::<false>(simd, difference));
                    }
                }
                for k in 0..K {
                    out[k][i] = add_up(transposed[k].sums(), direct[k].sums());
                }
            }
        }
    }

    /// A block in double precision.
    #[inline(always)]
    fn widen(simd: x86::V3, block: &SingleBlock) -> Nine {
        let [a, b, c, d, e, f, g, h, last] = *block;
        let (low, high) = (simd.avx._mm256_cvtps_pd(cast([a, b, c, d])), simd.avx._mm256_cvtps_pd(cast([e, f, g, h])));
        Nine { low: cast(low), high: cast(high), last: f64::from(last) }
    }
}
