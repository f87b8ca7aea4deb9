//! Rows of a symmetric block matrix times a vector of differences, in single precision.
//!
//! As in [`super::product`]: multiplied and added in a fixed order, never fused, so every vector unit gives the same bytes.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

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
        return simd.vectorize(avx512::Product { simd, first, out, x, blocks });
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(avx2::Product { simd, first, out, x, blocks });
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
