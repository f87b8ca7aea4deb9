//! 3 x 3 blocks in registers, in double or single precision.
//!
//! Operations are on each entry by itself, and each is rounded, so every unit gives the same bytes.

use std::ops::{Add, Mul};

/// A precision of blocks: `f64` or `f32`.
pub trait Scalar: Copy + From<f32> + Add<Output = Self> + Mul<Output = Self> {}
impl Scalar for f64 {}
impl Scalar for f32 {}

/// A row-major block, or numbers that belong to its entries: the first eight in the registers `R`, and the last.
#[derive(Clone, Copy)]
pub struct WideBlock<R, T> {
    eight: R,
    last: T,
}

/// The row of each of the first eight entries.
pub const ROW: [u32; 8] = [0, 0, 0, 1, 1, 1, 2, 2];
/// The column of each of the first eight entries.
pub const COLUMN: [u32; 8] = [0, 1, 2, 0, 1, 2, 0, 1];
/// The entry that each of the first eight takes, without and with transposition.
pub const ENTRY: [[u32; 8]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7], [0, 3, 6, 1, 4, 7, 2, 5]];

/// A vector unit's operations on blocks in precision `T`. A unit implements those on the first eight entries.
pub trait BlockUnit<T: Scalar>: Copy {
    /// Eight numbers in its registers.
    type Eight: Copy;
    /// Loads from memory.
    fn load_eight(self, from: &[T; 8]) -> Self::Eight;
    /// Loads numbers in single precision.
    fn load_eight_f32(self, from: &[f32; 8]) -> Self::Eight;
    /// Stores to memory.
    fn store_eight(self, v: Self::Eight) -> [T; 8];
    /// `a + b`
    fn add_eight(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    /// `a b`
    fn mul_eight(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    /// The numbers at [`ROW`].
    fn at_rows(self, v: &[T; 4]) -> Self::Eight;
    /// The numbers at [`COLUMN`].
    fn at_columns(self, v: &[T; 4]) -> Self::Eight;
    /// The numbers at [`ENTRY`], of which `transposed` is the index: 0 or 1.
    fn at_entries(self, v: Self::Eight, transposed: usize) -> Self::Eight;

    /// Loads a block.
    #[inline(always)]
    fn load(self, block: &[T; 9]) -> WideBlock<Self::Eight, T> {
        let [a, b, c, d, e, f, g, h, last] = *block;
        WideBlock { eight: self.load_eight(&[a, b, c, d, e, f, g, h]), last }
    }

    /// Loads a block in single precision.
    #[inline(always)]
    fn load_f32(self, block: &[f32; 9]) -> WideBlock<Self::Eight, T> {
        let [a, b, c, d, e, f, g, h, last] = *block;
        WideBlock { eight: self.load_eight_f32(&[a, b, c, d, e, f, g, h]), last: T::from(last) }
    }

    /// Stores to memory.
    #[inline(always)]
    fn store(self, v: WideBlock<Self::Eight, T>) -> [T; 9] {
        let [a, b, c, d, e, f, g, h] = self.store_eight(v.eight);
        [a, b, c, d, e, f, g, h, v.last]
    }

    /// A block whose nine entries are `value`.
    #[inline(always)]
    fn splat(self, value: T) -> WideBlock<Self::Eight, T> {
        self.load(&[value; 9])
    }

    /// For each entry the component, of a padded vector, that its row names.
    #[inline(always)]
    fn by_row(self, v: &[T; 4]) -> WideBlock<Self::Eight, T> {
        WideBlock { eight: self.at_rows(v), last: v[2] }
    }

    /// For each entry the component, of a padded vector, that its column names.
    #[inline(always)]
    fn by_column(self, v: &[T; 4]) -> WideBlock<Self::Eight, T> {
        WideBlock { eight: self.at_columns(v), last: v[2] }
    }

    /// `a + b`
    #[inline(always)]
    fn add(self, a: WideBlock<Self::Eight, T>, b: WideBlock<Self::Eight, T>) -> WideBlock<Self::Eight, T> {
        WideBlock { eight: self.add_eight(a.eight, b.eight), last: a.last + b.last }
    }

    /// `a b`, entry by entry.
    #[inline(always)]
    fn mul(self, a: WideBlock<Self::Eight, T>, b: WideBlock<Self::Eight, T>) -> WideBlock<Self::Eight, T> {
        WideBlock { eight: self.mul_eight(a.eight, b.eight), last: a.last * b.last }
    }

    /// The transpose of a block if `transposed` is 1, or the block itself if it is 0. A number, for a branch on it cannot be predicted,
    /// and compilers make one of a bool.
    #[inline(always)]
    fn transpose_if(self, transposed: usize, v: WideBlock<Self::Eight, T>) -> WideBlock<Self::Eight, T> {
        WideBlock { eight: self.at_entries(v.eight, transposed), last: v.last }
    }
}
