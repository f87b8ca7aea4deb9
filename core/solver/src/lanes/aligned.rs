//! Numbers that begin where memory is read at once.

use super::{LANES, Vectors};
use crate::threads::Parts;

/// Bytes that memory comes in.
const LINE: usize = 64;

/// Numbers that begin at the beginning of a line of memory.
#[derive(Debug, Default)]
pub struct Lines<T> {
    numbers: Vec<T>,
    first: usize,
    len: usize,
}

impl<T: Copy + Default> Lines<T> {
    /// So many zeros.
    pub fn new(len: usize) -> Self {
        let spare = LINE / size_of::<T>();
        let numbers = vec![T::default(); len + spare];
        // Where the system does not say, anywhere will do.
        let first = numbers.as_ptr().align_offset(LINE).min(spare);
        Self { numbers, first, len }
    }

    /// All of them.
    #[inline(always)]
    pub fn flat(&self) -> &[T] {
        &self.numbers[self.first..self.first + self.len]
    }

    /// All of them.
    #[inline(always)]
    pub fn flat_mut(&mut self) -> &mut [T] {
        &mut self.numbers[self.first..self.first + self.len]
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.numbers.len() * size_of::<T>()
    }
}

impl Lines<f32> {
    /// As vectors by sixteen.
    #[inline(always)]
    pub fn vectors(&self) -> &[Vectors] {
        self.flat().as_chunks().0.as_chunks().0
    }

    /// As vectors by sixteen.
    #[inline(always)]
    pub fn vectors_mut(&mut self) -> &mut [Vectors] {
        self.flat_mut().as_chunks_mut().0.as_chunks_mut().0
    }
}

/// Nodes, sixteen by sixteen.
pub struct Sixteens<'a, T>(pub &'a mut [T]);

impl<T: Send> Parts for Sixteens<'_, T> {
    fn count(&self) -> usize {
        LANES * self.0.len()
    }

    fn part(self, at: usize) -> (Self, Self) {
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
