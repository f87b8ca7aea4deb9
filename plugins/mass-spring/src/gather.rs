//! Springs in lanes of a vector unit, wherever their ends are.

use crate::kernel::{LANES, Springs};
use pulp::{Simd, WithSimd, bytemuck};

/// A number of each spring.
pub type Lanes = [f64; LANES];

/// As many springs as `S` has lanes.
pub struct Gathered<S: Simd> {
    /// m, from the first end to the second, and its square
    pub d: [S::f64s; 3],
    pub square: S::f64s,
    /// m, the rest length
    pub l0: S::f64s,
    /// N/m, or nothing where there is no spring
    pub k: S::f64s,
}

impl Springs<'_> {
    /// Those from `e` on. Past the end they are the last one, without stiffness.
    #[inline(always)]
    pub fn gather<S: Simd>(&self, simd: S, e: usize) -> Gathered<S> {
        let (mut d, mut l0, mut k) = ([[0.0; LANES]; 3], [0.0; LANES], [0.0; LANES]);
        for lane in 0..S::F64_LANES {
            let at = (e + lane).min(self.ends.len() - 1);
            let (from, to) = (self.x[self.ends[at][0] as usize], self.x[self.ends[at][1] as usize]);
            for i in 0..3 {
                d[i][lane] = to[i] - from[i];
            }
            (l0[lane], k[lane]) = (self.length[at], if at == e + lane { self.stiffness[at] } else { 0.0 });
        }
        let d @ [x, y, z] = [load(simd, &d[0]), load(simd, &d[1]), load(simd, &d[2])];
        let square = simd.add_f64s(simd.add_f64s(simd.mul_f64s(x, x), simd.mul_f64s(y, y)), simd.mul_f64s(z, z));
        Gathered { d, square, l0: load(simd, &l0), k: load(simd, &k) }
    }
}

#[inline(always)]
fn load<S: Simd>(_: S, from: &Lanes) -> S::f64s {
    bytemuck::pod_read_unaligned(bytemuck::cast_slice(&from[..S::F64_LANES]))
}

/// Writes the first numbers of `to`.
#[inline(always)]
pub fn store<S: Simd>(_: S, values: S::f64s, to: &mut [f64]) {
    bytemuck::cast_slice_mut::<f64, u8>(&mut to[..S::F64_LANES]).copy_from_slice(bytemuck::bytes_of(&values));
}

/// Finds the energy of a call's springs, J: `k/2 (l - l0)^2` of each.
pub struct Energy<'a>(pub Springs<'a>);

impl WithSimd for Energy<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        // Of every eighth spring, so that the sum is that of any vector unit.
        let mut sums = [simd.splat_f64s(0.0); LANES];
        for e in (0..self.0.ends.len()).step_by(LANES) {
            for (at, sum) in sums[..LANES / S::F64_LANES].iter_mut().enumerate() {
                let Gathered { square, l0, k, .. } = self.0.gather(simd, e + at * S::F64_LANES);
                let stretch = simd.sub_f64s(simd.sqrt_f64s(square), l0);
                let half = simd.mul_f64s(simd.splat_f64s(0.5), k);
                *sum = simd.add_f64s(*sum, simd.mul_f64s(simd.mul_f64s(half, stretch), stretch));
            }
        }
        let mut all = [0.0; LANES];
        for (at, sum) in sums[..LANES / S::F64_LANES].iter().enumerate() {
            store(simd, *sum, &mut all[at * S::F64_LANES..]);
        }
        all.iter().sum()
    }
}
