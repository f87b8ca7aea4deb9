//! From elements side by side, one number of each in a register, to the numbers of an element side by side, and back.
//!
//! Registers are turned among themselves where the vector unit is known here, and through memory elsewhere. Nothing is computed but
//! single sums, so bytes do not depend on it.

use crate::single::{MAX_SINGLE_LANES, Single};
use crate::small::V3;
use core::any::Any;
use pliant_plugin_api::lanes::{MAX_LANES, Wide};
use pulp::Simd;
#[cfg(target_arch = "x86_64")]
use pulp::{
    bytemuck::cast,
    x86::{V3 as Avx2, V4 as Avx512},
};

/// The vector unit, if it is a certain one: known when this is compiled.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn known<S: Simd, U: Copy + 'static>(simd: S) -> Option<U> {
    (&simd as &dyn Any).downcast_ref().copied()
}

/// One that has what AVX2 has.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn avx2<S: Simd>(simd: S) -> Option<Avx2> {
    match known::<S, Avx512>(simd) {
        Some(unit) => Some(*unit),
        None => known(simd),
    }
}

/// What is known of each node, to be read four numbers at a time.
#[derive(Clone, Copy)]
pub(crate) struct Points<'a> {
    flat: &'a [f64],
    /// The last one, which has no number behind it.
    last: [f64; 4],
}

impl<'a> Points<'a> {
    #[inline(always)]
    pub(crate) fn new(of: &'a [V3]) -> Self {
        let [x, y, z] = of.last().copied().unwrap_or_default();
        Self { flat: of.as_flattened(), last: [x, y, z, 0.0] }
    }

    /// Of a node, and a number that means nothing.
    #[inline(always)]
    fn four(&self, node: u32) -> &[f64; 4] {
        let at = 3 * node as usize;
        match self.flat.get(at..at + 4).and_then(<[f64]>::first_chunk) {
            Some(four) => four,
            None => {
                assert_eq!(self.flat.len(), at + 3, "a corner is one of the nodes");
                &self.last
            }
        }
    }

    /// By axis, of a corner of as many elements as there are lanes.
    #[inline(always)]
    pub(crate) fn of<S: Simd, const K: usize>(&self, simd: S, elements: &[[u32; K]], corner: usize) -> V3<Wide<S>> {
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = known::<S, Avx512>(simd) {
            let mut pairs = [cast([0.0; 8]); 4];
            for k in 0..4 {
                let low = unit.avx512f._mm512_castpd256_pd512(cast(*self.four(elements[k][corner])));
                pairs[k] = unit.avx512f._mm512_insertf64x4::<1>(low, cast(*self.four(elements[k + 4][corner])));
            }
            let planes = x86::planes_of_eight(unit, pairs);
            return [Wide(cast(planes[0]), simd), Wide(cast(planes[1]), simd), Wide(cast(planes[2]), simd)];
        }
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = known::<S, Avx2>(simd) {
            let mut four = [cast([0.0; 4]); 4];
            for k in 0..4 {
                four[k] = cast(*self.four(elements[k][corner]));
            }
            let planes = x86::four(unit, four);
            return [Wide(cast(planes[0]), simd), Wide(cast(planes[1]), simd), Wide(cast(planes[2]), simd)];
        }
        let mut planes = [[0.0; MAX_LANES]; 3];
        for lane in 0..S::F64_LANES {
            let four = self.four(elements[lane][corner]);
            for i in 0..3 {
                planes[i][lane] = four[i];
            }
        }
        [Wide::load(simd, &planes[0]), Wide::load(simd, &planes[1]), Wide::load(simd, &planes[2])]
    }
}

/// Of eight numbers of each element, those of one by lane.
#[inline(always)]
pub(crate) fn rows<S: Simd>(simd: S, numbers: [Wide<S>; 8]) -> [[f64; 8]; MAX_LANES] {
    let mut rows = [[0.0; 8]; MAX_LANES];
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = known::<S, Avx512>(simd) {
        let mut eight = [cast([0.0; 8]); 8];
        for k in 0..8 {
            eight[k] = cast(numbers[k].0);
        }
        let eight = x86::eight(unit, eight);
        for lane in 0..8 {
            rows[lane] = cast(eight[lane]);
        }
        return rows;
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = known::<S, Avx2>(simd) {
        for half in 0..2 {
            let mut four = [cast([0.0; 4]); 4];
            for k in 0..4 {
                four[k] = cast(numbers[4 * half + k].0);
            }
            let four = x86::four(unit, four);
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

/// In single precision, one register behind the other; where there are no more lanes than in double precision, the first.
#[inline(always)]
pub(crate) fn rounded<S: Simd>(low: Wide<S>, high: Wide<S>) -> Single<S> {
    let simd = low.1;
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = known::<S, Avx512>(simd) {
        let (low, high) = (unit.avx512f._mm512_cvtpd_ps(cast(low.0)), unit.avx512f._mm512_cvtpd_ps(cast(high.0)));
        let both = unit.avx512dq._mm512_insertf32x8::<1>(unit.avx512f._mm512_castps256_ps512(low), high);
        return Single(cast(both), simd);
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = known::<S, Avx2>(simd) {
        let (low, high) = (unit.avx._mm256_cvtpd_ps(cast(low.0)), unit.avx._mm256_cvtpd_ps(cast(high.0)));
        return Single(cast([low, high]), simd);
    }
    let (low, high, mut both) = (low.to_array(), high.to_array(), [0.0; MAX_SINGLE_LANES]);
    for lane in 0..S::F64_LANES {
        both[lane] = low[lane] as f32;
    }
    for lane in S::F64_LANES..S::F32_LANES {
        both[lane] = high[lane - S::F64_LANES] as f32;
    }
    Single::load(simd, &both)
}

/// [`rows`] in single precision.
#[inline(always)]
pub(crate) fn single_rows<S: Simd>(simd: S, numbers: [Single<S>; 8]) -> [[f32; 8]; MAX_SINGLE_LANES] {
    let mut rows = [[0.0; 8]; MAX_SINGLE_LANES];
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = known::<S, Avx512>(simd) {
        let mut eight = [cast([0.0_f32; 16]); 8];
        for k in 0..8 {
            eight[k] = cast(numbers[k].0);
        }
        for (k, sixteen) in x86::sixteen_rows(unit, eight).into_iter().enumerate() {
            let [low, high]: [[f32; 8]; 2] = cast(sixteen);
            (rows[k % 4 + k / 4 * 8], rows[k % 4 + k / 4 * 8 + 4]) = (low, high);
        }
        return rows;
    }
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = known::<S, Avx2>(simd) {
        let mut eight = [cast([0.0_f32; 8]); 8];
        for k in 0..8 {
            eight[k] = cast(numbers[k].0);
        }
        for (lane, row) in x86::eight_rows(unit, eight).into_iter().enumerate() {
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

/// Where each of the first eight numbers of a block comes from, as it is and transposed: looked up, for which it is to be cannot
/// be guessed.
const PLACES: [[u64; 8]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7], [0, 3, 6, 1, 4, 7, 2, 5]];
const SINGLE_PLACES: [[u32; 8]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7], [0, 3, 6, 1, 4, 7, 2, 5]];

/// Adds a block, its last number apart, or its transpose.
#[inline(always)]
pub(crate) fn add<S: Simd>(simd: S, to: &mut [f64; 9], (eight, last): (&[f64; 8], f64), transposed: bool) {
    let [a, b, c, d, e, f, g, h, i] = to;
    *i += last;
    let places = &PLACES[usize::from(transposed)];
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = known::<S, Avx512>(simd) {
        let eight = unit.avx512f._mm512_permutexvar_pd(cast(*places), cast(*eight));
        let sum: [f64; 8] = cast(unit.avx512f._mm512_add_pd(cast([*a, *b, *c, *d, *e, *f, *g, *h]), eight));
        [*a, *b, *c, *d, *e, *f, *g, *h] = sum;
        return;
    }
    let to = [a, b, c, d, e, f, g, h];
    for (k, to) in to.into_iter().enumerate() {
        *to += eight[places[k] as usize];
    }
}

/// [`add`] in single precision.
#[inline(always)]
pub(crate) fn single_add<S: Simd>(simd: S, to: &mut [f32; 9], (eight, last): (&[f32; 8], f32), transposed: bool) {
    let [a, b, c, d, e, f, g, h, i] = to;
    *i += last;
    let places = &SINGLE_PLACES[usize::from(transposed)];
    #[cfg(target_arch = "x86_64")]
    if let Some(unit) = avx2(simd) {
        let eight = unit.avx2._mm256_permutevar8x32_ps(cast(*eight), cast(*places));
        let sum: [f32; 8] = cast(unit.avx._mm256_add_ps(cast([*a, *b, *c, *d, *e, *f, *g, *h]), eight));
        [*a, *b, *c, *d, *e, *f, *g, *h] = sum;
        return;
    }
    let to = [a, b, c, d, e, f, g, h];
    for (k, to) in to.into_iter().enumerate() {
        *to += eight[places[k] as usize];
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Avx2, Avx512, cast};
    use core::arch::x86_64::{__m256, __m256d, __m512, __m512d};

    /// Four rows become four columns.
    #[inline(always)]
    pub(super) fn four(unit: Avx2, rows: [__m256d; 4]) -> [__m256d; 4] {
        let ([a, b, c, d], unit) = (rows, unit.avx);
        let (even, odd) = (unit._mm256_unpacklo_pd(a, b), unit._mm256_unpackhi_pd(a, b));
        let (other_even, other_odd) = (unit._mm256_unpacklo_pd(c, d), unit._mm256_unpackhi_pd(c, d));
        [
            unit._mm256_permute2f128_pd::<0x20>(even, other_even),
            unit._mm256_permute2f128_pd::<0x20>(odd, other_odd),
            unit._mm256_permute2f128_pd::<0x31>(even, other_even),
            unit._mm256_permute2f128_pd::<0x31>(odd, other_odd),
        ]
    }

    /// Eight rows of sixteen become sixteen of eight: 0 and 4, 1 and 5, 2 and 6, 3 and 7, then the others.
    #[inline(always)]
    pub(super) fn sixteen_rows(unit: Avx512, [a, b, c, d, e, f, g, h]: [__m512; 8]) -> [__m512; 8] {
        const LOW: [u32; 16] = [0, 1, 2, 3, 16, 17, 18, 19, 4, 5, 6, 7, 20, 21, 22, 23];
        const HIGH: [u32; 16] = [8, 9, 10, 11, 24, 25, 26, 27, 12, 13, 14, 15, 28, 29, 30, 31];
        let (left, right) = (quarters(unit, [a, b, c, d]), quarters(unit, [e, f, g, h]));
        let mut out = [a; 8];
        for k in 0..4 {
            out[k] = unit.avx512f._mm512_permutex2var_ps(left[k], cast(LOW), right[k]);
            out[4 + k] = unit.avx512f._mm512_permutex2var_ps(left[k], cast(HIGH), right[k]);
        }
        out
    }

    /// In each quarter, four rows become four columns.
    #[inline(always)]
    fn quarters(unit: Avx512, [a, b, c, d]: [__m512; 4]) -> [__m512; 4] {
        let avx = unit.avx512f;
        let (ab, other_ab) = (cast(avx._mm512_unpacklo_ps(a, b)), cast(avx._mm512_unpackhi_ps(a, b)));
        let (cd, other_cd) = (cast(avx._mm512_unpacklo_ps(c, d)), cast(avx._mm512_unpackhi_ps(c, d)));
        [
            cast(avx._mm512_unpacklo_pd(ab, cd)),
            cast(avx._mm512_unpackhi_pd(ab, cd)),
            cast(avx._mm512_unpacklo_pd(other_ab, other_cd)),
            cast(avx._mm512_unpackhi_pd(other_ab, other_cd)),
        ]
    }

    /// Eight rows of eight become eight columns.
    #[inline(always)]
    pub(super) fn eight_rows(unit: Avx2, [a, b, c, d, e, f, g, h]: [__m256; 8]) -> [__m256; 8] {
        let (left, right) = (halves(unit, [a, b, c, d]), halves(unit, [e, f, g, h]));
        let mut out = [a; 8];
        for k in 0..4 {
            out[k] = unit.avx._mm256_permute2f128_ps::<0x20>(left[k], right[k]);
            out[4 + k] = unit.avx._mm256_permute2f128_ps::<0x31>(left[k], right[k]);
        }
        out
    }

    /// In each half, four rows become four columns.
    #[inline(always)]
    fn halves(unit: Avx2, [a, b, c, d]: [__m256; 4]) -> [__m256; 4] {
        let avx = unit.avx;
        let (ab, other_ab) = (cast(avx._mm256_unpacklo_ps(a, b)), cast(avx._mm256_unpackhi_ps(a, b)));
        let (cd, other_cd) = (cast(avx._mm256_unpacklo_ps(c, d)), cast(avx._mm256_unpackhi_ps(c, d)));
        [
            cast(avx._mm256_unpacklo_pd(ab, cd)),
            cast(avx._mm256_unpackhi_pd(ab, cd)),
            cast(avx._mm256_unpacklo_pd(other_ab, other_cd)),
            cast(avx._mm256_unpackhi_pd(other_ab, other_cd)),
        ]
    }

    /// The first three columns of rows 0 and 4, 1 and 5, 2 and 6, 3 and 7.
    #[inline(always)]
    pub(super) fn planes_of_eight(unit: Avx512, [a, b, c, d]: [__m512d; 4]) -> [__m512d; 3] {
        const FIRST: [u64; 8] = [0, 1, 8, 9, 4, 5, 12, 13];
        const THIRD: [u64; 8] = [2, 3, 10, 11, 6, 7, 14, 15];
        let unit = unit.avx512f;
        let (even, odd) = (unit._mm512_unpacklo_pd(a, b), unit._mm512_unpackhi_pd(a, b));
        let (other_even, other_odd) = (unit._mm512_unpacklo_pd(c, d), unit._mm512_unpackhi_pd(c, d));
        [
            unit._mm512_permutex2var_pd(even, cast(FIRST), other_even),
            unit._mm512_permutex2var_pd(odd, cast(FIRST), other_odd),
            unit._mm512_permutex2var_pd(even, cast(THIRD), other_even),
        ]
    }

    /// Eight rows become eight columns.
    #[inline(always)]
    pub(super) fn eight(unit: Avx512, rows: [__m512d; 8]) -> [__m512d; 8] {
        let ([a, b, c, d, e, f, g, h], avx) = (rows, unit.avx512f);
        let even = [
            avx._mm512_unpacklo_pd(a, b),
            avx._mm512_unpacklo_pd(c, d),
            avx._mm512_unpacklo_pd(e, f),
            avx._mm512_unpacklo_pd(g, h),
        ];
        let odd = [
            avx._mm512_unpackhi_pd(a, b),
            avx._mm512_unpackhi_pd(c, d),
            avx._mm512_unpackhi_pd(e, f),
            avx._mm512_unpackhi_pd(g, h),
        ];
        let ([a, c, e, g], [b, d, f, h]) = (pairs(unit, even), pairs(unit, odd));
        [a, b, c, d, e, f, g, h]
    }

    /// The same for four rows of pairs.
    #[inline(always)]
    fn pairs(unit: Avx512, [a, b, c, d]: [__m512d; 4]) -> [__m512d; 4] {
        let unit = unit.avx512f;
        let (low, high) =
            (unit._mm512_shuffle_f64x2::<0b01_00_01_00>(a, b), unit._mm512_shuffle_f64x2::<0b11_10_11_10>(a, b));
        let (other_low, other_high) =
            (unit._mm512_shuffle_f64x2::<0b01_00_01_00>(c, d), unit._mm512_shuffle_f64x2::<0b11_10_11_10>(c, d));
        [
            unit._mm512_shuffle_f64x2::<0b10_00_10_00>(low, other_low),
            unit._mm512_shuffle_f64x2::<0b11_01_11_01>(low, other_low),
            unit._mm512_shuffle_f64x2::<0b10_00_10_00>(high, other_high),
            unit._mm512_shuffle_f64x2::<0b11_01_11_01>(high, other_high),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::WithSimd;

    fn wave(i: usize) -> f64 {
        (1.7 * i as f64).sin()
    }

    struct Turns;

    impl WithSimd for Turns {
        type Output = ();

        fn with_simd<S: Simd>(self, simd: S) {
            let points: Vec<[f64; 3]> = (0..9).map(|i| [wave(3 * i), wave(3 * i + 1), wave(3 * i + 2)]).collect();
            let elements = [8, 0, 5, 8, 3, 1, 7, 6].map(|node| [2, node]);
            let planes = Points::new(&points).of(simd, &elements[..S::F64_LANES], 1).map(Wide::to_array);
            for lane in 0..S::F64_LANES {
                assert_eq!(planes.map(|plane| plane[lane]), points[elements[lane][1] as usize], "{lane}");
            }
            let numbers: [[f64; 8]; 8] = std::array::from_fn(|k| std::array::from_fn(|lane| wave(8 * k + lane)));
            let rows = rows(simd, numbers.map(|lanes| Wide::load(simd, &lanes)));
            for lane in 0..S::F64_LANES {
                assert_eq!(rows[lane], numbers.map(|number| number[lane]), "{lane}");
            }
            for transposed in [false, true] {
                let mut to: [f64; 9] = std::array::from_fn(|i| wave(100 + i));
                add(simd, &mut to, (&rows[0], 5.0), transposed);
                let block = [rows[0].as_slice(), &[5.0]].concat();
                for (i, to) in to.into_iter().enumerate() {
                    assert_eq!(to, wave(100 + i) + block[if transposed { i % 3 * 3 + i / 3 } else { i }], "{i}");
                }
            }
        }
    }

    #[test]
    fn every_vector_unit_turns_alike() {
        pulp::Arch::Scalar.dispatch(Turns);
        pulp::Arch::new().dispatch(Turns);
        #[cfg(target_arch = "x86_64")]
        if let Some(unit) = Avx2::try_new() {
            pulp::Arch::V3(unit).dispatch(Turns);
        }
    }
}
