//! Assembly of hinges in single precision: as [`crate::hinge_assembly`], without diagonal blocks.

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;

use super::{AHEAD, GROUP, HingeAssembly, Hinges};
use crate::algebra::SingleBlock;
use pliant_plugin_api::{abi, prefetch};

/// Number of slots of a hinge.
const PAIRS: usize = 10;
/// Pairs of different corners: index of the slot, and both corners.
const BETWEEN: [(usize, usize, usize); 6] = [(1, 0, 1), (2, 0, 2), (3, 0, 3), (5, 1, 2), (6, 1, 3), (8, 2, 3)];
/// Gradient of a hinge, padded so that eight numbers can be read from each corner on.
type Numbers = [f32; 20];

/// Adds `k g g^T` of each hinge at its `slots` (hinges x 10); `first` is the slot of the first of `blocks`.
pub fn add_outer(slots: &[u32], first: usize, blocks: &mut [SingleBlock], hinges: &impl Hinges) {
    #[cfg(target_arch = "x86_64")]
    match pulp::Arch::new() {
        pulp::Arch::V4(simd) => return simd.vectorize(HingeAssembly { simd, slots, first, blocks, hinges }),
        pulp::Arch::V3(simd) => return simd.vectorize(HingeAssembly { simd, slots, first, blocks, hinges }),
        _ => {}
    }
    add_each(slots, first, blocks, hinges);
}

/// Prefetches the slots of the group [`AHEAD`] hinges after `slots`.
#[inline(always)]
fn prefetch_slots(slots: &[[u32; PAIRS]; GROUP]) {
    for line in 0..GROUP * PAIRS / 16 {
        prefetch(slots.as_flattened(), AHEAD * PAIRS + 16 * line);
    }
}

/// [`add_outer`] without vector instructions.
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

/// Gradient and factor of hinge `e` in single precision.
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

/// The block of a slot, and whether it is stored transposed.
#[inline(always)]
fn place(slot: u32, first: usize, blocks: &mut [SingleBlock]) -> (&mut SingleBlock, bool) {
    (&mut blocks[(slot & !abi::TRANSPOSED) as usize - first], slot & abi::TRANSPOSED != 0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hinge_assembly::tests::{Waves, wave};

    #[test]
    fn every_vector_unit_gives_the_same_bytes_and_the_products() {
        // Several hinges for each block, some of them transposed.
        let slots: Vec<u32> = (0..190).map(|i| 5 + i * 7 % 23 + if i % 3 == 1 { abi::TRANSPOSED } else { 0 }).collect();
        let mut blocks: Vec<SingleBlock> =
            (0..23).map(|b| std::array::from_fn(|i| wave(2000 + 9 * b + i) as f32)).collect();
        let mut want: Vec<[f64; 9]> = blocks.iter().map(|block| block.map(f64::from)).collect();
        let (mut size, mut plain, before) = (want.clone(), blocks.clone(), blocks.clone());
        add_outer(&slots, 5, &mut blocks, &Waves);
        add_each(&slots, 5, &mut plain, &Waves);
        let bits = |blocks: &[SingleBlock]| blocks.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&blocks), bits(&plain));
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            let mut again = before;
            simd.vectorize(HingeAssembly { simd, slots: &slots, first: 5, blocks: &mut again, hinges: &Waves });
            assert_eq!(bits(&again), bits(&plain));
        }
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
