//! Vectors by component, from any of which on sixteen can be read at once.

use crate::step::lanes::{Lanes, Sixteen};
use crate::step::lines::Lines;
use crate::step::sliced::LANES;

/// See above.
#[derive(Debug, Default)]
pub struct Planes([Lines<f32>; 3]);

/// Sixteens of vectors, by component.
pub type Sixteens<'a> = [&'a mut [Sixteen]; 3];

impl Planes {
    /// So many zeros.
    pub fn new(count: usize) -> Self {
        Self([(); 3].map(|()| Lines::new(count.next_multiple_of(LANES) + LANES)))
    }

    /// All of them, and some that are zero.
    #[inline(always)]
    pub fn all(&self) -> [&[f32]; 3] {
        self.0.each_ref().map(Lines::flat)
    }

    /// By sixteen.
    pub fn sixteens(&mut self) -> Sixteens<'_> {
        self.0.each_mut().map(|plane| {
            let (sixteens, _) = plane.flat_mut().as_chunks_mut();
            let count = sixteens.len() - 1;
            &mut sixteens[..count]
        })
    }

    /// Sixteen of them.
    #[inline(always)]
    pub fn load<U: Lanes>(&self, unit: U, sixteen: usize) -> [U::V; 3] {
        self.all().map(|plane| unit.load(&plane.as_chunks().0[sixteen]))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.0.iter().map(Lines::bytes).sum()
    }

    #[cfg(test)]
    pub fn put(&mut self, i: usize, v: [f32; 3]) {
        (0..3).for_each(|c| self.0[c].flat_mut()[i] = v[c]);
    }
}

/// Puts one of the sixteens.
#[inline(always)]
pub fn store<U: Lanes>(unit: U, to: &mut Sixteens<'_>, at: usize, v: [U::V; 3]) {
    for (to, v) in to.iter_mut().zip(v) {
        to[at] = unit.store(v);
    }
}
