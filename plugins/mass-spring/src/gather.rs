//! Springs gathered into vector registers, one per lane, wherever their ends are in memory; and their energy.

use crate::kernel::{LANES, Springs};
use pliant_plugin_api::lanes::{MAX_LANES, Real, Vec3, Wide};
use pulp::{Simd, WithSimd};

/// One spring per lane of `S`.
pub struct WideSprings<S: Simd> {
    /// Vector from the first end to the second, m.
    pub d: Vec3<Wide<S>>,
    /// Squared length, m^2.
    pub l2: Wide<S>,
    /// Rest length, m.
    pub l0: Wide<S>,
    /// Stiffness, N/m; 0 in lanes past the last spring.
    pub k: Wide<S>,
}

impl Springs<'_> {
    /// Springs `e, e + 1, ..`; lanes past the end repeat the last spring with a stiffness of 0.
    #[inline(always)]
    pub fn gather<S: Simd>(&self, simd: S, e: usize) -> WideSprings<S> {
        let (mut d, mut l0, mut k) = ([[0.0; MAX_LANES]; 3], [0.0; MAX_LANES], [0.0; MAX_LANES]);
        for lane in 0..S::F64_LANES {
            let spring = (e + lane).min(self.ends.len() - 1);
            let [from, to] = self.ends[spring].map(|node| self.x[node as usize]);
            for i in 0..3 {
                d[i][lane] = to[i] - from[i];
            }
            l0[lane] = self.rest_length[spring];
            k[lane] = if spring == e + lane { self.stiffness[spring] } else { 0.0 };
        }
        let d = Vec3([Wide::load(simd, &d[0]), Wide::load(simd, &d[1]), Wide::load(simd, &d[2])]);
        WideSprings { d, l2: d.dot(d), l0: Wide::load(simd, &l0), k: Wide::load(simd, &k) }
    }
}

/// Computes the total energy of the springs, J: the sum of `k/2 (l - l0)^2`.
pub struct Energy<'a>(pub Springs<'a>);

impl WithSimd for Energy<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        // One partial sum per spring index modulo `LANES`, whatever the width of a register, so that the result is bitwise equal on all vector units.
        let mut sums = [Wide(simd.splat_f64s(0.0), simd); LANES];
        for e in (0..self.0.ends.len()).step_by(LANES) {
            for (i, sum) in sums[..LANES / S::F64_LANES].iter_mut().enumerate() {
                let WideSprings { l2, l0, k, .. } = self.0.gather(simd, e + i * S::F64_LANES);
                let stretch = l2.sqrt() - l0;
                *sum = *sum + k * 0.5 * stretch * stretch;
            }
        }
        let mut all = [0.0; LANES];
        for (i, sum) in sums[..LANES / S::F64_LANES].iter().enumerate() {
            sum.store(&mut all[i * S::F64_LANES..]);
        }
        all.iter().sum()
    }
}
