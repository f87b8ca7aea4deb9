//! Plane-major data of elements, split by ranges of elements so that several threads write to it at once.

use std::marker::PhantomData;
use std::ops::Range;

/// The values of a range of elements in plane-major data (planes x elements).
#[derive(Debug)]
pub struct PlanesMut<'a> {
    base: *mut f64,
    plane_count: usize,
    /// Elements in each plane: the distance of two planes.
    element_count: usize,
    range: Range<usize>,
    borrowed: PhantomData<&'a mut [f64]>,
}

#[allow(unsafe_code, reason = "holds a raw pointer in the place of slices")]
// SAFETY: a `PlanesMut` alone has access to the values of its range, as a mutable slice of them would.
unsafe impl Send for PlanesMut<'_> {}

impl<'a> PlanesMut<'a> {
    /// All elements of `values` (plane_count x elements).
    ///
    /// # Panics
    /// If the length of `values` is not a multiple of `plane_count`.
    pub fn new(values: &'a mut [f64], plane_count: usize) -> Self {
        let element_count = values.len() / plane_count;
        assert_eq!(values.len(), plane_count * element_count, "planes of one length");
        Self { base: values.as_mut_ptr(), plane_count, element_count, range: 0..element_count, borrowed: PhantomData }
    }

    /// The elements this gives access to.
    pub fn range(&self) -> Range<usize> {
        self.range.clone()
    }

    /// Splits into the elements before element `middle` and those from it on.
    ///
    /// # Panics
    /// If `middle` lies outside the range.
    pub fn split_at(self, middle: usize) -> (Self, Self) {
        assert!(self.range.start <= middle && middle <= self.range.end, "{middle} lies outside {:?}", self.range);
        let (before, after) = (self.range.start..middle, middle..self.range.end);
        let Self { base, plane_count, element_count, borrowed, .. } = self;
        let part = |range| Self { base, plane_count, element_count, range, borrowed };
        (part(before), part(after))
    }

    /// Pointer to the value of element 0 in plane 0, for a call that writes the elements `range` only.
    ///
    /// # Panics
    /// If `range` is not part of this one's, or the data does not have `plane_count` planes of `element_count` elements.
    pub fn base_for(&mut self, range: &Range<usize>, plane_count: usize, element_count: usize) -> *mut f64 {
        assert_eq!((self.plane_count, self.element_count), (plane_count, element_count), "planes and elements");
        assert!(self.range.start <= range.start && range.end <= self.range.end, "{range:?} in {:?}", self.range);
        self.base
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_refuses_elements_of_another() {
        let mut values = vec![0.0; 3 * 10];
        let base = values.as_mut_ptr();
        let (mut left, right) = PlanesMut::new(&mut values, 3).split_at(6);
        let (mut middle, _) = right.split_at(8);
        assert_eq!(left.base_for(&(2..6), 3, 10), base);
        assert_eq!(middle.base_for(&(6..8), 3, 10), base);
        let refuses = |planes: &mut PlanesMut<'_>, range: Range<usize>, plane_count| {
            let call = std::panic::AssertUnwindSafe(|| planes.base_for(&range, plane_count, 10));
            std::panic::catch_unwind(call).is_err()
        };
        assert!(refuses(&mut left, 5..7, 3) && refuses(&mut middle, 7..9, 3));
        assert!(refuses(&mut middle, 6..8, 2));
    }
}
