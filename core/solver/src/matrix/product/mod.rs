//! Rows of a product, a block at a time.
//!
//! The nine products of a block with a vector are nine sums that run along the row and come together at its end. AVX-512 takes
//! eight of them at once, AVX2 four; the portable path does the same operations in the same order, so bytes do not depend on the vector
//! unit found at run time.

#[cfg(target_arch = "x86_64")]
pub mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub mod f32_blocks;

use crate::algebra::{Block, Vec3};

/// What a row is made of: blocks below the diagonal by column and slot, to be transposed, and those from it on.
#[derive(Clone, Copy)]
pub struct Row<'a> {
    pub values: &'a [Block],
    pub lower: &'a [(u32, u32)],
    pub upper: &'a [Block],
    pub columns: &'a [u32],
}

/// The ninth of the sums is apart.
pub type Sums = ([f64; 8], f64);

/// Sums come together.
#[inline(always)]
pub fn ends(turned: Sums, straight: Sums) -> Vec3 {
    let ([a, b, c, d, e, f, g, h], i) = turned;
    let ([j, k, l, m, n, o, p, q], r) = straight;
    Vec3::new((a + d + g) + (j + k + l), (b + e + h) + (m + n + o), (c + f + i) + (p + q + r))
}

/// The portable path.
#[inline(always)]
pub fn row_product(row: Row<'_>, x: &[Vec3]) -> Vec3 {
    let (mut turned, mut straight) = (([0.0; 8], 0.0), ([0.0; 8], 0.0));
    for &(j, slot) in row.lower {
        add(&mut turned, &row.values[slot as usize], x[j as usize], |x| {
            [x[0], x[0], x[0], x[1], x[1], x[1], x[2], x[2]]
        });
    }
    for (block, &j) in row.upper.iter().zip(row.columns) {
        add(&mut straight, block, x[j as usize], |x| [x[0], x[1], x[2], x[0], x[1], x[2], x[0], x[1]]);
    }
    ends(turned, straight)
}

#[inline(always)]
fn add(sums: &mut Sums, block: &Block, x: Vec3, spread: impl Fn(Vec3) -> [f64; 8]) {
    let spread = spread(x);
    for e in 0..8 {
        sums.0[e] += block[e] * spread[e];
    }
    sums.1 += block[8] * x[2];
}

/// `out[k][i] = row(first + i) x[k]`, with the widest vector unit there is.
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
        let lower: Vec<(u32, u32)> = (0..12).map(|k| (29 - k, 3 * k)).collect();
        let columns: Vec<u32> = (0..9).map(|k| 2 * k + 3).collect();
        let row =
            |i: usize| Row { values: &values, lower: &lower[i..], upper: &values[20 + i..29], columns: &columns[i..] };
        let (mut out, mut other) = (vec![Vec3::zeros(); 9], vec![Vec3::zeros(); 9]);
        rows_product([&mut out, &mut other], [&x, &x[1..]], row);
        for (i, out) in out.iter().enumerate() {
            assert_eq!(out.map(f64::to_bits), row_product(row(i), &x).map(f64::to_bits));
            assert_eq!(other[i].map(f64::to_bits), row_product(row(i), &x[1..]).map(f64::to_bits));
            let mut want = [0.0; 3];
            for &(j, slot) in row(i).lower {
                (0..9).for_each(|e| want[e % 3] += values[slot as usize][e] * x[j as usize][e / 3]);
            }
            for (block, &j) in row(i).upper.iter().zip(row(i).columns) {
                (0..9).for_each(|e| want[e / 3] += block[e] * x[j as usize][e % 3]);
            }
            assert!((0..3).all(|c| (out[c] - want[c]).abs() < 1e-6), "{out:?} {want:?}");
        }
    }
}
