//! Planes of doubles between guard planes, by which the suite finds reads and writes outside of them.

/// Values of m elements, plane-major, with a guard plane before and behind them that no material may read or write. Guards are zero at first.
#[derive(Clone, Debug, Default)]
pub(super) struct GuardedPlanes {
    /// One guard plane, the planes, one guard plane ((planes + 2) x m).
    values: Vec<f64>,
    /// Number of elements, m.
    count: usize,
}

impl GuardedPlanes {
    /// Planes of zeros of `count` elements.
    pub(super) fn new(planes: usize, count: usize) -> Self {
        Self { values: vec![0.0; (planes + 2) * count], count }
    }

    /// The planes without their guards (planes x m).
    pub(super) fn planes(&self) -> &[f64] {
        &self.values[self.count..self.values.len() - self.count]
    }

    /// As [`GuardedPlanes::planes`].
    pub(super) fn planes_mut(&mut self) -> &mut [f64] {
        let end = self.values.len() - self.count;
        &mut self.values[self.count..end]
    }

    /// Pointer to the first plane, or null where there is none.
    pub(super) fn as_ptr(&self) -> *const f64 {
        // Of the whole, so that a plugin that reads outside of the planes reads a guard.
        if self.planes().is_empty() { std::ptr::null() } else { self.values.as_ptr().wrapping_add(self.count) }
    }

    /// Sets every value of both guard planes.
    pub(super) fn set_guards(&mut self, value: f64) {
        let end = self.values.len() - self.count;
        self.values[..self.count].fill(value);
        self.values[end..].fill(value);
    }

    /// Bits of all values, those of the guards included.
    pub(super) fn bits(&self) -> impl Iterator<Item = u64> {
        self.values.iter().map(|v| v.to_bits())
    }
}
