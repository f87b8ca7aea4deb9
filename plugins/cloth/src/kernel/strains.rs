//! Strains of coupled hinges and their gradients.

use super::{prefetch_elements, store_clamped, sum_of_lanes};
use crate::atan2::atan2;
use crate::dihedral::{self, ScaledSinCos};
use pliant_plugin_api::Elements;
use pliant_plugin_api::lanes::{NodeVectorsView, Wide, gather};
use pulp::{Simd, WithSimd};

/// Hinges whose angles are computed in one go: `atan2` is a long chain of dependent operations, and a processor overlaps two chains
/// only if they are close to each other in the program.
const HINGES_PER_PASS: usize = 64;

/// Writes the strain of each hinge, `length (angle - rest angle)`, m, and its gradient by corner and axis: 13 planes. Returns the sum of
/// the strains, which is finite only if each is.
pub(crate) struct Strains<'a> {
    pub(crate) elements: &'a Elements<'a>,
    pub(crate) out: [&'a mut [f64]; 13],
}

impl WithSimd for Strains<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { elements, out } = self;
        let (x, nodes) = (NodeVectorsView::new(elements.x()), elements.corners::<4>());
        let (rest_angles, lengths) = (elements.rest_data(0), elements.rest_data(1));
        let mut sum = Wide(simd.splat_f64s(0.0), simd);
        let (mut sines, mut cosines) = ([0.0; HINGES_PER_PASS], [0.0; HINGES_PER_PASS]);
        for begin in (0..nodes.len()).step_by(HINGES_PER_PASS) {
            let end = nodes.len().min(begin + HINGES_PER_PASS);
            for e in (begin..end).step_by(S::F64_LANES) {
                prefetch_elements::<S, 4, 2>(nodes, &[rest_angles, lengths], e);
                let corners = gather(simd, nodes, e, x);
                let length = Wide::load_clamped(simd, lengths, e);
                let (ScaledSinCos { sin, cos }, gradient) = (dihedral::sin_cos(corners), dihedral::gradient(corners));
                sin.store(&mut sines[e - begin..]);
                cos.store(&mut cosines[e - begin..]);
                for corner in 0..4 {
                    for i in 0..3 {
                        store_clamped(out[1 + 3 * corner + i], e, length * gradient[corner][i]);
                    }
                }
            }
            for e in (begin..end).step_by(S::F64_LANES) {
                let sin = Wide::load(simd, &sines[e - begin..]);
                let cos = Wide::load(simd, &cosines[e - begin..]);
                let angle_change = atan2(sin, cos) - Wide::load_clamped(simd, rest_angles, e);
                let strain = Wide::load_clamped(simd, lengths, e) * angle_change;
                store_clamped(out[0], e, strain);
                sum = sum + strain;
            }
        }
        sum_of_lanes(sum)
    }
}
