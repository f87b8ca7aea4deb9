//! A block of eight springs in AVX2, four at a time, with the operations of [`super::spring_force`] in the same order.

use super::{Block, BlockKernel, BlockVectors, LANES, MIN_LENGTH_RATIO, SpringState, Springs};
use pulp::x86::V3 as Avx2;
use pulp::{cast, f64x4};
use std::arch::x86_64::{__m256d, _CMP_NLT_UQ};

/// Springs in a register.
const HALF: usize = 4;

/// Four vectors: a register for each component.
type Components = [f64x4; 3];

impl BlockKernel for Avx2 {
    #[inline(always)]
    fn forces<const DAMPED: bool>(self, s: &Springs<'_>, block: Block) -> BlockVectors {
        let Block { first_spring: e, a, b, len } = block;
        let mut halves = [[[0.0; 3]; HALF]; 2];
        for (half, forces) in halves.iter_mut().enumerate() {
            let first = half * HALF;
            let d = difference(self, s.x, a + first, b + first);
            let l2 = dot(self, d, d);
            let d_dot_w = match DAMPED {
                true => dot(self, d, difference(self, s.v, a + first, b + first)),
                false => self.splat_f64x4(0.0),
            };
            let (l0, k) = (four(s.rest_length, e + first), four(s.stiffness, e + first));
            let spring = SpringState { l2, d_dot_w, l0, k };
            let factor = force_factor::<DAMPED>(self, spring, s.damping_time);
            let mut in_block = [0_u64; HALF];
            for lane in 0..HALF {
                in_block[lane] = if first + lane < len { u64::MAX } else { 0 };
            }
            let factor: f64x4 = cast(self.avx._mm256_and_pd(cast(factor), cast(in_block)));
            let f = [self.mul_f64x4(factor, d[0]), self.mul_f64x4(factor, d[1]), self.mul_f64x4(factor, d[2])];
            *forces = to_vectors(self, f);
        }
        cast(halves)
    }
}

#[inline(always)]
fn four(values: &[f64], first: usize) -> f64x4 {
    let chunk: &[f64; HALF] = values[first..].first_chunk().expect("the caller checked that the block fits");
    cast(*chunk)
}

/// Components of four consecutive vectors.
#[inline(always)]
fn components(simd: Avx2, vectors: &[[f64; 3]], first: usize) -> Components {
    let chunk: &[[f64; 3]; HALF] = vectors[first..].first_chunk().expect("the caller checked that the block fits");
    let ([p, q, r], avx): ([__m256d; 3], _) = (cast(*chunk), simd.avx);
    let xy = avx._mm256_permute2f128_pd::<0x30>(p, q);
    let zx = avx._mm256_permute2f128_pd::<0x21>(p, r);
    let yz = avx._mm256_permute2f128_pd::<0x30>(q, r);
    [
        cast(avx._mm256_shuffle_pd::<0b1010>(xy, zx)),
        cast(avx._mm256_shuffle_pd::<0b0101>(xy, yz)),
        cast(avx._mm256_shuffle_pd::<0b1010>(zx, yz)),
    ]
}

/// Inverse of [`components`].
#[inline(always)]
fn to_vectors(simd: Avx2, [x, y, z]: Components) -> [[f64; 3]; HALF] {
    let ([x, y, z], avx): ([__m256d; 3], _) = (cast([x, y, z]), simd.avx);
    let (xy, zx, yz) =
        (avx._mm256_unpacklo_pd(x, y), avx._mm256_shuffle_pd::<0b1010>(z, x), avx._mm256_unpackhi_pd(y, z));
    cast([
        avx._mm256_permute2f128_pd::<0x20>(xy, zx),
        avx._mm256_permute2f128_pd::<0x30>(yz, xy),
        avx._mm256_permute2f128_pd::<0x31>(zx, yz),
    ])
}

/// Vectors `b, b + 1, ..` minus vectors `a, a + 1, ..`
#[inline(always)]
fn difference(simd: Avx2, vectors: &[[f64; 3]], a: usize, b: usize) -> Components {
    let (from, to) = (components(simd, vectors, a), components(simd, vectors, b));
    [simd.sub_f64x4(to[0], from[0]), simd.sub_f64x4(to[1], from[1]), simd.sub_f64x4(to[2], from[2])]
}

/// Scalar product of each pair of vectors.
#[inline(always)]
fn dot(simd: Avx2, a: Components, b: Components) -> f64x4 {
    let xy = simd.add_f64x4(simd.mul_f64x4(a[0], b[0]), simd.mul_f64x4(a[1], b[1]));
    simd.add_f64x4(xy, simd.mul_f64x4(a[2], b[2]))
}

/// [`super::force_factor`] of four springs.
#[inline(always)]
fn force_factor<const DAMPED: bool>(simd: Avx2, spring: SpringState<f64x4>, damping_time: f64) -> f64x4 {
    let SpringState { l2, d_dot_w, l0, k } = spring;
    let l: f64x4 = cast(simd.avx._mm256_sqrt_pd(cast(l2)));
    let elastic = simd.mul_f64x4(simd.sub_f64x4(l, l0), l);
    let total = match DAMPED {
        true => simd.add_f64x4(elastic, simd.mul_f64x4(simd.splat_f64x4(damping_time), d_dot_w)),
        false => elastic,
    };
    let factor = simd.mul_f64x4(simd.div_f64x4(k, l2), total);
    let min_length = simd.mul_f64x4(simd.splat_f64x4(MIN_LENGTH_RATIO), l0);
    let min_l2 = simd.mul_f64x4(min_length, min_length);
    // Not less, so that a NaN keeps its force.
    let has_direction = simd.avx._mm256_cmp_pd::<_CMP_NLT_UQ>(cast(l2), cast(min_l2));
    cast(simd.avx._mm256_and_pd(has_direction, cast(factor)))
}

const _: () = assert!(LANES == 2 * HALF);
