//! Rows of a product in single precision, a block at once.

use super::{Blocks, Quad, Row, total};
use pulp::x86::V4;
use pulp::{cast, f32x4, f32x16, u32x16};

/// Each of three numbers three times, in a row and by turns; the zero behind them fills up.
const TURNED: u32x16 = u32x16(0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3);
const STRAIGHT: u32x16 = u32x16(0, 1, 2, 0, 1, 2, 0, 1, 2, 3, 3, 3, 3, 3, 3, 3);
/// The k-th of each three, and each k-th three.
const EVERY: [u32x16; 3] = [every(0), every(1), every(2)];
const GROUP: [u32x16; 3] = [group(0), group(1), group(2)];

const fn every(k: u32) -> u32x16 {
    u32x16(k, 3 + k, 6 + k, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15)
}

const fn group(k: u32) -> u32x16 {
    u32x16(3 * k, 3 * k + 1, 3 * k + 2, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15)
}

pub struct Product<'o> {
    pub simd: V4,
    pub first: usize,
    pub out: &'o mut [Quad],
    pub x: &'o [Quad],
    pub blocks: Blocks<'o>,
}

impl pulp::NullaryFnOnce for Product<'_> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self { simd, first, out, x, blocks } = self;
        let mut sum: Quad = [0.0; 4];
        for (i, out) in out.iter_mut().enumerate() {
            let Row { own, lower, above, columns } = blocks.row(first + i);
            let here: f32x4 = cast(x[first + i]);
            let mut straight = times(simd, own, here, STRAIGHT);
            for (k, &j) in columns.iter().enumerate() {
                let away = simd.sub_f32x4(cast(x[j as usize]), here);
                let term = times(simd, &above[9 * k..], away, STRAIGHT);
                straight = simd.add_f32x16(straight, term);
            }
            let mut turned = simd.splat_f32x16(0.0);
            for &(j, slot) in lower {
                let away = simd.sub_f32x4(cast(x[j as usize]), here);
                let term = times(simd, &blocks.values[9 * slot as usize..], away, TURNED);
                turned = simd.add_f32x16(turned, term);
            }
            let s = threes(simd, straight, &EVERY);
            let t = threes(simd, turned, &GROUP);
            let both: [f32; 16] = cast(simd.add_f32x16(s, t));
            *out = [both[0], both[1], both[2], 0.0];
            let here: Quad = cast(here);
            (0..4).for_each(|c| sum[c] += here[c] * out[c]);
        }
        total(sum)
    }
}

#[inline(always)]
fn permuted(simd: V4, v: f32x16, at: u32x16) -> f32x16 {
    cast(simd.avx512f._mm512_permutexvar_ps(cast(at), cast(v)))
}

#[inline(always)]
fn times(simd: V4, block: &[f32], x: f32x4, spread: u32x16) -> f32x16 {
    let x: f32x16 = cast(simd.avx512f._mm512_castps128_ps512(cast(x)));
    let block: [f32; 16] = *block.first_chunk().expect("blocks have others behind them");
    simd.mul_f32x16(cast(block), permuted(simd, x, spread))
}

#[inline(always)]
fn threes(simd: V4, v: f32x16, [a, b, c]: &[u32x16; 3]) -> f32x16 {
    let first = simd.add_f32x16(permuted(simd, v, *a), permuted(simd, v, *b));
    simd.add_f32x16(first, permuted(simd, v, *c))
}
