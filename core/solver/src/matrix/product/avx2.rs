//! Rows of a product with AVX2: four of the nine entries of a block at once.

use super::{Block, Row, Sums, Vec3, add_up};
use crate::matrix::pattern::LowerBlock;
use pulp::{cast, f64x4, x86};

/// Nine numbers in registers, one for each entry of a block.
#[derive(Clone, Copy)]
pub struct Nine {
    /// Numbers 0 to 3.
    pub low: f64x4,
    /// Numbers 4 to 7.
    pub high: f64x4,
    /// Number 8.
    pub last: f64,
}

impl Nine {
    /// The entries of a block.
    #[inline(always)]
    pub fn new(block: &Block) -> Self {
        let [a, b, c, d, e, f, g, h, last] = *block;
        Self { low: cast([a, b, c, d]), high: cast([e, f, g, h]), last }
    }

    /// The numbers in memory.
    #[inline(always)]
    pub fn sums(self) -> Sums {
        (cast([self.low, self.high]), self.last)
    }
}

/// Nine zeros.
#[inline(always)]
pub fn zero(simd: x86::V3) -> Nine {
    Nine { low: simd.splat_f64x4(0.0), high: simd.splat_f64x4(0.0), last: 0.0 }
}

/// The component of x by which each entry of a block is multiplied in `block x`, or if `TRANSPOSED` in `block^T x`.
#[inline(always)]
pub fn spread<const TRANSPOSED: bool>(simd: x86::V3, x: Vec3) -> Nine {
    let (three, avx2) = (cast([x.x, x.y, x.z, 0.0]), simd.avx2);
    let (low, high) = match TRANSPOSED {
        true => {
            (avx2._mm256_permute4x64_pd::<0b01_00_00_00>(three), avx2._mm256_permute4x64_pd::<0b10_10_01_01>(three))
        }
        false => {
            (avx2._mm256_permute4x64_pd::<0b00_10_01_00>(three), avx2._mm256_permute4x64_pd::<0b01_00_10_01>(three))
        }
    };
    Nine { low: cast(low), high: cast(high), last: x.z }
}

/// `sums + block x`, for each number by itself.
#[inline(always)]
pub fn add(simd: x86::V3, sums: Nine, block: Nine, x: Nine) -> Nine {
    Nine {
        low: simd.add_f64x4(sums.low, simd.mul_f64x4(block.low, x.low)),
        high: simd.add_f64x4(sums.high, simd.mul_f64x4(block.high, x.high)),
        last: sums.last + block.last * x.last,
    }
}

/// Computes `out[k][i] = row(i) x[k]`.
pub struct Rows<'o, F, const K: usize> {
    pub simd: x86::V3,
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
            let (mut transposed, mut direct) = ([zero(simd); K], [zero(simd); K]);
            for &LowerBlock { column: j, slot } in lower {
                let block = Nine::new(&values[slot as usize]);
                for k in 0..K {
                    transposed[k] = add(simd, transposed[k], block, spread::<true>(simd, x[k][j as usize]));
                }
            }
            for (block, &j) in upper.iter().zip(columns) {
                for k in 0..K {
                    direct[k] = add(simd, direct[k], Nine::new(block), spread::<false>(simd, x[k][j as usize]));
                }
            }
            for k in 0..K {
                out[k][i] = add_up(transposed[k].sums(), direct[k].sums());
            }
        }
    }
}
