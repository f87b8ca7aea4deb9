//! What hinges give a matrix in single precision: [`super::outer`] without blocks of the diagonal.

use super::outer::{GROUP, Hinges};
use super::single::SingleBlock;
use pliant_plugin_api::abi;

/// Slots of a hinge, and which of them are of two corners.
const PAIRS: usize = 10;
const BETWEEN: [(usize, usize, usize); 6] = [(1, 0, 1), (2, 0, 2), (3, 0, 3), (5, 1, 2), (6, 1, 3), (8, 2, 3)];
/// Gradients of a hinge, read eight numbers at a time.
type Numbers = [f32; 20];

/// Adds `k g g^T` of each hinge where `slots` (hinges x 10) say; `first` is the slot of the first of `blocks`.
pub fn add_outer(slots: &[u32], first: usize, blocks: &mut [SingleBlock], hinges: &impl Hinges) {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(wide::Outer { simd, slots, first, blocks, hinges });
    }
    add_each(slots, first, blocks, hinges);
}

/// The portable path.
fn add_each(slots: &[u32], first: usize, blocks: &mut [SingleBlock], hinges: &impl Hinges) {
    for (e, slots) in slots.as_chunks::<PAIRS>().0.iter().enumerate() {
        let (numbers, k) = rounded(hinges, e);
        for (pair, a, b) in BETWEEN {
            let (to, transposed) = place(slots[pair], first, blocks);
            for i in 0..3 {
                for j in 0..3 {
                    let at = if transposed { 3 * j + i } else { 3 * i + j };
                    to[at] += (k * numbers[3 * a + i]) * numbers[3 * b + j];
                }
            }
        }
    }
}

#[inline(always)]
fn rounded(hinges: &impl Hinges, e: usize) -> (Numbers, f32) {
    let (g, k) = hinges.hinge(e);
    let mut numbers = [0.0; 20];
    for corner in 0..4 {
        for i in 0..3 {
            numbers[3 * corner + i] = g[corner][i] as f32;
        }
    }
    (numbers, k as f32)
}

/// Where a block is stored, and whether it is transposed there.
#[inline(always)]
fn place(slot: u32, first: usize, blocks: &mut [SingleBlock]) -> (&mut SingleBlock, bool) {
    (&mut blocks[(slot & !abi::TRANSPOSED) as usize - first], slot & abi::TRANSPOSED != 0)
}

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{BETWEEN, GROUP, Hinges, Numbers, PAIRS, SingleBlock, place, rounded};
    use pulp::cast;
    use pulp::x86::V3;
    use std::arch::x86_64::{__m128, __m256};

    /// Which of a corner's numbers the first eight of a block are made of, on the left and on the right.
    const LEFT: [u32; 8] = [0, 0, 0, 1, 1, 1, 2, 2];
    const RIGHT: [u32; 8] = [0, 1, 2, 0, 1, 2, 0, 1];
    /// Where each of the first eight comes from, as it is and transposed: looked up, for which it is to be cannot be guessed.
    const PLACES: [[u32; 8]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7], [0, 3, 6, 1, 4, 7, 2, 5]];

    pub struct Outer<'a, H> {
        pub simd: V3,
        pub slots: &'a [u32],
        pub first: usize,
        pub blocks: &'a mut [SingleBlock],
        pub hinges: &'a H,
    }

    impl<H: Hinges> pulp::NullaryFnOnce for Outer<'_, H> {
        type Output = ();

        #[inline(always)]
        fn call(self) {
            let Self { simd, slots, first, blocks, hinges } = self;
            let (mut numbers, mut factors) = ([[0.0; 20]; GROUP], [0.0; GROUP]);
            let (groups, rest) = slots.as_chunks::<PAIRS>().0.as_chunks::<GROUP>();
            for (at, slots) in groups.iter().enumerate() {
                let (planes, k) = hinges.eight(GROUP * at);
                turned(simd, &planes, &mut numbers);
                for lane in 0..GROUP {
                    factors[lane] = k[lane] as f32;
                }
                for (slots, (numbers, k)) in slots.iter().zip(numbers.iter().zip(&factors)) {
                    add(simd, slots, first, blocks, (numbers, *k));
                }
            }
            for (slots, e) in rest.iter().zip(GROUP * groups.len()..) {
                let (numbers, k) = rounded(hinges, e);
                add(simd, slots, first, blocks, (&numbers, k));
            }
        }
    }

    /// Rounds what is there plane by plane, and puts it hinge by hinge.
    #[inline(always)]
    fn turned(simd: V3, planes: &[[f64; GROUP]; 12], to: &mut [Numbers; GROUP]) {
        for (quarter, half) in (0..3).flat_map(|quarter| [(quarter, 0), (quarter, 1)]) {
            let mut four: [__m128; 4] = [cast([0.0_f32; 4]); 4];
            for k in 0..4 {
                let [low, high]: [[f64; 4]; 2] = cast(planes[4 * quarter + k]);
                four[k] = simd.avx._mm256_cvtpd_ps(cast(if half == 0 { low } else { high }));
            }
            let ([a, b, c, d], sse) = (four, simd.sse);
            let (ab, other_ab) = (sse._mm_unpacklo_ps(a, b), sse._mm_unpackhi_ps(a, b));
            let (cd, other_cd) = (sse._mm_unpacklo_ps(c, d), sse._mm_unpackhi_ps(c, d));
            let rows: [[f32; 4]; 4] = [
                cast(sse._mm_movelh_ps(ab, cd)),
                cast(sse._mm_movehl_ps(cd, ab)),
                cast(sse._mm_movelh_ps(other_ab, other_cd)),
                cast(sse._mm_movehl_ps(other_cd, other_ab)),
            ];
            for lane in 0..4 {
                to[4 * half + lane][4 * quarter..4 * quarter + 4].copy_from_slice(&rows[lane]);
            }
        }
    }

    #[inline(always)]
    fn add(simd: V3, slots: &[u32; PAIRS], first: usize, blocks: &mut [SingleBlock], (numbers, k): (&Numbers, f32)) {
        let factor = simd.avx._mm256_set1_ps(k);
        let (mut left, mut right) = ([factor; 4], [factor; 4]);
        for corner in 0..4 {
            let eight: &[f32; 8] = numbers[3 * corner..].first_chunk().expect("eight from each corner on");
            left[corner] = simd.avx._mm256_mul_ps(factor, spread(simd, cast(*eight), LEFT));
            right[corner] = spread(simd, cast(*eight), RIGHT);
        }
        for (pair, a, b) in BETWEEN {
            let (to, transposed) = place(slots[pair], first, blocks);
            let more = spread(simd, simd.avx._mm256_mul_ps(left[a], right[b]), PLACES[usize::from(transposed)]);
            let [c0, c1, c2, c3, c4, c5, c6, c7, c8] = to;
            let eight: __m256 = cast([*c0, *c1, *c2, *c3, *c4, *c5, *c6, *c7]);
            let sum: [f32; 8] = cast(simd.avx._mm256_add_ps(eight, more));
            [*c0, *c1, *c2, *c3, *c4, *c5, *c6, *c7] = sum;
            *c8 += (k * numbers[3 * a + 2]) * numbers[3 * b + 2];
        }
    }

    #[inline(always)]
    fn spread(simd: V3, numbers: __m256, places: [u32; 8]) -> __m256 {
        simd.avx2._mm256_permutevar8x32_ps(numbers, cast(places))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::V3;

    fn wave(i: usize) -> f64 {
        (1.7 * i as f64).sin() * 10_f64.powi((i % 7) as i32 - 3)
    }

    struct Waves;

    impl Hinges for Waves {
        #[inline(always)]
        fn hinge(&self, e: usize) -> ([V3; 4], f64) {
            (std::array::from_fn(|a| std::array::from_fn(|i| wave(12 * e + 3 * a + i))), wave(900 + e))
        }
    }

    #[test]
    fn every_vector_unit_gives_the_same_bytes_and_the_products() {
        // Several hinges to a block, some of them turned.
        let slots: Vec<u32> = (0..190).map(|i| 5 + i * 7 % 23 + if i % 3 == 1 { abi::TRANSPOSED } else { 0 }).collect();
        let mut blocks: Vec<SingleBlock> =
            (0..23).map(|b| std::array::from_fn(|i| wave(2000 + 9 * b + i) as f32)).collect();
        let mut want: Vec<[f64; 9]> = blocks.iter().map(|block| block.map(f64::from)).collect();
        let (mut size, mut plain) = (want.clone(), blocks.clone());
        add_outer(&slots, 5, &mut blocks, &Waves);
        add_each(&slots, 5, &mut plain, &Waves);
        let bits = |blocks: &[SingleBlock]| blocks.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&blocks), bits(&plain));
        for (e, (pair, a, b)) in (0..19).flat_map(|e| BETWEEN.map(|pair| (e, pair))) {
            let ((g, k), slot) = (Waves.hinge(e), slots[10 * e + pair]);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let at = if slot & abi::TRANSPOSED == 0 { 3 * i + j } else { 3 * j + i };
                let (block, term) = ((slot & !abi::TRANSPOSED) as usize - 5, k * g[a][i] * g[b][j]);
                want[block][at] += term;
                size[block][at] = size[block][at].abs() + term.abs();
            }
        }
        for (got, (want, size)) in plain.iter().flatten().zip(want.iter().flatten().zip(size.iter().flatten())) {
            assert!((f64::from(*got) - want).abs() < 1e-6 * size.abs(), "{got} {want}");
        }
    }
}
