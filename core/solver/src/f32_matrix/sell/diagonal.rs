//! Row sums of the matrix, sixteen rows at a time: mostly masses, which take a ninth of the memory of blocks.

use super::BLOCKS;
use super::product::{STRAIGHT, Three, add};
use crate::algebra::Block;
use crate::lanes::aligned::Lines;
use crate::lanes::{Entry, LANES, Lanes};
use crate::matrix::f32_blocks::RowSum;

/// Row sums by slice.
#[derive(Debug)]
pub struct Diagonal {
    /// Whether a slice has masses alone.
    masses: Vec<bool>,
    mass: Lines<f32>,
    /// Blocks of the other slices.
    block: Lines<f32>,
}

impl Diagonal {
    /// Zeros for so many slices.
    pub fn new(slices: usize) -> Self {
        Self { masses: vec![false; slices], mass: Lines::new(LANES * slices), block: Lines::new(BLOCKS * slices) }
    }

    /// Memory, bytes.
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
        self.masses[slice] = masses.iter_mut().zip(rows.clone()).all(|(mass, own)| match own {
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
        let (mut blocks, nothing): (_, Block) = ([[0.0; 9]; LANES], [0.0; 9]);
        blocks.iter_mut().zip(rows).for_each(|(block, own)| *block = own.block());
        let mut refs = [&nothing; LANES];
        for lane in 0..LANES {
            refs[lane] = &blocks[lane];
        }
        put(unit, refs, scale, self.block.flat_mut()[BLOCKS * slice..BLOCKS * (slice + 1)].as_chunks_mut().0);
    }

    /// Product with a vector in each lane.
    #[inline(always)]
    pub fn times<U: Lanes>(&self, unit: U, slice: usize, v: Three<U>) -> Three<U> {
        if self.masses[slice] {
            let m = unit.load(&self.mass.flat().as_chunks().0[slice]);
            return [unit.mul(m, v[0]), unit.mul(m, v[1]), unit.mul(m, v[2])];
        }
        let mut sum = [unit.load(&[0.0; LANES]); 3];
        add(unit, self.block.flat()[BLOCKS * slice..].as_chunks().0, STRAIGHT, v, &mut sum);
        sum
    }
}

/// Stores the entries of blocks, times `scale`.
#[inline(always)]
pub fn put<U: Lanes, T: Entry>(unit: U, blocks: [&[T; 9]; LANES], scale: f64, to: &mut [[f32; LANES]]) {
    let entries = unit.entries(blocks, scale);
    for e in 0..9 {
        to[e] = unit.store(unit.flush_denormals(entries[e]));
    }
}
