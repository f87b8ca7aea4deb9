//! Rows of a product, eight of a block's nine numbers at once.

use super::{Block, Row, Vec3, ends};
use pulp::x86::V4;
use pulp::{cast, f64x8, u64x8};

/// For a transposed block and for one as it is.
const TURNED: u64x8 = u64x8(0, 0, 0, 1, 1, 1, 2, 2);
const STRAIGHT: u64x8 = u64x8(0, 1, 2, 0, 1, 2, 0, 1);

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
            let (mut turned, mut straight) = ([zero; K], [zero; K]);
            for &(j, slot) in lower {
                let block = &values[slot as usize];
                for k in 0..K {
                    turned[k] = add(simd, turned[k], block, &x[k][j as usize], TURNED);
                }
            }
            for (block, &j) in upper.iter().zip(columns) {
                for k in 0..K {
                    straight[k] = add(simd, straight[k], block, &x[k][j as usize], STRAIGHT);
                }
            }
            for k in 0..K {
                out[k][i] = ends((cast(turned[k].0), turned[k].1), (cast(straight[k].0), straight[k].1));
            }
        }
    }
}

#[inline(always)]
fn add(simd: V4, sums: (f64x8, f64), block: &Block, x: &Vec3, spread: u64x8) -> (f64x8, f64) {
    let three: f64x8 = cast([x.x, x.y, x.z, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let spread: f64x8 = cast(simd.avx512f._mm512_permutexvar_pd(cast(spread), cast(three)));
    let [a, b, c, d, e, f, g, h, last] = *block;
    let eight: f64x8 = cast([a, b, c, d, e, f, g, h]);
    (simd.add_f64x8(sums.0, simd.mul_f64x8(eight, spread)), sums.1 + last * x.z)
}
