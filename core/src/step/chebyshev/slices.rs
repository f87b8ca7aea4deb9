//! Numbers eight at a time, where memory is read at once.

/// Rows of a slice.
pub const LANES: usize = 8;
/// Numbers of the rows of a slice.
pub type Slice = [f64; LANES];
/// Bytes that memory comes in.
const LINE: usize = 64;

/// Slices that lie where memory is read at once.
#[derive(Debug, Default)]
pub struct Slices {
    numbers: Vec<f64>,
    first: usize,
    /// Slices.
    pub count: usize,
}

impl Slices {
    pub fn new(of: &[Slice]) -> Self {
        let mut numbers = vec![0.0; LANES * (of.len() + 1)];
        // Where the system does not say, anywhere will do.
        let first = numbers.as_ptr().align_offset(LINE).min(LANES);
        numbers[first..first + LANES * of.len()].copy_from_slice(of.as_flattened());
        Self { numbers, first, count: of.len() }
    }

    #[inline(always)]
    pub fn flat(&self) -> &[f64] {
        &self.numbers[self.first..self.first + LANES * self.count]
    }

    #[inline(always)]
    pub fn all(&self) -> &[Slice] {
        self.flat().as_chunks().0
    }

    pub fn all_mut(&mut self) -> &mut [Slice] {
        self.numbers[self.first..self.first + LANES * self.count].as_chunks_mut().0
    }
}
