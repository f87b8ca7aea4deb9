//! Row sums of a matrix, by slices of sixteen rows. A slice without springs of tools has masses alone, a ninth of the memory of blocks.

use super::BLOCKS;
use super::product::{DIRECT, Three, add};
use crate::algebra::Block;
use crate::lanes::aligned::Lines;
use crate::lanes::{Entry, LANES, Lanes};
use crate::matrix::f32_blocks::RowSum;

/// Row sums by slice.
#[derive(Debug)]
pub struct Diagonal {
    /// Whether each slice has masses alone.
    masses: Vec<bool>,
    /// Masses of the slices that have masses alone (slices x 16).
    mass: Lines<f32>,
    /// Blocks of the other slices (slices x 9 x 16).
    block: Lines<f32>,
}

impl Diagonal {
    /// Zero row sums of a number of slices.
    pub fn new(slices: usize) -> Self {
        Self { masses: vec![false; slices], mass: Lines::new(LANES * slices), block: Lines::new(BLOCKS * slices) }
    }

    /// Memory of the values, bytes.
    pub fn bytes(&self) -> usize {
        self.masses.len() + self.mass.bytes() + self.block.bytes()
    }

    /// Whether a slice has masses alone.
    #[cfg(test)]
    pub fn is_mass(&self, slice: usize) -> bool {
        self.masses[slice]
    }

    /// Stores the row sums of a slice, times `scale`.
    #[inline(always)]
    pub fn put<U: Lanes>(&mut self, unit: U, slice: usize, rows: impl Iterator<Item = RowSum> + Clone, scale: f64) {
        let mut masses = [0.0; LANES];
        self.masses[slice] = masses.iter_mut().zip(rows.clone()).all(|(mass, sum)| match sum {
            RowSum::Mass(m) => {
                *mass = m.rounded(scale);
                true
            }
            RowSum::Block(_) => false,
        });
        if self.masses[slice] {
            let to = &mut self.mass.flat_mut().as_chunks_mut::<LANES>().0[slice];
            *to = unit.store(unit.flush_denormals(unit.load(&masses)));
            return;
        }
        let (mut blocks, zero): (_, Block) = ([[0.0; 9]; LANES], [0.0; 9]);
        blocks.iter_mut().zip(rows).for_each(|(block, sum)| *block = sum.block());
        let mut refs = [&zero; LANES];
        for lane in 0..LANES {
            refs[lane] = &blocks[lane];
        }
        put(unit, refs, scale, self.block.flat_mut()[BLOCKS * slice..BLOCKS * (slice + 1)].as_chunks_mut().0);
    }

    /// The row sums of a slice times a vector in each lane.
    #[inline(always)]
    pub fn times<U: Lanes>(&self, unit: U, slice: usize, v: Three<U>) -> Three<U> {
        if self.masses[slice] {
            let m = unit.load(&self.mass.flat().as_chunks().0[slice]);
            return [unit.mul(m, v[0]), unit.mul(m, v[1]), unit.mul(m, v[2])];
        }
        let mut sum = [unit.load(&[0.0; LANES]); 3];
        add(unit, self.block.flat()[BLOCKS * slice..].as_chunks().0, DIRECT, v, &mut sum);
        sum
    }
}

/// Stores the entries of sixteen blocks, times `scale`, by entry.
#[inline(always)]
pub fn put<U: Lanes, T: Entry>(unit: U, blocks: [&[T; 9]; LANES], scale: f64, to: &mut [[f32; LANES]]) {
    let entries = unit.entries(blocks, scale);
    for e in 0..9 {
        to[e] = unit.store(unit.flush_denormals(entries[e]));
    }
}
