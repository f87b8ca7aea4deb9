//! Springs in lanes of a vector unit, wherever their ends are.

use crate::kernel::{LANES, Springs};
use pliant_plugin_api::lanes::{MAX_LANES, Real, Wide};
use pulp::{Simd, WithSimd};

/// As many springs as `S` has lanes.
pub struct Gathered<S: Simd> {
    /// m, from the first end to the second, and its square
    pub d: [Wide<S>; 3],
    pub square: Wide<S>,
    /// m, the rest length
    pub l0: Wide<S>,
    /// N/m, or nothing where there is no spring
    pub k: Wide<S>,
}

impl Springs<'_> {
    /// Those from `e` on. Past the end they are the last one, without stiffness.
    #[inline(always)]
    pub fn gather<S: Simd>(&self, simd: S, e: usize) -> Gathered<S> {
        let (mut d, mut l0, mut k) = ([[0.0; MAX_LANES]; 3], [0.0; MAX_LANES], [0.0; MAX_LANES]);
        for lane in 0..S::F64_LANES {
            let at = (e + lane).min(self.ends.len() - 1);
            let (from, to) = (self.x[self.ends[at][0] as usize], self.x[self.ends[at][1] as usize]);
            for i in 0..3 {
                d[i][lane] = to[i] - from[i];
            }
            (l0[lane], k[lane]) = (self.length[at], if at == e + lane { self.stiffness[at] } else { 0.0 });
        }
        let d @ [x, y, z] = [Wide::load(simd, &d[0]), Wide::load(simd, &d[1]), Wide::load(simd, &d[2])];
        Gathered { d, square: x * x + y * y + z * z, l0: Wide::load(simd, &l0), k: Wide::load(simd, &k) }
    }
}

/// Finds the energy of a call's springs, J: `k/2 (l - l0)^2` of each.
pub struct Energy<'a>(pub Springs<'a>);

impl WithSimd for Energy<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        // Of every eighth spring, so that the sum is that of any vector unit.
        let mut sums = [Wide(simd.splat_f64s(0.0), simd); LANES];
        for e in (0..self.0.ends.len()).step_by(LANES) {
            for (at, sum) in sums[..LANES / S::F64_LANES].iter_mut().enumerate() {
                let Gathered { square, l0, k, .. } = self.0.gather(simd, e + at * S::F64_LANES);
                let stretch = square.sqrt() - l0;
                *sum = *sum + k * 0.5 * stretch * stretch;
            }
        }
        let mut all = [0.0; LANES];
        for (at, sum) in sums[..LANES / S::F64_LANES].iter().enumerate() {
            sum.store(&mut all[at * S::F64_LANES..]);
        }
        all.iter().sum()
    }
}
