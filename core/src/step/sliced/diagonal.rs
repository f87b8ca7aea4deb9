//! What the blocks of rows leave on the diagonal, sixteen rows at a time: most often masses alone, which are a ninth of it.

use super::product::{STRAIGHT, Three, add};
use super::update::put;
use super::{BLOCKS, LANES};
use crate::step::Block;
use crate::step::lanes::{Entry, Lanes};
use crate::step::lines::Lines;
use crate::step::rounded::Own;

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
    pub fn put<U: Lanes>(&mut self, unit: U, slice: usize, rows: impl Iterator<Item = Own>, scale: f64) {
        let (mut masses, mut blocks, mut all) = ([0.0; LANES], [[0.0; 9]; LANES], true);
        for ((mass, block), own) in masses.iter_mut().zip(&mut blocks).zip(rows) {
            match own {
                Own::Mass(m) => (*mass, block[0], block[4], block[8]) = (m.rounded(scale), m, m, m),
                Own::Block(own) => (*block, all) = (own, false),
            }
        }
        self.masses[slice] = all;
        if all {
            let to = &mut self.mass.flat_mut().as_chunks_mut::<LANES>().0[slice];
            *to = unit.store(unit.without_dust(unit.load(&masses)));
            return;
        }
        let nothing: Block = [0.0; 9];
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
