//! Rows of a product with blocks in single precision ([`crate::matrix::rounded`]), in double precision.
//!
//! As in [`crate::matrix::product`]: nine sums that run along the row, the same operations in the same order on every vector unit.

use super::{Sums, ends};
use crate::algebra::{Block, SingleBlock, Vec3};

/// What a row is made of: what its blocks leave, blocks below the diagonal by column and slot, to be transposed, and those above it.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    pub own: Block,
    pub values: &'a [SingleBlock],
    pub lower: &'a [(u32, u32)],
    pub upper: &'a [SingleBlock],
    pub columns: &'a [u32],
}

/// The portable path.
#[inline(always)]
pub fn row_product(row: Row<'_>, i: usize, x: &[Vec3]) -> Vec3 {
    let (mut turned, mut straight, here) = (([0.0; 8], 0.0), ([0.0; 8], 0.0), x[i]);
    add(&mut straight, &row.own, here, STRAIGHT);
    for &(j, slot) in row.lower {
        add(&mut turned, &row.values[slot as usize].map(f64::from), x[j as usize] - here, TURNED);
    }
    for (block, &j) in row.upper.iter().zip(row.columns) {
        add(&mut straight, &block.map(f64::from), x[j as usize] - here, STRAIGHT);
    }
    ends(turned, straight)
}

/// For a transposed block and for one as it is: which number of a vector meets each of the first eight.
const TURNED: [usize; 8] = [0, 0, 0, 1, 1, 1, 2, 2];
const STRAIGHT: [usize; 8] = [0, 1, 2, 0, 1, 2, 0, 1];

#[inline(always)]
fn add(sums: &mut Sums, block: &Block, x: Vec3, spread: [usize; 8]) {
    for e in 0..8 {
        sums.0[e] += block[e] * x[spread[e]];
    }
    sums.1 += block[8] * x[2];
}

/// `out[k][i] = row(i) x[k]`, where row `i` is that of node `first + i`, with the widest vector unit there is.
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
    use super::{Row, Vec3, ends};
    use crate::algebra::SingleBlock;
    use crate::matrix::product::avx2::{Nine, add, spread, zero};
    use pulp::{cast, x86};

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
                let Row { own, values, lower, upper, columns } = row(i);
                let (mut turned, mut straight, mut here) = ([zero(simd); K], [zero(simd); K], [Vec3::zeros(); K]);
                for k in 0..K {
                    here[k] = x[k][first + i];
                    straight[k] = add(simd, zero(simd), Nine::of(&own), spread::<false>(simd, here[k]));
                }
                for &(j, slot) in lower {
                    let block = widened(simd, &values[slot as usize]);
                    for k in 0..K {
                        let away = x[k][j as usize] - here[k];
                        turned[k] = add(simd, turned[k], block, spread::<true>(simd, away));
                    }
                }
                for (block, &j) in upper.iter().zip(columns) {
                    let block = widened(simd, block);
                    for k in 0..K {
                        let away = x[k][j as usize] - here[k];
                        straight[k] = add(simd, straight[k], block, spread::<false>(simd, away));
                    }
                }
                for k in 0..K {
                    out[k][i] = ends(turned[k].sums(), straight[k].sums());
                }
            }
        }
    }

    #[inline(always)]
    fn widened(simd: x86::V3, block: &SingleBlock) -> Nine {
        let [a, b, c, d, e, f, g, h, last] = *block;
        let (low, high) = (simd.avx._mm256_cvtps_pd(cast([a, b, c, d])), simd.avx._mm256_cvtps_pd(cast([e, f, g, h])));
        Nine { low: cast(low), high: cast(high), last: f64::from(last) }
    }
}
