//! Rows of a product in single precision, eight of a block's nine numbers at once.

use super::{Blocks, Quad, Row, minus, total};
use pulp::x86::V3;
use pulp::{cast, f32x8};

/// Which number of a vector meets each of the first eight of a block, and of its transpose.
const STRAIGHT: [u32; 8] = [0, 1, 2, 0, 1, 2, 0, 1];
const TURNED: [u32; 8] = [0, 0, 0, 1, 1, 1, 2, 2];

pub struct Product<'o> {
    pub simd: V3,
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
            let (here, zero) = (x[first + i], (simd.splat_f32x8(0.0), 0.0));
            let mut straight = add(simd, zero, own, here, STRAIGHT);
            for (k, &j) in columns.iter().enumerate() {
                straight = add(simd, straight, &above[9 * k..], minus(x[j as usize], here), STRAIGHT);
            }
            let mut turned = zero;
            for &(j, slot) in lower {
                let block = &blocks.values[9 * slot as usize..];
                turned = add(simd, turned, block, minus(x[j as usize], here), TURNED);
            }
            let ([a, b, c, d, e, f, g, h], i): ([f32; 8], f32) = (cast(straight.0), straight.1);
            let ([j, k, l, m, n, o, p, q], r): ([f32; 8], f32) = (cast(turned.0), turned.1);
            *out = [(a + b + c) + (j + m + p), (d + e + f) + (k + n + q), (g + h + i) + (l + o + r), 0.0];
            (0..4).for_each(|c| sum[c] += here[c] * out[c]);
        }
        total(sum)
    }
}

#[inline(always)]
fn add(simd: V3, sums: (f32x8, f32), block: &[f32], x: Quad, spread: [u32; 8]) -> (f32x8, f32) {
    let (eight, last): (&[f32; 8], f32) = (block.first_chunk().expect("blocks have nine numbers"), block[8]);
    let x8 = simd.avx2._mm256_permutevar8x32_ps(simd.avx._mm256_castps128_ps256(cast(x)), cast(spread));
    (simd.add_f32x8(sums.0, simd.mul_f32x8(cast(*eight), cast(x8))), sums.1 + last * x[2])
}
