//! PlanesMut of numbers of elements, cut by elements: several calls can write to them at once, each to those of its own.

use std::marker::PhantomData;
use std::ops::Range;

/// The numbers of a range of elements, each plane's apart from the others'.
#[derive(Debug)]
pub struct PlanesMut<'a> {
    base: *mut f64,
    /// PlanesMut, and elements of each.
    size: (usize, usize),
    range: Range<usize>,
    borrowed: PhantomData<&'a mut [f64]>,
}

#[allow(unsafe_code, reason = "stands for slices")]
// SAFETY: whoever has it has the numbers of its range alone, as with slices of them.
unsafe impl Send for PlanesMut<'_> {}

impl<'a> PlanesMut<'a> {
    /// All of `numbers` (planes x elements).
    ///
    /// # Panics
    /// If that is not how many there are.
    pub fn new(numbers: &'a mut [f64], planes: usize) -> Self {
        let count = numbers.len() / planes;
        assert_eq!(numbers.len(), planes * count);
        Self { base: numbers.as_mut_ptr(), size: (planes, count), range: 0..count, borrowed: PhantomData }
    }

    /// Whose they are.
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    /// Those of the elements before `at`, and those from it on.
    ///
    /// # Panics
    /// If it is none of them.
    pub fn part(self, at: usize) -> (Self, Self) {
        assert!(self.range.start <= at && at <= self.range.end);
        let (before, from) = (self.range.start..at, at..self.range.end);
        (Self { range: before, ..self.copy() }, Self { range: from, ..self })
    }

    fn copy(&self) -> Self {
        Self { base: self.base, size: self.size, range: self.range.clone(), borrowed: PhantomData }
    }

    /// Where the numbers of element 0 would be, for a call that writes those of `range` only.
    ///
    /// # Panics
    /// If it has not all of them, or there are other planes or elements.
    pub fn base_for(&mut self, range: &Range<usize>, size: (usize, usize)) -> *mut f64 {
        assert!(self.size == size && self.range.start <= range.start && range.end <= self.range.end);
        self.base
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_of_their_own_elements_alone() {
        let mut numbers = vec![0.0; 3 * 10];
        let base = numbers.as_mut_ptr();
        let (mut left, right) = PlanesMut::new(&mut numbers, 3).part(6);
        let (mut middle, _) = right.part(8);
        assert_eq!(left.base_for(&(2..6), (3, 10)), base);
        assert_eq!(middle.base_for(&(6..8), (3, 10)), base);
        let refuses = |planes: &mut PlanesMut<'_>, range: Range<usize>, size| {
            let asked = std::panic::AssertUnwindSafe(|| planes.base_for(&range, size));
            std::panic::catch_unwind(asked).is_err()
        };
        assert!(refuses(&mut left, 5..7, (3, 10)) && refuses(&mut middle, 7..9, (3, 10)));
        assert!(refuses(&mut middle, 6..8, (2, 10)));
    }
}
