//! From one register for each of eight numbers to the eight numbers of each lane, and to blocks of a matrix.

#[cfg(target_arch = "x86_64")]
use super::x86;
use super::{MAX_LANES, MAX_SINGLE_LANES, SingleWide, Wide};
use crate::{BlockScalar, abi};
use pulp::Simd;

impl<S: Simd> Wide<S> {
    /// Eight numbers of each lane, from one register for each number. Rows past the last lane are zero.
    #[inline(always)]
    pub fn rows(numbers: [Self; 8]) -> [[f64; 8]; MAX_LANES] {
        #[cfg(target_arch = "x86_64")]
        if let Some(rows) = x86::rows(numbers[0].1, numbers) {
            return rows;
        }
        let mut rows = [[0.0; 8]; MAX_LANES];
        for k in 0..8 {
            let lanes = numbers[k].to_array();
            for lane in 0..S::F64_LANES {
                rows[lane][k] = lanes[lane];
            }
        }
        rows
    }
}

impl<S: Simd> SingleWide<S> {
    /// Two registers in double precision, rounded, `low` in the first lanes. On units with as many lanes for either precision `high` is
    /// dropped.
    #[inline(always)]
    pub fn round(low: Wide<S>, high: Wide<S>) -> Self {
        #[cfg(target_arch = "x86_64")]
        if let Some(rounded) = x86::round(low.1, [low, high]) {
            return rounded;
        }
        let (wide, mut both) = ([low.to_array(), high.to_array()], [0.0; MAX_SINGLE_LANES]);
        for lane in 0..S::F32_LANES {
            both[lane] = wide[lane / S::F64_LANES][lane % S::F64_LANES] as f32;
        }
        Self::load(low.1, &both)
    }

    /// [`Wide::rows`] in single precision.
    #[inline(always)]
    pub fn rows(numbers: [Self; 8]) -> [[f32; 8]; MAX_SINGLE_LANES] {
        #[cfg(target_arch = "x86_64")]
        if let Some(rows) = x86::single_rows(numbers[0].1, numbers) {
            return rows;
        }
        let mut rows = [[0.0; 8]; MAX_SINGLE_LANES];
        for k in 0..8 {
            let lanes = numbers[k].to_array();
            for lane in 0..S::F32_LANES {
                rows[lane][k] = lanes[lane];
            }
        }
        rows
    }
}

/// For each of the first eight entries of a block the entry it takes, without and with transposition.
const ENTRY: [[u32; 8]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7], [0, 3, 6, 1, 4, 7, 2, 5]];

/// A row-major 3 x 3 block: its first eight entries, and the ninth, which is the same in the transpose.
#[derive(Clone, Copy)]
pub struct SplitBlock<'a, T> {
    /// Entries 0 to 7, row by row.
    pub first: &'a [T; 8],
    /// Entry 8, in the last row and column.
    pub last: T,
}

/// Scalar type of the blocks that [`add_block`] adds.
pub trait RowScalar: BlockScalar {
    /// `to` plus the entries of `eight` at the given places, by vector instructions; `None` on units that have none for it.
    #[doc(hidden)]
    fn add_eight<S: Simd>(simd: S, to: [Self; 8], eight: &[Self; 8], places: &[u32; 8]) -> Option<[Self; 8]>;
}

impl RowScalar for f64 {
    #[inline(always)]
    fn add_eight<S: Simd>(simd: S, to: [f64; 8], eight: &[f64; 8], places: &[u32; 8]) -> Option<[f64; 8]> {
        #[cfg(target_arch = "x86_64")]
        return x86::add_eight_f64(simd, to, eight, places);
        #[cfg(not(target_arch = "x86_64"))]
        None
    }
}

impl RowScalar for f32 {
    #[inline(always)]
    fn add_eight<S: Simd>(simd: S, to: [f32; 8], eight: &[f32; 8], places: &[u32; 8]) -> Option<[f32; 8]> {
        #[cfg(target_arch = "x86_64")]
        return x86::add_eight_f32(simd, to, eight, places);
        #[cfg(not(target_arch = "x86_64"))]
        None
    }
}

/// Adds a block to the one in `slot` of a matrix, transposed where [`abi::TRANSPOSED`] is set; `first_slot` is the slot of `blocks[0]`.
///
/// # Panics
/// If the slot is not one of the blocks.
#[inline(always)]
pub fn add_block<S: Simd, T: RowScalar>(
    simd: S,
    blocks: &mut [[T; 9]],
    first_slot: usize,
    slot: u32,
    block: SplitBlock<'_, T>,
) {
    // An index, for a branch on the orientation cannot be predicted, and compilers make one of a bool.
    let places = &ENTRY[(slot / abi::TRANSPOSED) as usize];
    let [a, b, c, d, e, f, g, h, last] = &mut blocks[(slot & !abi::TRANSPOSED) as usize - first_slot];
    *last += block.last;
    if let Some(sums) = T::add_eight(simd, [*a, *b, *c, *d, *e, *f, *g, *h], block.first, places) {
        [*a, *b, *c, *d, *e, *f, *g, *h] = sums;
        return;
    }
    for (place, entry) in places.iter().zip([a, b, c, d, e, f, g, h]) {
        *entry += block.first[*place as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::units;
    use pulp::WithSimd;

    struct Rows;

    impl WithSimd for Rows {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let wave = |i: usize| (1.7 * i as f64).sin();
            let numbers: [[f64; 16]; 8] = std::array::from_fn(|k| std::array::from_fn(|lane| wave(16 * k + lane)));
            let rows = Wide::rows(numbers.map(|lanes| Wide::load(simd, &lanes)));
            for lane in 0..S::F64_LANES {
                assert_eq!(rows[lane], numbers.map(|number| number[lane]), "{lane}");
            }
            let single = SingleWide::rows(numbers.map(|lanes| {
                let high = &lanes[S::F64_LANES..];
                SingleWide::round(Wide::load(simd, &lanes), Wide::load(simd, high))
            }));
            for lane in 0..S::F32_LANES {
                assert_eq!(single[lane], numbers.map(|number| number[lane] as f32), "{lane}");
            }
            sums(simd, &rows[0]);
            sums(simd, &single[0]);
        }
    }

    fn sums<S: Simd, T: RowScalar + PartialEq + core::fmt::Debug>(simd: S, first: &[T; 8]) {
        let last = T::from_f64(5.0);
        let block = [&first[..], &[last]].concat();
        for (slot, transposed) in [(7, false), (7 | abi::TRANSPOSED, true)] {
            let mut blocks = [1.0, 2.0].map(|of| std::array::from_fn(|i| T::from_f64(of * i as f64)));
            add_block(simd, &mut blocks, 6, slot, SplitBlock { first, last });
            for i in 0..9 {
                let mut want = T::from_f64(2.0 * i as f64);
                want += block[if transposed { i % 3 * 3 + i / 3 } else { i }];
                assert_eq!((blocks[0][i], blocks[1][i]), (T::from_f64(i as f64), want), "{i}");
            }
        }
    }

    #[test]
    fn every_vector_unit_transposes_and_adds() {
        units().into_iter().for_each(|unit| unit.dispatch(Rows));
    }
}
