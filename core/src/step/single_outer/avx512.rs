//! A block at once, and all numbers of a hinge in one register.

use super::avx2::rows;
use super::{BETWEEN, GROUP, Hinges, Outer, PAIRS, SingleBlock, place, rounded};
use pulp::x86::V4;
use pulp::{cast, f32x16, u32x16};

/// Which of a hinge's numbers a block is made of: on the left those of the first three corners, on the right of the last three.
const LEFT: [u32x16; 3] = [left(0), left(3), left(6)];
const RIGHT: [u32x16; 3] = [right(3), right(6), right(9)];
/// Where each number of a transposed block comes from.
const TURNED: u32x16 = u32x16(0, 3, 6, 1, 4, 7, 2, 5, 8, 15, 15, 15, 15, 15, 15, 15);

const fn left(k: u32) -> u32x16 {
    u32x16(k, k, k, k + 1, k + 1, k + 1, k + 2, k + 2, k + 2, 15, 15, 15, 15, 15, 15, 15)
}

const fn right(k: u32) -> u32x16 {
    u32x16(k, k + 1, k + 2, k, k + 1, k + 2, k, k + 1, k + 2, 15, 15, 15, 15, 15, 15, 15)
}

impl<H: Hinges> pulp::NullaryFnOnce for Outer<'_, V4, f32, H> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { simd, slots, first, blocks, hinges } = self;
        let (groups, rest) = slots.as_chunks::<PAIRS>().0.as_chunks::<GROUP>();
        for (at, slots) in groups.iter().enumerate() {
            let (planes, k) = hinges.eight(GROUP * at);
            for half in 0..2 {
                let thirds =
                    [rows(*simd, &planes, (0, half)), rows(*simd, &planes, (1, half)), rows(*simd, &planes, (2, half))];
                for lane in 0..4 {
                    let numbers = joined(simd, [thirds[0][lane], thirds[1][lane], thirds[2][lane]]);
                    let e = 4 * half + lane;
                    add(simd, &slots[e], first, blocks, (numbers, k[e] as f32));
                }
            }
        }
        for (slots, e) in rest.iter().zip(GROUP * groups.len()..) {
            let (numbers, k) = rounded(hinges, e);
            let [numbers @ .., _, _, _, _] = numbers;
            add(simd, slots, first, blocks, (cast(numbers), k));
        }
    }
}

/// In a register all the way: through memory it would have to wait until all three have got there.
#[inline(always)]
fn joined(simd: V4, [a, b, c]: [[f32; 4]; 3]) -> f32x16 {
    let (simd, zero) = (simd.avx512f, cast([0.0_f32; 16]));
    let two = simd._mm512_insertf32x4::<1>(simd._mm512_insertf32x4::<0>(zero, cast(a)), cast(b));
    cast(simd._mm512_insertf32x4::<2>(two, cast(c)))
}

#[inline(always)]
fn add(simd: V4, slots: &[u32; PAIRS], first: usize, blocks: &mut [SingleBlock], (numbers, k): (f32x16, f32)) {
    let scaled = simd.mul_f32x16(simd.splat_f32x16(k), numbers);
    let left = [spread(simd, scaled, LEFT[0]), spread(simd, scaled, LEFT[1]), spread(simd, scaled, LEFT[2])];
    let right = [spread(simd, numbers, RIGHT[0]), spread(simd, numbers, RIGHT[1]), spread(simd, numbers, RIGHT[2])];
    // One by one: from a loop they would go through memory.
    let [ab, ao, ap, bo, bp, op] = BETWEEN.map(|(pair, ..)| slots[pair]);
    put(simd, place(ab, first, blocks), left[0], right[0]);
    put(simd, place(ao, first, blocks), left[0], right[1]);
    put(simd, place(ap, first, blocks), left[0], right[2]);
    put(simd, place(bo, first, blocks), left[1], right[1]);
    put(simd, place(bp, first, blocks), left[1], right[2]);
    put(simd, place(op, first, blocks), left[2], right[2]);
}

#[inline(always)]
fn put(simd: V4, (to, transposed): (&mut SingleBlock, bool), left: f32x16, right: f32x16) {
    let block = cast(simd.mul_f32x16(left, right));
    // Not a branch, for which it is to be cannot be guessed.
    let which = 0_u16.wrapping_sub(u16::from(transposed));
    let more: [f32; 16] = cast(simd.avx512f._mm512_mask_permutexvar_ps(block, which, cast(TURNED), block));
    for at in 0..9 {
        to[at] += more[at];
    }
}

#[inline(always)]
fn spread(simd: V4, numbers: f32x16, places: u32x16) -> f32x16 {
    cast(simd.avx512f._mm512_permutexvar_ps(cast(places), cast(numbers)))
}
