//! Rows of a product with AVX-512: eight of the nine entries of a block at once.

use super::{Block, Row, Vec3, add_up};
use crate::matrix::pattern::LowerBlock;
use pulp::x86::V4;
use pulp::{cast, f64x8, u64x8};

/// Component of a vector by which each of the first eight entries of a block is multiplied in `block^T x`.
const TRANSPOSED: u64x8 = u64x8(0, 0, 0, 1, 1, 1, 2, 2);
/// The same in `block x`.
const DIRECT: u64x8 = u64x8(0, 1, 2, 0, 1, 2, 0, 1);

/// Computes `out[k][i] = row(i) x[k]`.
pub struct Rows<'o, F, const K: usize> {
    pub simd: V4,
    pub out: [&'o mut [Vec3]; K],
    pub x: [&'o [Vec3]; K],
    pub row: F,
}

impl<'a, F: Fn(usize) -> Row<'a>, const K: usize> pulp::NullaryFnOnce for Rows<'_, F, K> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { simd, out, x, row } = self;
        for i in 0..out.first().map_or(0, |out| out.len()) {
            let Row { values, lower, upper, columns } = row(i);
            let zero = (simd.splat_f64x8(0.0), 0.0);
            let (mut transposed, mut direct) = ([zero; K], [zero; K]);
            for &LowerBlock { column: j, slot } in lower {
                let block = &values[slot as usize];
                for k in 0..K {
                    transposed[k] = add(simd, transposed[k], block, &x[k][j as usize], TRANSPOSED);
                }
            }
            for (block, &j) in upper.iter().zip(columns) {
                for k in 0..K {
                    direct[k] = add(simd, direct[k], block, &x[k][j as usize], DIRECT);
                }
            }
            for k in 0..K {
                out[k][i] = add_up((cast(transposed[k].0), transposed[k].1), (cast(direct[k].0), direct[k].1));
            }
        }
    }
}

/// Adds the products of the entries of a block and the components `spread` of x to sums of the first eight entries and of the ninth.
#[inline(always)]
fn add(simd: V4, sums: (f64x8, f64), block: &Block, x: &Vec3, spread: u64x8) -> (f64x8, f64) {
    let three: f64x8 = cast([x.x, x.y, x.z, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let spread: f64x8 = cast(simd.avx512f._mm512_permutexvar_pd(cast(spread), cast(three)));
    let [a, b, c, d, e, f, g, h, last] = *block;
    let eight: f64x8 = cast([a, b, c, d, e, f, g, h]);
    (simd.add_f64x8(sums.0, simd.mul_f64x8(eight, spread)), sums.1 + last * x.z)
}
