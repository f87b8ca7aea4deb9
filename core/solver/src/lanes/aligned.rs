//! Buffers aligned to cache lines.

use super::{LANES, Vectors};
use crate::threads::Splittable;

/// Bytes of a cache line.
const LINE: usize = 64;

/// A buffer that begins at a cache line.
#[derive(Debug, Default)]
pub struct Lines<T> {
    numbers: Vec<T>,
    first: usize,
    len: usize,
}

impl<T: Copy + Default> Lines<T> {
    /// A buffer of `len` zeros.
    pub fn new(len: usize) -> Self {
        let spare = LINE / size_of::<T>();
        let numbers = vec![T::default(); len + spare];
        // If the alignment is not known, any place is correct.
        let first = numbers.as_ptr().align_offset(LINE).min(spare);
        Self { numbers, first, len }
    }

    /// All scalars, in the order of the blocks.
    #[inline(always)]
    pub fn flat(&self) -> &[T] {
        &self.numbers[self.first..self.first + self.len]
    }

    /// All scalars, in the order of the blocks, to be changed.
    #[inline(always)]
    pub fn flat_mut(&mut self) -> &mut [T] {
        &mut self.numbers[self.first..self.first + self.len]
    }

    /// Memory of the scalars, bytes.
    pub fn bytes(&self) -> usize {
        self.numbers.len() * size_of::<T>()
    }
}

impl Lines<f32> {
    /// The numbers as vectors by sixteen.
    #[inline(always)]
    pub fn vectors(&self) -> &[Vectors] {
        self.flat().as_chunks().0.as_chunks().0
    }

    /// The numbers as vectors by sixteen.
    #[inline(always)]
    pub fn vectors_mut(&mut self) -> &mut [Vectors] {
        self.flat_mut().as_chunks_mut().0.as_chunks_mut().0
    }
}

/// Items of sixteen nodes each, split at multiples of sixteen.
pub struct Sixteens<'a, T>(pub &'a mut [T]);

impl<T: Send> Splittable for Sixteens<'_, T> {
    fn count(&self) -> usize {
        LANES * self.0.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let (left, right) = self.0.split_at_mut(at / LANES);
        (Self(left), Self(right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_begin_where_memory_is_read_at_once() {
        for len in [1, 16, 1000] {
            let mut lines = Lines::<f32>::new(len);
            assert_eq!(lines.flat().as_ptr().align_offset(LINE), 0);
            assert!(lines.flat() == vec![0.0; len] && lines.flat_mut().len() == len && lines.bytes() >= 4 * len);
        }
    }
}
