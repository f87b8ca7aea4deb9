//! Numbers eight at a time.

use crate::step::lines::Lines;

/// Rows of a slice.
pub const LANES: usize = 8;
/// Numbers of the rows of a slice.
pub type Slice = [f64; LANES];

/// Slices that lie where memory is read at once.
#[derive(Debug, Default)]
pub struct Slices(Lines<f64>);

impl Slices {
    pub fn new(of: &[Slice]) -> Self {
        let mut numbers = Lines::new(LANES * of.len());
        numbers.flat_mut().copy_from_slice(of.as_flattened());
        Self(numbers)
    }

    #[inline(always)]
    pub fn flat(&self) -> &[f64] {
        self.0.flat()
    }

    #[inline(always)]
    pub fn all(&self) -> &[Slice] {
        self.flat().as_chunks().0
    }

    pub fn all_mut(&mut self) -> &mut [Slice] {
        self.0.flat_mut().as_chunks_mut().0
    }
}
