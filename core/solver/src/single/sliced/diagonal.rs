//! What the blocks of rows leave on the diagonal, sixteen rows at a time: most often masses alone, which are a ninth of it.

use super::BLOCKS;
use super::product::{STRAIGHT, Three, add};
use crate::algebra::Block;
use crate::lanes::aligned::Lines;
use crate::lanes::{Entry, LANES, Lanes};
use crate::matrix::rounded::Own;

/// By slice.
#[derive(Debug)]
pub struct Diagonal {
    /// Whether there are masses alone.
    masses: Vec<bool>,
    mass: Lines<f32>,
    /// Elsewhere.
    block: Lines<f32>,
}

impl Diagonal {
    /// Of so many slices.
    pub fn new(slices: usize) -> Self {
        Self { masses: vec![false; slices], mass: Lines::new(LANES * slices), block: Lines::new(BLOCKS * slices) }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.masses.len() + self.mass.bytes() + self.block.bytes()
    }

    /// Whether a slice has masses alone.
    #[cfg(test)]
    pub fn is_mass(&self, slice: usize) -> bool {
        self.masses[slice]
    }

    /// Takes over what the rows of a slice have, times `scale`.
    #[inline(always)]
    pub fn put<U: Lanes>(&mut self, unit: U, slice: usize, rows: impl Iterator<Item = Own> + Clone, scale: f64) {
        let mut masses = [0.0; LANES];
        self.masses[slice] = masses.iter_mut().zip(rows.clone()).all(|(mass, own)| match own {
            Own::Mass(m) => {
                *mass = m.rounded(scale);
                true
            }
            Own::Block(_) => false,
        });
        if self.masses[slice] {
            let to = &mut self.mass.flat_mut().as_chunks_mut::<LANES>().0[slice];
            *to = unit.store(unit.without_dust(unit.load(&masses)));
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

    /// Times a vector, in each lane.
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

/// Puts the entries of blocks, times `scale`.
#[inline(always)]
pub fn put<U: Lanes, T: Entry>(unit: U, blocks: [&[T; 9]; LANES], scale: f64, to: &mut [[f32; LANES]]) {
    let entries = unit.entries(blocks, scale);
    for e in 0..9 {
        to[e] = unit.store(unit.without_dust(entries[e]));
    }
}
