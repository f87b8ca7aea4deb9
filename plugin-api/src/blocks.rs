//! Destination of stiffness: 3 x 3 blocks of the host's symmetric matrix, in double or single precision.

use crate::abi;
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// Index of the pair of corners (a, b), a <= b, among the pairs of an element with `corners` corners, which are counted
/// (0,0) (0,1) .. (0,k-1) (1,1) ..
pub const fn pair_index(a: usize, b: usize, corners: usize) -> usize {
    a * corners - a * (a + 1) / 2 + b
}

/// Scalar type of a block: `f64`, or `f32` for [`abi::HAS_SINGLE`].
pub trait BlockScalar: Copy + core::ops::AddAssign + core::ops::SubAssign {
    /// Whether the material writes diagonal blocks, of a node with itself. In single precision the host computes them.
    const HAS_DIAGONAL_BLOCKS: bool;
    /// `value`, rounded to the nearest value of this type.
    fn from_f64(value: f64) -> Self;
}

impl BlockScalar for f64 {
    const HAS_DIAGONAL_BLOCKS: bool = true;
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }
}

impl BlockScalar for f32 {
    const HAS_DIAGONAL_BLOCKS: bool = false;
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value as f32
    }
}

/// The blocks of the host's matrix that a call may add to, N/m.
pub struct Blocks<'a, T = f64> {
    /// Position and orientation of each pair's block (range x pairs), as [`abi::Blocks::slots`].
    slots: &'a [u32],
    /// Pairs of corners per element.
    pairs: usize,
    first_slot: usize,
    blocks: &'a mut [[T; 9]],
}

/// [`Blocks`] in single precision.
pub type SingleBlocks<'a> = Blocks<'a, f32>;

/// Slots and blocks of a call, for loops that index them directly.
pub struct BlockWindow<'a, T, const PAIRS: usize> {
    /// Slots of each element's pairs (range x PAIRS), as [`abi::Blocks::slots`]; empty if the elements do not have `PAIRS` pairs.
    pub slots: &'a [[u32; PAIRS]],
    /// The slot of `blocks[0]`.
    pub first_slot: usize,
    /// Row-major 3 x 3 blocks, N/m.
    pub blocks: &'a mut [[T; 9]],
}

impl<'a> Blocks<'a> {
    pub(crate) fn new(batch: &'a abi::Batch, raw: &'a abi::Blocks) -> Self {
        Self::from_raw(batch, raw.values.cast(), raw.slots, raw.slot_begin..raw.slot_end)
    }

    /// Adds the stiffness of a link (element `e` of this call) with the symmetric block K, N/m: K to both diagonal blocks, -K
    /// to the block between its nodes.
    #[inline]
    pub fn add_link(&mut self, e: usize, block: &[[f64; 3]; 3]) {
        self.add(e, pair_index(0, 0, 2), block);
        self.add(e, pair_index(0, 1, 2), &block.map(|row| row.map(|k| -k)));
        self.add(e, pair_index(1, 1, 2), block);
    }
}

impl<'a> SingleBlocks<'a> {
    pub(crate) fn new_single(batch: &'a abi::Batch, raw: &'a abi::SingleBlocks) -> Self {
        Self::from_raw(batch, raw.values.cast(), raw.slots, raw.slot_begin..raw.slot_end)
    }
}

impl<'a, T: BlockScalar> Blocks<'a, T> {
    /// The blocks `range` of `values`, and the slots of the elements of `batch`.
    #[allow(unsafe_code, reason = "turns the host's spans into slices")]
    fn from_raw(batch: &'a abi::Batch, values: *mut [T; 9], slots: *const u32, range: core::ops::Range<usize>) -> Self {
        let pairs = batch.corners as usize * (batch.corners as usize + 1) / 2;
        let first_slot = range.start;
        if values.is_null() || slots.is_null() || range.is_empty() {
            return Self { slots: &[], pairs, first_slot, blocks: Default::default() };
        }
        // SAFETY: the host gives `count * pairs` slots, and slot_end blocks of nine numbers of which this call alone uses
        // [slot_begin, slot_end).
        unsafe {
            let slots = from_raw_parts(slots.add(batch.begin * pairs), (batch.end - batch.begin) * pairs);
            let blocks = from_raw_parts_mut(values.wrapping_add(first_slot), range.len());
            Self { slots, pairs, first_slot, blocks }
        }
    }

    /// Adds a block (`block[row][column]`, N/m) to the pair of corners number `pair` (see [`pair_index`]) of element `e` of this
    /// call.
    ///
    /// # Panics
    /// If the element has no such pair.
    #[inline]
    pub fn add(&mut self, e: usize, pair: usize, block: &[[T; 3]; 3]) {
        let slot = self.slots[e * self.pairs + pair];
        let target = &mut self.blocks[(slot & !abi::TRANSPOSED) as usize - self.first_slot];
        let transposed = slot & abi::TRANSPOSED != 0;
        let mut sum = *target;
        for i in 0..3 {
            for j in 0..3 {
                sum[3 * i + j] += if transposed { block[j][i] } else { block[i][j] };
            }
        }
        *target = sum;
    }

    /// All slots and blocks of this call.
    pub fn window<const PAIRS: usize>(&mut self) -> BlockWindow<'_, T, PAIRS> {
        let slots = if self.pairs == PAIRS { self.slots.as_chunks().0 } else { &[] };
        BlockWindow { slots, first_slot: self.first_slot, blocks: self.blocks }
    }
}
