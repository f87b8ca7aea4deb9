//! Transposes between structure-of-arrays registers (one number of several elements) and array-of-structures memory (several numbers of
//! one element).
//!
//! AVX2 and AVX-512 transpose within registers; other vector units go through memory. Apart from single additions nothing is
//! computed here, so the bytes do not depend on the vector unit.

#[cfg(target_arch = "x86_64")]
mod x86;

use crate::vector::Vec3;
use crate::wide_single::{MAX_SINGLE_LANES, WideSingle};
use core::any::Any;
use pliant_plugin_api::lanes::{MAX_LANES, Wide};
use pulp::Simd;
#[cfg(target_arch = "x86_64")]
use pulp::{
    bytemuck::cast,
    x86::{V3 as Avx2, V4 as Avx512},
};

/// `simd` as the vector unit `U`, if it is of that type. The compiler resolves this at compile time.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn downcast<S: Simd, U: Copy + 'static>(simd: S) -> Option<U> {
    (&simd as &dyn Any).downcast_ref().copied()
}

/// `simd` as a vector unit with AVX2, which AVX-512 includes.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn avx2<S: Simd>(simd: S) -> Option<Avx2> {
    match downcast::<S, Avx512>(simd) {
        Some(unit) => Some(*unit),
        None => downcast(simd),
    }
}

/// Vectors on nodes, to be read four numbers at a time.
#[derive(Clone, Copy)]
pub(crate) struct NodeVectorsView<'a> {
    flat: &'a [f64],
    /// The vector of the last node, padded: nothing follows it in memory.
    last: [f64; 4],
}

impl<'a> NodeVectorsView<'a> {
    #[inline(always)]
    pub(crate) fn new(vectors: &'a [[f64; 3]]) -> Self {
        let [x, y, z] = vectors.last().copied().unwrap_or_default();
        Self { flat: vectors.as_flattened(), last: [x, y, z, 0.0] }
    }

    /// The vector of a node, and a fourth number without meaning.
    #[inline(always)]
    fn padded(&self, node: u32) -> &[f64; 4] {
        let first = 3 * node as usize;
        match self.flat.get(first..first + 4).and_then(<[f64]>::first_chunk) {
            Some(padded) => padded,
            None => {
                assert_eq!(self.flat.len(), first + 3, "a corner is one of the nodes");
                &self.last
            }
        }
    }

    /// The vectors at one corner of as many elements as there are lanes.
    #[inline(always)]
    pub(crate) fn gather<S: Simd, const K: usize>(
        &self,
        simd: S,
        elements: &[[u32; K]],
        corner: usize,
    ) -> Vec3<Wide<S>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = downcast::<S, Avx512>(simd) {
            let mut pairs = [cast([0.0; 8]); 4];
            for k in 0..4 {
                let low = unit.avx512f._mm512_castpd256_pd512(cast(*self.padded(elements[k][corner])));
                pairs[k] = unit.avx512f._mm512_insertf64x4::<1>(low, cast(*self.padded(elements[k + 4][corner])));
            }
            let axes = x86::first_three_columns_f64(unit, pairs);
            return Vec3([Wide(cast(axes[0]), simd), Wide(cast(axes[1]), simd), Wide(cast(axes[2]), simd)]);
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = downcast::<S, Avx2>(simd) {
            let mut rows = [cast([0.0; 4]); 4];
            for k in 0..4 {
                rows[k] = cast(*self.padded(elements[k][corner]));
            }
            let axes = x86::transpose_4x4_f64(unit, rows);
            return Vec3([Wide(cast(axes[0]), simd), Wide(cast(axes[1]), simd), Wide(cast(axes[2]), simd)]);
        }
        let mut axes = [[0.0; MAX_LANES]; 3];
        for lane in 0..S::F64_LANES {
            let padded = self.padded(elements[lane][corner]);
            for i in 0..3 {
                axes[i][lane] = padded[i];
            }
        }
        Vec3([Wide::load(simd, &axes[0]), Wide::load(simd, &axes[1]), Wide::load(simd, &axes[2])])
    }
}

/// Eight numbers of each lane's element, from one register per number.
#[inline(always)]
pub(crate) fn lanes_to_rows<S: Simd>(simd: S, numbers: [Wide<S>; 8]) -> [[f64; 8]; MAX_LANES] {
    let mut rows = [[0.0; 8]; MAX_LANES];
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        let mut eight = [cast([0.0; 8]); 8];
        for k in 0..8 {
            eight[k] = cast(numbers[k].0);
        }
        let eight = x86::transpose_8x8_f64(unit, eight);
        for lane in 0..8 {
            rows[lane] = cast(eight[lane]);
        }
        return rows;
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = downcast::<S, Avx2>(simd) {
        for half in 0..2 {
            let mut four = [cast([0.0; 4]); 4];
            for k in 0..4 {
                four[k] = cast(numbers[4 * half + k].0);
            }
            let four = x86::transpose_4x4_f64(unit, four);
            for lane in 0..4 {
                rows[lane][4 * half..4 * half + 4].copy_from_slice(&cast::<_, [f64; 4]>(four[lane]));
            }
        }
        return rows;
    }
    for k in 0..8 {
        let lanes = numbers[k].to_array();
        for lane in 0..S::F64_LANES {
            rows[lane][k] = lanes[lane];
        }
    }
    rows
}

/// Rounds two registers of f64 to one of f32, `low` in its first lanes. Where f32 has no more lanes than f64, `high` is dropped.
#[inline(always)]
pub(crate) fn to_single<S: Simd>(low: Wide<S>, high: Wide<S>) -> WideSingle<S> {
    let simd = low.1;
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        let (low, high) = (unit.avx512f._mm512_cvtpd_ps(cast(low.0)), unit.avx512f._mm512_cvtpd_ps(cast(high.0)));
        let both = unit.avx512dq._mm512_insertf32x8::<1>(unit.avx512f._mm512_castps256_ps512(low), high);
        return WideSingle(cast(both), simd);
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = downcast::<S, Avx2>(simd) {
        let (low, high) = (unit.avx._mm256_cvtpd_ps(cast(low.0)), unit.avx._mm256_cvtpd_ps(cast(high.0)));
        return WideSingle(cast([low, high]), simd);
    }
    let (low, high, mut both) = (low.to_array(), high.to_array(), [0.0; MAX_SINGLE_LANES]);
    for lane in 0..S::F64_LANES {
        both[lane] = low[lane] as f32;
    }
    for lane in S::F64_LANES..S::F32_LANES {
        both[lane] = high[lane - S::F64_LANES] as f32;
    }
    WideSingle::load(simd, &both)
}

/// [`lanes_to_rows`] in single precision.
#[inline(always)]
pub(crate) fn single_lanes_to_rows<S: Simd>(simd: S, numbers: [WideSingle<S>; 8]) -> [[f32; 8]; MAX_SINGLE_LANES] {
    let mut rows = [[0.0; 8]; MAX_SINGLE_LANES];
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        let mut eight = [cast([0.0_f32; 16]); 8];
        for k in 0..8 {
            eight[k] = cast(numbers[k].0);
        }
        for (k, sixteen) in x86::transpose_8x16_f32(unit, eight).into_iter().enumerate() {
            let [low, high]: [[f32; 8]; 2] = cast(sixteen);
            (rows[k % 4 + k / 4 * 8], rows[k % 4 + k / 4 * 8 + 4]) = (low, high);
        }
        return rows;
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = downcast::<S, Avx2>(simd) {
        let mut eight = [cast([0.0_f32; 8]); 8];
        for k in 0..8 {
            eight[k] = cast(numbers[k].0);
        }
        for (lane, row) in x86::transpose_8x8_f32(unit, eight).into_iter().enumerate() {
            rows[lane] = cast(row);
        }
        return rows;
    }
    for k in 0..8 {
        let lanes = numbers[k].to_array();
        for lane in 0..S::F32_LANES {
            rows[lane][k] = lanes[lane];
        }
    }
    rows
}

/// For each of the first eight entries of a block, the entry it takes: without and with transposition. A table, because a branch on
/// the orientation of blocks cannot be predicted.
const ENTRY: [[u64; 8]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7], [0, 3, 6, 1, 4, 7, 2, 5]];
/// [`ENTRY`] as 32-bit indices.
const SINGLE_ENTRY: [[u32; 8]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7], [0, 3, 6, 1, 4, 7, 2, 5]];

/// A row-major 3 x 3 block: its first eight entries, and the ninth, which is the same in the transpose.
#[derive(Clone, Copy)]
pub(crate) struct SplitBlock<'a, T> {
    pub(crate) first: &'a [T; 8],
    pub(crate) last: T,
}

/// Adds a block, or its transpose, to `target`.
#[inline(always)]
pub(crate) fn add_block<S: Simd>(simd: S, target: &mut [f64; 9], block: SplitBlock<'_, f64>, transposed: bool) {
    let [a, b, c, d, e, f, g, h, i] = target;
    *i += block.last;
    let entry = &ENTRY[usize::from(transposed)];
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = downcast::<S, Avx512>(simd) {
        let eight = unit.avx512f._mm512_permutexvar_pd(cast(*entry), cast(*block.first));
        let sum: [f64; 8] = cast(unit.avx512f._mm512_add_pd(cast([*a, *b, *c, *d, *e, *f, *g, *h]), eight));
        [*a, *b, *c, *d, *e, *f, *g, *h] = sum;
        return;
    }
    for (k, target) in [a, b, c, d, e, f, g, h].into_iter().enumerate() {
        *target += block.first[entry[k] as usize];
    }
}

/// [`add_block`] in single precision.
#[inline(always)]
pub(crate) fn add_single_block<S: Simd>(simd: S, target: &mut [f32; 9], block: SplitBlock<'_, f32>, transposed: bool) {
    let [a, b, c, d, e, f, g, h, i] = target;
    *i += block.last;
    let entry = &SINGLE_ENTRY[usize::from(transposed)];
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = avx2(simd) {
        let eight = unit.avx2._mm256_permutevar8x32_ps(cast(*block.first), cast(*entry));
        let sum: [f32; 8] = cast(unit.avx._mm256_add_ps(cast([*a, *b, *c, *d, *e, *f, *g, *h]), eight));
        [*a, *b, *c, *d, *e, *f, *g, *h] = sum;
        return;
    }
    for (k, target) in [a, b, c, d, e, f, g, h].into_iter().enumerate() {
        *target += block.first[entry[k] as usize];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::WithSimd;

    fn wave(i: usize) -> f64 {
        (1.7 * i as f64).sin()
    }

    struct Transposes;

    impl WithSimd for Transposes {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let points: Vec<[f64; 3]> = (0..9).map(|i| [wave(3 * i), wave(3 * i + 1), wave(3 * i + 2)]).collect();
            let elements = [8, 0, 5, 8, 3, 1, 7, 6].map(|node| [2, node]);
            let axes = NodeVectorsView::new(&points).gather(simd, &elements[..S::F64_LANES], 1).0.map(Wide::to_array);
            for lane in 0..S::F64_LANES {
                assert_eq!(axes.map(|axis| axis[lane]), points[elements[lane][1] as usize], "{lane}");
            }
            let numbers: [[f64; 8]; 8] = std::array::from_fn(|k| std::array::from_fn(|lane| wave(8 * k + lane)));
            let rows = lanes_to_rows(simd, numbers.map(|lanes| Wide::load(simd, &lanes)));
            for lane in 0..S::F64_LANES {
                assert_eq!(rows[lane], numbers.map(|number| number[lane]), "{lane}");
            }
            for transposed in [false, true] {
                let mut target: [f64; 9] = std::array::from_fn(|i| wave(100 + i));
                add_block(simd, &mut target, SplitBlock { first: &rows[0], last: 5.0 }, transposed);
                let block = [rows[0].as_slice(), &[5.0]].concat();
                for (i, sum) in target.into_iter().enumerate() {
                    assert_eq!(sum, wave(100 + i) + block[if transposed { i % 3 * 3 + i / 3 } else { i }], "{i}");
                }
            }
        }
    }

    #[test]
    fn every_vector_unit_transposes_alike() {
        pulp::Arch::Scalar.dispatch(Transposes);
        pulp::Arch::new().dispatch(Transposes);
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = Avx2::try_new() {
            pulp::Arch::V3(unit).dispatch(Transposes);
        }
    }
}
