//! Rows of the product of a matrix and a vector, block by block.
//!
//! Each of the nine entries of a block has a sum of its own along the row; at the end of the row three sums make a component. AVX-512 adds
//! to eight of them at once, AVX2 to four. The portable code does the same operations in the same order, so bytes do not depend on the
//! vector unit found at run time.

#[cfg(target_arch = "x86_64")]
pub mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub mod f32_blocks;

use super::pattern::LowerBlock;
use crate::algebra::{Block, Vec3};

/// A row of a matrix in double precision.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    /// All stored blocks, by slot.
    pub values: &'a [Block],
    /// Blocks below the diagonal.
    pub lower: &'a [LowerBlock],
    /// Blocks from the diagonal on.
    pub upper: &'a [Block],
    /// Columns of the blocks `upper`.
    pub columns: &'a [u32],
}

/// Sums of the first eight entries of the blocks of a row times numbers of a vector, and that of the ninth.
pub type Sums = ([f64; 8], f64);

/// The product of a row, from the sums of transposed blocks and of blocks as they are stored.
#[inline(always)]
pub fn add_up(transposed: Sums, direct: Sums) -> Vec3 {
    let ([a, b, c, d, e, f, g, h], i) = transposed;
    let ([j, k, l, m, n, o, p, q], r) = direct;
    Vec3::new((a + d + g) + (j + k + l), (b + e + h) + (m + n + o), (c + f + i) + (p + q + r))
}

/// The product of a row and a vector without vector instructions.
#[inline(always)]
pub fn row_product(row: Row<'_>, x: &[Vec3]) -> Vec3 {
    let (mut transposed, mut direct) = (([0.0; 8], 0.0), ([0.0; 8], 0.0));
    for &LowerBlock { column, slot } in row.lower {
        add(&mut transposed, &row.values[slot as usize], x[column as usize], |x| {
            [x[0], x[0], x[0], x[1], x[1], x[1], x[2], x[2]]
        });
    }
    for (block, &j) in row.upper.iter().zip(row.columns) {
        add(&mut direct, block, x[j as usize], |x| [x[0], x[1], x[2], x[0], x[1], x[2], x[0], x[1]]);
    }
    add_up(transposed, direct)
}

/// Adds the products of the entries of a block and of the numbers of x that `spread` assigns to the first eight.
#[inline(always)]
fn add(sums: &mut Sums, block: &Block, x: Vec3, spread: impl Fn(Vec3) -> [f64; 8]) {
    let spread = spread(x);
    for e in 0..8 {
        sums.0[e] += block[e] * spread[e];
    }
    sums.1 += block[8] * x[2];
}

/// `out[k][i] = row(first + i) x[k]`, on the widest vector unit of the processor.
pub fn rows_product<'a, const K: usize>(out: [&mut [Vec3]; K], x: [&[Vec3]; K], row: impl Fn(usize) -> Row<'a>) {
    #[cfg(target_arch = "x86_64")]
    if let pulp::Arch::V4(simd) = pulp::Arch::new() {
        return simd.vectorize(avx512::Rows { simd, out, x, row });
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(avx2::Rows { simd, out, x, row });
    }
    for (out, x) in out.into_iter().zip(x) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = row_product(row(i), x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_vector_unit_gives_the_same_bytes_and_the_product() {
        let wave = |i: usize| (1.7 * i as f64).sin() * 10_f64.powi((i % 7) as i32 - 3);
        let values: Vec<Block> = (0..40).map(|b| std::array::from_fn(|e| wave(9 * b + e))).collect();
        let x: Vec<Vec3> = (0..31).map(|j| Vec3::from_fn(|e, _| wave(1000 + 3 * j + e))).collect();
        let lower: Vec<LowerBlock> = (0..12).map(|k| LowerBlock { column: 29 - k, slot: 3 * k }).collect();
        let columns: Vec<u32> = (0..9).map(|k| 2 * k + 3).collect();
        let row =
            |i: usize| Row { values: &values, lower: &lower[i..], upper: &values[20 + i..29], columns: &columns[i..] };
        let (mut out, mut other) = (vec![Vec3::zeros(); 9], vec![Vec3::zeros(); 9]);
        rows_product([&mut out, &mut other], [&x, &x[1..]], row);
        for (i, out) in out.iter().enumerate() {
            assert_eq!(out.map(f64::to_bits), row_product(row(i), &x).map(f64::to_bits));
            assert_eq!(other[i].map(f64::to_bits), row_product(row(i), &x[1..]).map(f64::to_bits));
            let mut want = [0.0; 3];
            for &LowerBlock { column, slot } in row(i).lower {
                (0..9).for_each(|e| want[e % 3] += values[slot as usize][e] * x[column as usize][e / 3]);
            }
            for (block, &j) in row(i).upper.iter().zip(row(i).columns) {
                (0..9).for_each(|e| want[e / 3] += block[e] * x[j as usize][e % 3]);
            }
            assert!((0..3).all(|c| (out[c] - want[c]).abs() < 1e-6), "{out:?} {want:?}");
        }
    }
}
