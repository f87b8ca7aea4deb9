//! Assembly of hinges with AVX2: eight of the nine entries of a block at once.

use super::{BETWEEN, GROUP, HingeAssembly, Hinges, Numbers, PAIRS, SingleBlock, place, prefetch_slots, rounded};
use pulp::cast;
use pulp::x86::V3;
use std::arch::x86_64::{__m128, __m256};

/// Components of a corner's gradient that are the left factors of the first eight entries of a block.
const LEFT: [u32; 8] = [0, 0, 0, 1, 1, 1, 2, 2];
/// Components that are the right factors.
const RIGHT: [u32; 8] = [0, 1, 2, 0, 1, 2, 0, 1];
/// Entry that each of the first eight becomes, without and with transposition. A table, because a branch on it cannot be predicted.
const PLACES: [[u32; 8]; 2] = [[0, 1, 2, 3, 4, 5, 6, 7], [0, 3, 6, 1, 4, 7, 2, 5]];

impl<H: Hinges> pulp::NullaryFnOnce for HingeAssembly<'_, V3, f32, H> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { simd, slots, first, blocks, hinges } = self;
        let (mut numbers, mut factors) = ([[0.0; 20]; GROUP], [0.0; GROUP]);
        let (groups, rest) = slots.as_chunks::<PAIRS>().0.as_chunks::<GROUP>();
        for (at, slots) in groups.iter().enumerate() {
            let mut buffer = [[0.0; GROUP]; 12];
            prefetch_slots(slots);
            let (planes, k) = hinges.eight(GROUP * at, &mut buffer);
            to_hinges(simd, planes, &mut numbers);
            for lane in 0..GROUP {
                factors[lane] = k[lane] as f32;
            }
            for (slots, (numbers, k)) in slots.iter().zip(numbers.iter().zip(&factors)) {
                add(simd, slots, first, blocks, numbers, *k);
            }
        }
        for (slots, e) in rest.iter().zip(GROUP * groups.len()..) {
            let (numbers, k) = rounded(hinges, e);
            add(simd, slots, first, blocks, &numbers, k);
        }
    }
}

/// Rounds planes and transposes them to the gradients of hinges.
#[inline(always)]
fn to_hinges(simd: V3, planes: [&[f64; GROUP]; 12], to: &mut [Numbers; GROUP]) {
    for (third, half) in (0..3).flat_map(|third| [(third, 0), (third, 1)]) {
        let rows = rows(simd, planes, third, half);
        for lane in 0..4 {
            to[4 * half + lane][4 * third..4 * third + 4].copy_from_slice(&rows[lane]);
        }
    }
}

/// Four numbers of four hinges: those of a third of the planes and of a half of the hinges.
#[inline(always)]
fn rows(simd: V3, planes: [&[f64; GROUP]; 12], third: usize, half: usize) -> [[f32; 4]; 4] {
    let mut four: [__m128; 4] = [cast([0.0_f32; 4]); 4];
    for k in 0..4 {
        let [low, high]: [[f64; 4]; 2] = cast(*planes[4 * third + k]);
        four[k] = simd.avx._mm256_cvtpd_ps(cast(if half == 0 { low } else { high }));
    }
    let ([a, b, c, d], sse) = (four, simd.sse);
    let (ab, other_ab) = (sse._mm_unpacklo_ps(a, b), sse._mm_unpackhi_ps(a, b));
    let (cd, other_cd) = (sse._mm_unpacklo_ps(c, d), sse._mm_unpackhi_ps(c, d));
    [
        cast(sse._mm_movelh_ps(ab, cd)),
        cast(sse._mm_movehl_ps(cd, ab)),
        cast(sse._mm_movelh_ps(other_ab, other_cd)),
        cast(sse._mm_movehl_ps(other_cd, other_ab)),
    ]
}

/// Adds the blocks of a hinge.
#[inline(always)]
fn add(simd: V3, slots: &[u32; PAIRS], first: usize, blocks: &mut [SingleBlock], numbers: &Numbers, k: f32) {
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

/// Selects numbers by their indices.
#[inline(always)]
fn spread(simd: V3, numbers: __m256, places: [u32; 8]) -> __m256 {
    simd.avx2._mm256_permutevar8x32_ps(numbers, cast(places))
}
