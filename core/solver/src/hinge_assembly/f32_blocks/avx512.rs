//! Assembly of hinges with AVX-512: a block at once, with the gradient of a hinge in one register.

use super::{BETWEEN, GROUP, HingeAssembly, Hinges, PAIRS, SingleBlock, place, prefetch_slots, rounded};
use pulp::x86::V4;
use pulp::{cast, f32x16, u32x16};
use std::arch::x86_64::__m512;

/// Components of a hinge's gradient that are the left factors of a block, for the first three corners.
const LEFT: [u32x16; 3] = [left(0), left(3), left(6)];
/// Components that are the right factors, for the last three corners.
const RIGHT: [u32x16; 3] = [right(3), right(6), right(9)];
/// Entry that each entry of the transpose is.
const TRANSPOSED: u32x16 = u32x16(0, 3, 6, 1, 4, 7, 2, 5, 8, 15, 15, 15, 15, 15, 15, 15);

/// Indices of left factors, for components from `k` on.
const fn left(k: u32) -> u32x16 {
    u32x16(k, k, k, k + 1, k + 1, k + 1, k + 2, k + 2, k + 2, 15, 15, 15, 15, 15, 15, 15)
}

/// Indices of right factors, for components from `k` on.
const fn right(k: u32) -> u32x16 {
    u32x16(k, k + 1, k + 2, k, k + 1, k + 2, k, k + 1, k + 2, 15, 15, 15, 15, 15, 15, 15)
}

impl<H: Hinges> pulp::NullaryFnOnce for HingeAssembly<'_, V4, f32, H> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { simd, slots, first, blocks, hinges } = self;
        let (groups, rest) = slots.as_chunks::<PAIRS>().0.as_chunks::<GROUP>();
        let mut buffer = [[0.0; GROUP]; 12];
        for (at, slots) in groups.iter().enumerate() {
            prefetch_slots(slots);
            let (planes, k) = hinges.eight(GROUP * at, &mut buffer);
            // Written out: with a loop the compiler keeps the array in memory.
            let [a, b, c, d, e, f, g, h] = to_hinges(simd, planes);
            add(simd, &slots[0], first, blocks, a, k[0] as f32);
            add(simd, &slots[1], first, blocks, b, k[1] as f32);
            add(simd, &slots[2], first, blocks, c, k[2] as f32);
            add(simd, &slots[3], first, blocks, d, k[3] as f32);
            add(simd, &slots[4], first, blocks, e, k[4] as f32);
            add(simd, &slots[5], first, blocks, f, k[5] as f32);
            add(simd, &slots[6], first, blocks, g, k[6] as f32);
            add(simd, &slots[7], first, blocks, h, k[7] as f32);
        }
        for (slots, e) in rest.iter().zip(GROUP * groups.len()..) {
            let (numbers, k) = rounded(hinges, e);
            let [numbers @ .., _, _, _, _] = numbers;
            add(simd, slots, first, blocks, cast(numbers), k);
        }
    }
}

/// Rounds planes and transposes them to the gradients of hinges, within registers, as reading what was just written would stall. The last four
/// numbers of each register are not used.
#[inline(always)]
fn to_hinges(simd: V4, planes: [&[f64; GROUP]; 12]) -> [f32x16; GROUP] {
    let avx = simd.avx512f;
    let mut thirds = [[cast([0.0_f32; 16]); 3]; 2];
    for third in 0..3 {
        let (ab, cd) = (
            both(simd, planes[4 * third], planes[4 * third + 1]),
            both(simd, planes[4 * third + 2], planes[4 * third + 3]),
        );
        thirds[0][third] = avx._mm512_permutex2var_ps(ab, cast(COLUMNS[0]), cd);
        thirds[1][third] = avx._mm512_permutex2var_ps(ab, cast(COLUMNS[1]), cd);
    }
    let mut all = [cast([0.0_f32; 16]); GROUP];
    for (half, [a, b, c]) in thirds.into_iter().enumerate() {
        let (low, high) = (avx._mm512_shuffle_f32x4::<0x44>(a, b), avx._mm512_shuffle_f32x4::<0xee>(a, b));
        all[4 * half] = cast(avx._mm512_shuffle_f32x4::<0x08>(low, c));
        all[4 * half + 1] = cast(avx._mm512_shuffle_f32x4::<0x5d>(low, c));
        all[4 * half + 2] = cast(avx._mm512_shuffle_f32x4::<0xa8>(high, c));
        all[4 * half + 3] = cast(avx._mm512_shuffle_f32x4::<0xfd>(high, c));
    }
    all
}

/// Indices, into four planes in two registers, of the numbers of the first four hinges and of the last four.
const COLUMNS: [u32x16; 2] = [
    u32x16(0, 8, 16, 24, 1, 9, 17, 25, 2, 10, 18, 26, 3, 11, 19, 27),
    u32x16(4, 12, 20, 28, 5, 13, 21, 29, 6, 14, 22, 30, 7, 15, 23, 31),
];

/// Two planes in one register, rounded.
#[inline(always)]
fn both(simd: V4, a: &[f64; GROUP], b: &[f64; GROUP]) -> __m512 {
    let (avx, low) = (simd.avx512f, simd.avx512f._mm512_cvtpd_ps(cast(*a)));
    simd.avx512dq._mm512_insertf32x8::<1>(avx._mm512_castps256_ps512(low), avx._mm512_cvtpd_ps(cast(*b)))
}

/// Adds the blocks of a hinge.
#[inline(always)]
fn add(simd: V4, slots: &[u32; PAIRS], first: usize, blocks: &mut [SingleBlock], numbers: f32x16, k: f32) {
    let scaled = simd.mul_f32x16(simd.splat_f32x16(k), numbers);
    let left = [spread(simd, scaled, LEFT[0]), spread(simd, scaled, LEFT[1]), spread(simd, scaled, LEFT[2])];
    let right = [spread(simd, numbers, RIGHT[0]), spread(simd, numbers, RIGHT[1]), spread(simd, numbers, RIGHT[2])];
    // Written out: with a loop, or `map`, the compiler keeps the array in memory.
    let slot = |k: usize| slots[BETWEEN[k].0];
    put(simd, slot(0), first, blocks, left[0], right[0]);
    put(simd, slot(1), first, blocks, left[0], right[1]);
    put(simd, slot(2), first, blocks, left[0], right[2]);
    put(simd, slot(3), first, blocks, left[1], right[1]);
    put(simd, slot(4), first, blocks, left[1], right[2]);
    put(simd, slot(5), first, blocks, left[2], right[2]);
}

/// Adds one block.
#[inline(always)]
fn put(simd: V4, slot: u32, first: usize, blocks: &mut [SingleBlock], left: f32x16, right: f32x16) {
    let (to, transposed) = place(slot, first, blocks);
    let block = cast(simd.mul_f32x16(left, right));
    // A mask, because a branch on the orientation cannot be predicted.
    let which = 0_u16.wrapping_sub(u16::from(transposed));
    let more: [f32; 16] = cast(simd.avx512f._mm512_mask_permutexvar_ps(block, which, cast(TRANSPOSED), block));
    for at in 0..9 {
        to[at] += more[at];
    }
}

/// Selects numbers by their indices.
#[inline(always)]
fn spread(simd: V4, numbers: f32x16, places: u32x16) -> f32x16 {
    cast(simd.avx512f._mm512_permutexvar_ps(cast(places), cast(numbers)))
}
