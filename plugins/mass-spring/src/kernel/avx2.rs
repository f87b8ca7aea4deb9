//! A block of eight springs in AVX2, four at once, operation by operation the same as [`super::one`].

use super::{Block, LANES, NO_DIRECTION, Springs, Vectors};
use pulp::x86::V3;
use pulp::{cast, f64x4};
use std::arch::x86_64::{__m256d, _CMP_NLT_UQ};

/// Springs at once.
const HALF: usize = 4;

/// Four vectors by component.
type Planes = [f64x4; 3];

impl Block for V3 {
    #[inline(always)]
    fn forces<const DAMPED: bool>(self, s: &Springs<'_>, e: usize, a: usize, b: usize, run: usize) -> Vectors {
        let mut halves = [[[0.0; 3]; HALF]; 2];
        for (half, forces) in halves.iter_mut().enumerate() {
            let first = half * HALF;
            let d = difference(self, s.x, a + first, b + first);
            let l2 = dot(self, d, d);
            let rate = match DAMPED {
                true => dot(self, d, difference(self, s.v, a + first, b + first)),
                false => self.splat_f64x4(0.0),
            };
            let (l0, k) = (four(s.length, e + first), four(s.stiffness, e + first));
            let factor = law::<DAMPED>(self, l2, rate, l0, k, s.damping_time);
            let mut within = [0_u64; HALF];
            for lane in 0..HALF {
                within[lane] = if first + lane < run { u64::MAX } else { 0 };
            }
            let factor: f64x4 = cast(self.avx._mm256_and_pd(cast(factor), cast(within)));
            let f = [self.mul_f64x4(factor, d[0]), self.mul_f64x4(factor, d[1]), self.mul_f64x4(factor, d[2])];
            *forces = vectors(self, f);
        }
        cast(halves)
    }
}

#[inline(always)]
fn four(of: &[f64], from: usize) -> f64x4 {
    let chunk: &[f64; HALF] = of[from..].first_chunk().expect("the caller saw that the block fits");
    cast(*chunk)
}

/// Four vectors of three, twelve doubles in a row, by component.
#[inline(always)]
fn planes(simd: V3, of: &[[f64; 3]], from: usize) -> Planes {
    let chunk: &[[f64; 3]; HALF] = of[from..].first_chunk().expect("the caller saw that the block fits");
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

/// The way back.
#[inline(always)]
fn vectors(simd: V3, [x, y, z]: Planes) -> [[f64; 3]; HALF] {
    let ([x, y, z], avx): ([__m256d; 3], _) = (cast([x, y, z]), simd.avx);
    let (xy, zx, yz) =
        (avx._mm256_unpacklo_pd(x, y), avx._mm256_shuffle_pd::<0b1010>(z, x), avx._mm256_unpackhi_pd(y, z));
    cast([
        avx._mm256_permute2f128_pd::<0x20>(xy, zx),
        avx._mm256_permute2f128_pd::<0x30>(yz, xy),
        avx._mm256_permute2f128_pd::<0x31>(zx, yz),
    ])
}

#[inline(always)]
fn difference(simd: V3, of: &[[f64; 3]], a: usize, b: usize) -> Planes {
    let (from, to) = (planes(simd, of, a), planes(simd, of, b));
    [simd.sub_f64x4(to[0], from[0]), simd.sub_f64x4(to[1], from[1]), simd.sub_f64x4(to[2], from[2])]
}

/// The dot product of each pair of vectors.
#[inline(always)]
fn dot(simd: V3, a: Planes, b: Planes) -> f64x4 {
    let both = simd.add_f64x4(simd.mul_f64x4(a[0], b[0]), simd.mul_f64x4(a[1], b[1]));
    simd.add_f64x4(both, simd.mul_f64x4(a[2], b[2]))
}

#[inline(always)]
fn law<const DAMPED: bool>(simd: V3, l2: f64x4, rate: f64x4, l0: f64x4, k: f64x4, damping_time: f64) -> f64x4 {
    let l: f64x4 = cast(simd.avx._mm256_sqrt_pd(cast(l2)));
    let stretched = simd.mul_f64x4(simd.sub_f64x4(l, l0), l);
    let ahead = match DAMPED {
        true => simd.add_f64x4(stretched, simd.mul_f64x4(simd.splat_f64x4(damping_time), rate)),
        false => stretched,
    };
    let factor = simd.mul_f64x4(simd.div_f64x4(k, l2), ahead);
    let shortest = simd.mul_f64x4(simd.splat_f64x4(NO_DIRECTION), l0);
    let shortest = simd.mul_f64x4(shortest, shortest);
    let directed = simd.avx._mm256_cmp_pd::<_CMP_NLT_UQ>(cast(l2), cast(shortest));
    cast(simd.avx._mm256_and_pd(directed, cast(factor)))
}

const _: () = assert!(LANES == 2 * HALF);
