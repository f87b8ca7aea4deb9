//! Assembly of hinges into a matrix: outer products `k g g^T` of the gradients g at their four corners.
//!
//! AVX-512 computes eight of the nine entries of a block at once; the portable code does the same operations on each entry, so bytes do not
//! depend on the vector unit found at run time.

mod f32_blocks;

use super::algebra::{Block, Vec3};
use crate::force_model::{ElementCall, ForceError, ForceModel};
use pliant_plugin_api::{TangentScale, abi};

/// Number of slots of a hinge: pairs of its four corners, each corner with itself included.
const PAIRS: usize = 10;

/// Number of hinges that are read together.
pub const GROUP: usize = 8;

/// Number of hinges by which memory is prefetched.
pub const AHEAD: usize = 256;

/// Gradients of a group of hinges, a plane for each corner and axis.
pub type GroupPlanes = [[f64; GROUP]; 12];

/// Blocks of consecutive slots of a matrix.
pub struct BlocksMut<'a, T> {
    /// Slot of the first block.
    pub first: usize,
    /// The blocks, row-major.
    pub blocks: &'a mut [[T; 9]],
}

impl<T> BlocksMut<'_, T> {
    /// The same blocks with a shorter lifetime.
    pub fn reborrow(&mut self) -> BlocksMut<'_, T> {
        BlocksMut { first: self.first, blocks: self.blocks }
    }
}

/// The precision in which a matrix stores its blocks.
pub trait Precision: Copy + Send {
    /// Adds `k g g^T` of each hinge at its `slots` (hinges x 10).
    fn add_outer(slots: &[u32], blocks: BlocksMut<'_, Self>, hinges: &impl Hinges);

    /// Has the material add the tangent of a call at its `slots`.
    ///
    /// # Errors
    /// Returns the error of the material.
    fn add_tangent(
        material: &dyn ForceModel,
        call: &ElementCall<'_>,
        scale: TangentScale,
        slots: &[u32],
        blocks: BlocksMut<'_, Self>,
    ) -> Result<(), ForceError>;
}

impl Precision for f64 {
    fn add_outer(slots: &[u32], blocks: BlocksMut<'_, Self>, hinges: &impl Hinges) {
        add_outer(slots, blocks.first, blocks.blocks, hinges);
    }

    fn add_tangent(
        material: &dyn ForceModel,
        call: &ElementCall<'_>,
        scale: TangentScale,
        slots: &[u32],
        blocks: BlocksMut<'_, Self>,
    ) -> Result<(), ForceError> {
        material.tangent(call, scale, slots, blocks.first, blocks.blocks)
    }
}

impl Precision for f32 {
    fn add_outer(slots: &[u32], blocks: BlocksMut<'_, Self>, hinges: &impl Hinges) {
        f32_blocks::add_outer(slots, blocks.first, blocks.blocks, hinges);
    }

    fn add_tangent(
        material: &dyn ForceModel,
        call: &ElementCall<'_>,
        scale: TangentScale,
        slots: &[u32],
        blocks: BlocksMut<'_, Self>,
    ) -> Result<(), ForceError> {
        material.single_tangent(call, scale, slots, blocks.first, blocks.blocks)
    }
}

/// Hinges of one call.
pub trait Hinges {
    /// Gradients g at the corners of hinge `e`, and the factor k of their products; `inline(always)`, so that it is compiled for the
    /// vector unit too.
    fn hinge(&self, e: usize) -> ([Vec3; 4], f64);
    /// Gradients of eight hinges from `e` on, by corner and axis, and their factors. The planes may be written to `buffer`.
    #[inline(always)]
    fn eight<'a>(&'a self, e: usize, buffer: &'a mut GroupPlanes) -> ([&'a [f64; GROUP]; 12], [f64; GROUP]) {
        let mut factors = [0.0; GROUP];
        for lane in 0..GROUP {
            let (g, k) = self.hinge(e + lane);
            factors[lane] = k;
            for (plane, value) in buffer.iter_mut().zip(bytemuck::cast_slice::<Vec3, f64>(&g)) {
                plane[lane] = *value;
            }
        }
        (buffer.each_ref(), factors)
    }
}

/// The loop over hinges, for one vector unit.
pub struct HingeAssembly<'a, S, T, H> {
    /// The vector unit.
    pub simd: S,
    /// Slots of the pairs of corners (hinges x 10).
    pub slots: &'a [u32],
    /// Slot of the first of `blocks`.
    pub first: usize,
    /// Blocks of the matrix.
    pub blocks: &'a mut [[T; 9]],
    /// Hinges that are assembled.
    pub hinges: &'a H,
}

/// Adds `k g g^T` of each hinge at its `slots` (hinges x 10); `first` is the slot of the first of `blocks`.
pub fn add_outer(slots: &[u32], first: usize, blocks: &mut [Block], hinges: &impl Hinges) {
    #[cfg(target_arch = "x86_64")]
    if let pulp::Arch::V4(simd) = pulp::Arch::new() {
        return simd.vectorize(HingeAssembly { simd, slots, first, blocks, hinges });
    }
    add_each(slots, first, blocks, hinges);
}

/// [`add_outer`] without vector instructions.
fn add_each(slots: &[u32], first: usize, blocks: &mut [Block], hinges: &impl Hinges) {
    for (e, slots) in slots.as_chunks::<PAIRS>().0.iter().enumerate() {
        let (g, k) = hinges.hinge(e);
        let scaled = scaled(k, &g);
        let mut slots = slots.iter();
        for a in 0..4 {
            for (b, &slot) in (a..4).zip(&mut slots) {
                let (to, transposed) = place(slot, first, blocks);
                let (left, right) = (scaled[a], g[b]);
                for i in 0..3 {
                    for j in 0..3 {
                        to[if transposed { 3 * j + i } else { 3 * i + j }] += left[i] * right[j];
                    }
                }
            }
        }
    }
}

/// The block of a slot, and whether it is stored transposed.
#[inline(always)]
fn place(slot: u32, first: usize, blocks: &mut [Block]) -> (&mut Block, bool) {
    (&mut blocks[(slot & !abi::TRANSPOSED) as usize - first], slot & abi::TRANSPOSED != 0)
}

/// `k g`.
#[inline(always)]
fn scaled(k: f64, g: &[Vec3; 4]) -> [Vec3; 4] {
    g.map(|corner| k * corner)
}

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{Block, GROUP, HingeAssembly, Hinges, PAIRS, place};
    use pulp::x86::V4;
    use pulp::{cast, f64x8, u64x8};

    /// For each corner, the components of a hinge's gradient that are the left and the right factors of the first eight entries of a block.
    const LEFT: [u64x8; 4] = [
        u64x8(0, 0, 0, 1, 1, 1, 2, 2),
        u64x8(3, 3, 3, 4, 4, 4, 5, 5),
        u64x8(6, 6, 6, 7, 7, 7, 8, 8),
        u64x8(9, 9, 9, 10, 10, 10, 11, 11),
    ];
    const RIGHT: [u64x8; 4] = [
        u64x8(0, 1, 2, 0, 1, 2, 0, 1),
        u64x8(3, 4, 5, 3, 4, 5, 3, 4),
        u64x8(6, 7, 8, 6, 7, 8, 6, 7),
        u64x8(9, 10, 11, 9, 10, 11, 9, 10),
    ];

    /// Where each of the first eight numbers of a block comes from, as it is and transposed: looked up, for which it is to be cannot
    /// be guessed.
    const PLACES: [u64x8; 2] = [u64x8(0, 1, 2, 3, 4, 5, 6, 7), u64x8(0, 3, 6, 1, 4, 7, 2, 5)];

    impl<H: Hinges> pulp::NullaryFnOnce for HingeAssembly<'_, V4, f64, H> {
        type Output = ();

        #[inline(always)]
        fn call(self) {
            let Self { simd, slots, first, blocks, hinges } = self;
            let (all, mut group) = (slots.as_chunks::<PAIRS>().0, [([0.0; 16], 0.0); GROUP]);
            for (at, slots) in all.chunks(GROUP).enumerate() {
                // Written number by number and read eight at once: that takes a while, in which the next ones are written.
                for (lane, (numbers, factor)) in group[..slots.len()].iter_mut().enumerate() {
                    let ([a, b, o, p], k) = hinges.hinge(GROUP * at + lane);
                    *factor = k;
                    *numbers = [
                        a[0],
                        a[1],
                        a[2],
                        b[0],
                        b[1],
                        b[2],
                        o[0],
                        o[1],
                        o[2],
                        p[0],
                        p[1],
                        p[2],
                        k * a[2],
                        k * b[2],
                        k * o[2],
                        k * p[2],
                    ];
                }
                for (slots, (numbers, k)) in slots.iter().zip(&group) {
                    add(simd, slots, first, blocks, numbers, *k);
                }
            }
        }
    }

    #[inline(always)]
    fn add(simd: V4, slots: &[u32; PAIRS], first: usize, blocks: &mut [Block], numbers: &[f64; 16], k: f64) {
        let ([low, high], k): ([f64x8; 2], _) = (cast(*numbers), simd.splat_f64x8(k));
        let (mut left, mut right) = ([k; 4], [k; 4]);
        for corner in 0..4 {
            left[corner] = simd.mul_f64x8(k, spread(simd, low, high, LEFT[corner]));
            right[corner] = spread(simd, low, high, RIGHT[corner]);
        }
        let mut pair = 0;
        for a in 0..4 {
            for b in a..4 {
                let (to, transposed) = place(slots[pair], first, blocks);
                let more = cast(simd.mul_f64x8(left[a], right[b]));
                let more = cast(simd.avx512f._mm512_permutexvar_pd(cast(PLACES[usize::from(transposed)]), more));
                let [c0, c1, c2, c3, c4, c5, c6, c7, c8] = to;
                let eight: f64x8 = cast([*c0, *c1, *c2, *c3, *c4, *c5, *c6, *c7]);
                let sum: [f64; 8] = cast(simd.add_f64x8(eight, more));
                [*c0, *c1, *c2, *c3, *c4, *c5, *c6, *c7] = sum;
                *c8 += numbers[12 + a] * numbers[3 * b + 2];
                pair += 1;
            }
        }
    }

    #[inline(always)]
    fn spread(simd: V4, low: f64x8, high: f64x8, places: u64x8) -> f64x8 {
        cast(simd.avx512f._mm512_permutex2var_pd(cast(low), cast(places), cast(high)))
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    pub fn wave(i: usize) -> f64 {
        (1.7 * i as f64).sin() * 10_f64.powi((i % 7) as i32 - 3)
    }

    pub struct Waves;

    impl Hinges for Waves {
        #[inline(always)]
        fn hinge(&self, e: usize) -> ([Vec3; 4], f64) {
            (std::array::from_fn(|a| Vec3::from_fn(|i, _| wave(12 * e + 3 * a + i))), wave(900 + e))
        }
    }

    #[test]
    fn every_vector_unit_gives_the_same_bytes_and_the_products() {
        // Several hinges to a block, some of them turned.
        let slots: Vec<u32> = (0..190).map(|i| 5 + i * 7 % 23 + if i % 3 == 1 { abi::TRANSPOSED } else { 0 }).collect();
        let before: Vec<Block> = (0..23).map(|b| std::array::from_fn(|i| wave(2000 + 9 * b + i))).collect();
        let (mut blocks, mut plain, mut want) = (before.clone(), before.clone(), before);
        add_outer(&slots, 5, &mut blocks, &Waves);
        add_each(&slots, 5, &mut plain, &Waves);
        let bits = |blocks: &[Block]| blocks.iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&blocks), bits(&plain));
        let pairs = (0..4).flat_map(|a| (a..4).map(move |b| (a, b)));
        for (e, (pair, (a, b))) in (0..19).flat_map(|e| pairs.clone().enumerate().map(move |pair| (e, pair))) {
            let ((g, k), slot) = (Waves.hinge(e), slots[10 * e + pair]);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let at = if slot & abi::TRANSPOSED == 0 { 3 * i + j } else { 3 * j + i };
                want[(slot & !abi::TRANSPOSED) as usize - 5][at] += k * g[a][i] * g[b][j];
            }
        }
        assert!(plain.iter().flatten().zip(want.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-9 * (1.0 + b.abs())));
    }
}
