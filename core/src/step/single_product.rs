//! Rows of a symmetric block matrix times a vector of differences, in single precision.
//!
//! As in [`super::product`]: multiplied and added in a fixed order, never fused, so every vector unit gives the same bytes.

use super::matrix::Rows;
use super::single::Quad;

/// Blocks one behind the other, with more behind them; those of the diagonal; where they are.
#[derive(Clone, Copy)]
pub struct Blocks<'a> {
    pub values: &'a [f32],
    pub own: &'a [f32],
    pub rows: Rows<'a>,
}

/// A row: blocks below the diagonal by column and slot, to be transposed, and those above it from a slot on.
struct Row<'a> {
    own: &'a [f32],
    lower: &'a [(u32, u32)],
    above: &'a [f32],
    columns: &'a [u32],
}

impl<'a> Blocks<'a> {
    #[inline(always)]
    fn row(&self, i: usize) -> Row<'a> {
        let (lower, above, columns) = self.rows.around(i);
        Row { own: &self.own[9 * i..], lower, above: &self.values[9 * above..], columns }
    }
}

/// `out = A x` from row `first` on, with the widest vector unit there is. Gives the sum of `x . out` over these rows.
pub fn rows_product(first: usize, out: &mut [Quad], x: &[Quad], blocks: Blocks<'_>) -> f64 {
    #[cfg(target_arch = "x86_64")]
    if let pulp::Arch::V4(simd) = pulp::Arch::new() {
        return simd.vectorize(wide::Product { simd, first, out, x, blocks });
    }
    portable(first, out, x, blocks)
}

fn portable(first: usize, out: &mut [Quad], x: &[Quad], blocks: Blocks<'_>) -> f64 {
    let mut sum = [0.0; 4];
    for (i, out) in out.iter_mut().enumerate() {
        let here = x[first + i];
        *out = row_product(blocks.row(first + i), blocks.values, here, x);
        (0..4).for_each(|c| sum[c] += here[c] * out[c]);
    }
    total(sum)
}

fn total(sum: Quad) -> f64 {
    f64::from(sum[0]) + f64::from(sum[1]) + f64::from(sum[2])
}

#[inline(always)]
fn row_product(row: Row<'_>, values: &[f32], here: Quad, x: &[Quad]) -> Quad {
    let (mut turned, mut straight) = ([0.0_f32; 9], [0.0_f32; 9]);
    add(&mut straight, row.own, here, |[x, y, z, _]| [x, y, z, x, y, z, x, y, z]);
    for (block, &j) in row.above.chunks_exact(9).zip(row.columns) {
        add(&mut straight, block, minus(x[j as usize], here), |[x, y, z, _]| [x, y, z, x, y, z, x, y, z]);
    }
    for &(j, slot) in row.lower {
        let block = &values[9 * slot as usize..];
        add(&mut turned, block, minus(x[j as usize], here), |[x, y, z, _]| [x, x, x, y, y, y, z, z, z]);
    }
    let s = |c: usize| straight[3 * c] + straight[3 * c + 1] + straight[3 * c + 2];
    let t = |c: usize| turned[c] + turned[3 + c] + turned[6 + c];
    [s(0) + t(0), s(1) + t(1), s(2) + t(2), 0.0]
}

#[inline(always)]
fn minus(a: Quad, b: Quad) -> Quad {
    std::array::from_fn(|c| a[c] - b[c])
}

#[inline(always)]
fn add(sums: &mut [f32; 9], block: &[f32], x: Quad, spread: impl Fn(Quad) -> [f32; 9]) {
    let (spread, block) = (spread(x), &block[..9]);
    (0..9).for_each(|e| sums[e] += block[e] * spread[e]);
}

#[cfg(target_arch = "x86_64")]
mod wide {
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
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::Matrix;

    #[test]
    fn every_vector_unit_gives_the_same_bytes_and_the_product() {
        let wave = |i: usize| (1.7 * i as f32).sin() * 10_f32.powi((i % 7) as i32 - 3);
        let n = 30;
        let mut matrix = Matrix::default();
        matrix.set_pattern(n, |pair| {
            for i in 0..n as u32 {
                (i + 1..n as u32).step_by(1 + i as usize % 5).take(9).for_each(|j| pair(i, j));
            }
        });
        let values: Vec<f32> = (0..9 * matrix.blocks() + 9).map(wave).collect();
        let own: Vec<f32> = (0..9 * n + 9).map(|i| wave(7 * i)).collect();
        let x: Vec<Quad> = (0..n).map(|j| [wave(3 * j + 1), wave(3 * j + 2), wave(3 * j + 3), 0.0]).collect();
        let blocks = Blocks { values: &values, own: &own, rows: matrix.pattern() };
        let (mut out, mut other) = (vec![[0.0; 4]; n - 2], vec![[0.0; 4]; n - 2]);
        let sums = [rows_product(2, &mut out, &x, blocks), portable(2, &mut other, &x, blocks)];
        assert_eq!(sums[0].to_bits(), sums[1].to_bits());
        for (i, (out, other)) in (2..n).zip(out.iter().zip(&other)) {
            assert_eq!(out.map(f32::to_bits), other.map(f32::to_bits));
            let (mut want, mut size) = ([0.0_f64; 3], [0.0_f64; 3]);
            let mut add = |block: &[f32], turned: bool, j: Option<usize>| {
                for e in 0..9 {
                    let (to, from) = if turned { (e % 3, e / 3) } else { (e / 3, e % 3) };
                    let away = j.map_or(x[i][from], |j| x[j][from] - x[i][from]);
                    let term = f64::from(block[e]) * f64::from(away);
                    (want[to], size[to]) = (want[to] + term, size[to] + term.abs());
                }
            };
            let (lower, above, columns) = blocks.rows.around(i);
            add(&own[9 * i..], false, None);
            lower.iter().for_each(|&(j, slot)| add(&values[9 * slot as usize..], true, Some(j as usize)));
            columns.iter().enumerate().for_each(|(k, &j)| add(&values[9 * (above + k)..], false, Some(j as usize)));
            assert!((0..3).all(|c| (f64::from(out[c]) - want[c]).abs() < 2e-6 * size[c]), "{out:?} {want:?}");
            assert_eq!(out[3], 0.0);
        }
    }
}
