//! Where stiffness goes: blocks of the host's symmetric matrix, in one precision or the other.

use crate::abi;
use core::slice::{from_raw_parts, from_raw_parts_mut};

/// The number of the pair of corners (a, b), a <= b, among those of an element with `corners` corners.
pub const fn pair(a: usize, b: usize, corners: usize) -> usize {
    a * corners - a * (a + 1) / 2 + b
}

/// What a block is made of.
pub trait Entry: Copy + core::ops::AddAssign + core::ops::SubAssign {
    /// Whether blocks of one node with itself are wanted.
    const OF_ONE_NODE: bool;
    /// The nearest.
    fn of(value: f64) -> Self;
}

impl Entry for f64 {
    const OF_ONE_NODE: bool = true;
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }
}

impl Entry for f32 {
    const OF_ONE_NODE: bool = false;
    #[inline(always)]
    fn of(value: f64) -> Self {
        value as f32
    }
}

/// Where stiffness goes: the host's symmetric matrix of 3 x 3 blocks, N/m.
pub struct Blocks<'a, T = f64> {
    /// (range x pairs)
    slots: &'a [u32],
    pairs: usize,
    first: usize,
    window: &'a mut [[T; 9]],
}

/// The same in single precision.
pub type SingleBlocks<'a> = Blocks<'a, f32>;

impl<'a> Blocks<'a> {
    pub(crate) fn new(batch: &'a abi::Batch, raw: &'a abi::Blocks) -> Self {
        Self::of(batch, raw.values.cast(), raw.slots, [raw.slot_begin, raw.slot_end])
    }

    /// Adds what a link with the symmetric stiffness `block` gives its two nodes.
    #[inline]
    pub fn add_link(&mut self, e: usize, block: &[[f64; 3]; 3]) {
        self.add(e, pair(0, 0, 2), block);
        self.add(e, pair(0, 1, 2), &block.map(|row| row.map(|k| -k)));
        self.add(e, pair(1, 1, 2), block);
    }
}

impl<'a> SingleBlocks<'a> {
    pub(crate) fn single(batch: &'a abi::Batch, raw: &'a abi::SingleBlocks) -> Self {
        Self::of(batch, raw.values.cast(), raw.slots, [raw.slot_begin, raw.slot_end])
    }
}

impl<'a, T: Entry> Blocks<'a, T> {
    #[allow(unsafe_code, reason = "turns the host's spans into slices")]
    fn of(batch: &'a abi::Batch, values: *mut [T; 9], slots: *const u32, [first, end]: [usize; 2]) -> Self {
        let pairs = batch.corners as usize * (batch.corners as usize + 1) / 2;
        if values.is_null() || slots.is_null() || first == end {
            return Self { slots: &[], pairs, first, window: Default::default() };
        }
        // SAFETY: the host gives `count * pairs` slots, and slot_end blocks of nine numbers of which this call alone uses
        // [slot_begin, slot_end).
        unsafe {
            let slots = from_raw_parts(slots.add(batch.begin * pairs), (batch.end - batch.begin) * pairs);
            Self { slots, pairs, first, window: from_raw_parts_mut(values.wrapping_add(first), end - first) }
        }
    }

    /// Adds the block of corners (a, b), as numbered by [`pair`], of element `e` of this call.
    #[inline]
    pub fn add(&mut self, e: usize, pair: usize, block: &[[T; 3]; 3]) {
        let slot = self.slots[e * self.pairs + pair];
        let at = &mut self.window[(slot & !abi::TRANSPOSED) as usize - self.first];
        let transposed = slot & abi::TRANSPOSED != 0;
        let mut sum = *at;
        for i in 0..3 {
            for j in 0..3 {
                sum[3 * i + j] += if transposed { block[j][i] } else { block[i][j] };
            }
        }
        *at = sum;
    }

    /// Slots of each element's pairs (range x PAIRS), empty if it has not as many, the slot of the first block of the window, and
    /// the window itself (by rows), for loops that know what they do.
    pub fn window<const PAIRS: usize>(&mut self) -> (&[[u32; PAIRS]], usize, &mut [[T; 9]]) {
        let slots = if self.pairs == PAIRS { self.slots.as_chunks().0 } else { &[] };
        (slots, self.first, self.window)
    }
}
