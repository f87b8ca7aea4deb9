//! Assembly of hinges into a matrix: outer products `k g g^T` of the gradients g at their four corners.
//!
//! A matrix in double precision has the blocks of all pairs of corners, one in single precision those of different corners
//! ([`BlockScalar::HAS_DIAGONAL_BLOCKS`]). Every vector unit does the same operations on each entry, so bytes do not depend on the one found
//! at run time.

use super::algebra::Vec3;
use crate::force_model::{ElementCall, ForceError, ForceModel};
use crate::lanes::blocks::{BlockUnit, Scalar};
use crate::lanes::{LANES, Lanes, Work, store, widest};
use pliant_plugin_api::{BlockScalar, TangentScale, abi, pair_index, prefetch};

/// Number of slots of a hinge: pairs of its four corners, each corner with itself included.
const PAIRS: usize = 10;

/// Number of hinges that are read together.
pub const GROUP: usize = LANES;

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

/// Hinges of one call.
pub trait Hinges {
    /// Gradients g at the corners of hinge `e`, and the factor k of their products; `inline(always)`, so that it is compiled for the
    /// vector unit too.
    fn hinge(&self, e: usize) -> ([Vec3; 4], f64);
    /// Gradients of a group of hinges from `e` on, by corner and axis, and their factors. The planes may be written to `buffer`.
    #[inline(always)]
    fn group<'a>(&'a self, e: usize, buffer: &'a mut GroupPlanes) -> ([&'a [f64; GROUP]; 12], [f64; GROUP]) {
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

/// The precision in which a matrix stores its blocks.
pub trait Precision: BlockScalar + Scalar + Send {
    /// Adds `k g g^T` of each hinge at its `slots` (hinges x 10).
    fn add_outer(slots: &[u32], blocks: BlocksMut<'_, Self>, hinges: &impl Hinges);

    /// Rounds the gradients of a group and transposes them to padded vectors, by corner.
    fn transpose(unit: impl Lanes, planes: [&[f64; GROUP]; 12], to: &mut [[[Self; 4]; GROUP]; 4]);

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
        widest(HingeAssembly { slots, blocks, hinges });
    }

    #[inline(always)]
    fn transpose(_: impl Lanes, planes: [&[f64; GROUP]; 12], to: &mut [[[f64; 4]; GROUP]; 4]) {
        for corner in 0..4 {
            let [x, y, z] = [planes[3 * corner], planes[3 * corner + 1], planes[3 * corner + 2]];
            for lane in 0..GROUP {
                to[corner][lane] = [x[lane], y[lane], z[lane], 0.0];
            }
        }
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
        widest(HingeAssembly { slots, blocks, hinges });
    }

    #[inline(always)]
    fn transpose(unit: impl Lanes, planes: [&[f64; GROUP]; 12], to: &mut [[[f32; 4]; GROUP]; 4]) {
        for corner in 0..4 {
            let [x, y, z] = [planes[3 * corner], planes[3 * corner + 1], planes[3 * corner + 2]];
            store(unit, &mut to[corner], unit.vectors([unit.round(x), unit.round(y), unit.round(z)]));
        }
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

/// The loop over hinges that adds `k g g^T` of each at its slots.
struct HingeAssembly<'a, T, H> {
    /// Slots of the pairs of corners (hinges x 10).
    slots: &'a [u32],
    /// Blocks of the matrix.
    blocks: BlocksMut<'a, T>,
    /// Hinges that are assembled.
    hinges: &'a H,
}

impl<H: Hinges> Work for HingeAssembly<'_, f64, H> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        self.run(unit, unit.f64_blocks());
    }
}

impl<H: Hinges> Work for HingeAssembly<'_, f32, H> {
    type Output = ();

    #[inline(always)]
    fn on(self, unit: impl Lanes) {
        self.run(unit, unit.f32_blocks());
    }
}

impl<T: Precision, H: Hinges> HingeAssembly<'_, T, H> {
    #[inline(always)]
    fn run(mut self, unit: impl Lanes, block_unit: impl BlockUnit<T>) {
        let slots = self.slots.as_chunks::<PAIRS>().0;
        if slots.len() < GROUP {
            for (e, slots) in slots.iter().enumerate() {
                let (g, k) = self.hinges.hinge(e);
                let g = g.map(|g| [g.x, g.y, g.z, 0.0].map(T::from_f64));
                add(block_unit, slots, &mut self.blocks, g.each_ref(), T::from_f64(k));
            }
            return;
        }
        let (mut buffer, mut gradients) = ([[0.0; GROUP]; 12], [[[T::from_f64(0.0); 4]; GROUP]; 4]);
        for e in (0..slots.len()).step_by(GROUP) {
            // The last group begins with hinges of the one before, which are not added again.
            let first = e.min(slots.len() - GROUP);
            for line in 0..GROUP * PAIRS / 16 {
                prefetch(slots.as_flattened(), (first + AHEAD) * PAIRS + 16 * line);
            }
            let (planes, factors) = self.hinges.group(first, &mut buffer);
            T::transpose(unit, planes, &mut gradients);
            let [a, b, c, d] = &gradients;
            for lane in e - first..GROUP {
                let g = [&a[lane], &b[lane], &c[lane], &d[lane]];
                add(block_unit, &slots[first + lane], &mut self.blocks, g, T::from_f64(factors[lane]));
            }
        }
    }
}

/// Adds the blocks of a hinge with the gradients `g` and the factor `k`.
#[inline(always)]
fn add<T: Precision, U: BlockUnit<T>>(
    unit: U,
    slots: &[u32; PAIRS],
    blocks: &mut BlocksMut<'_, T>,
    g: [&[T; 4]; 4],
    k: T,
) {
    let factor = unit.splat(k);
    let (mut left, mut right) = ([factor; 4], [factor; 4]);
    for corner in 0..4 {
        left[corner] = unit.mul(factor, unit.by_row(g[corner]));
        right[corner] = unit.by_column(g[corner]);
    }
    for a in 0..4 {
        for b in a..4 {
            if a == b && !T::HAS_DIAGONAL_BLOCKS {
                continue;
            }
            let slot = slots[pair_index(a, b, 4)];
            let block = &mut blocks.blocks[(slot & !abi::TRANSPOSED) as usize - blocks.first];
            let transposed = (slot / abi::TRANSPOSED) as usize;
            let more = unit.transpose_if(transposed, unit.mul(left[a], right[b]));
            *block = unit.store(unit.add(unit.load(block), more));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Unit;

    fn wave(i: usize) -> f64 {
        (1.7 * i as f64).sin() * 10_f64.powi((i % 7) as i32 - 3)
    }

    struct Waves;

    impl Hinges for Waves {
        #[inline(always)]
        fn hinge(&self, e: usize) -> ([Vec3; 4], f64) {
            (std::array::from_fn(|a| Vec3::from_fn(|i, _| wave(12 * e + 3 * a + i))), wave(900 + e))
        }
    }

    /// Assembles `count` hinges on every vector unit, and compares bytes, and the sums with those of products up to `tolerance`.
    fn check<T: Precision + Into<f64>>(count: usize, tolerance: f64)
    where
        for<'a> HingeAssembly<'a, T, Waves>: Work<Output = ()>,
    {
        // Several hinges to a block, some of them transposed.
        let slots: Vec<u32> =
            (0..10 * count as u32).map(|i| 5 + i * 7 % 23 + if i % 3 == 1 { abi::TRANSPOSED } else { 0 }).collect();
        let before: Vec<[T; 9]> =
            (0..23).map(|b| std::array::from_fn(|i| T::from_f64(wave(2000 + 9 * b + i)))).collect();
        let sums = Unit::ALL.map(|unit| {
            let mut blocks = before.clone();
            let to = BlocksMut { first: 5, blocks: &mut blocks };
            unit.run(HingeAssembly { slots: &slots, blocks: to, hinges: &Waves });
            blocks.into_iter().flatten().map(|v| v.into()).collect::<Vec<f64>>()
        });
        let bits = |sums: &[f64]| sums.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert!(sums.iter().all(|other| bits(other) == bits(&sums[0])));
        let mut want: Vec<f64> = before.into_iter().flatten().map(|v| v.into()).collect();
        let mut size: Vec<f64> = want.iter().map(|v| v.abs()).collect();
        let pairs = (0..4).flat_map(|a| (a..4).map(move |b| (a, b)));
        for (e, (pair, (a, b))) in (0..count).flat_map(|e| pairs.clone().enumerate().map(move |pair| (e, pair))) {
            let ((g, k), slot) = (Waves.hinge(e), slots[10 * e + pair]);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).filter(|_| a < b || T::HAS_DIAGONAL_BLOCKS) {
                let at = if slot & abi::TRANSPOSED == 0 { 3 * i + j } else { 3 * j + i };
                let (at, term) = (9 * ((slot & !abi::TRANSPOSED) as usize - 5) + at, k * g[a][i] * g[b][j]);
                want[at] += term;
                size[at] += term.abs();
            }
        }
        for (got, (want, size)) in sums[0].iter().zip(want.iter().zip(size)) {
            assert!((got - want).abs() < tolerance * size, "{got} {want}");
        }
    }

    #[test]
    fn every_vector_unit_gives_the_same_bytes_and_the_products() {
        for count in [3, GROUP, GROUP + 3] {
            check::<f64>(count, 1e-14);
            check::<f32>(count, 1e-6);
        }
    }
}
