//! The growth of damage in the elements of a call, one element for each lane of a vector register.

use crate::law::{Constants, Law};
use pliant_plugin_api::Elements;
use pliant_plugin_api::lanes::{Real, Vec3, pulp};
use pliant_plugin_api::solids::matrix::{product_transposed, transposed};
use pliant_plugin_api::solids::{STRIDE, Shapes, gather};
use pulp::{Simd, WithSimd};

/// Doubles of history per element: the damage, then the width of the element across its crack, m, from the step on in which damage began.
pub const HISTORY: usize = 2;
/// Planes of rest data per element: those of the shape, then the equivalent strain at which damage begins.
pub const REST: usize = STRIDE + 1;

/// Updates the history of elements whose equivalent strain has come beyond what they have had.
pub struct Growth<'a, 'b, C> {
    /// The tetrahedra of the call.
    pub elements: &'a Elements<'a>,
    /// From which damage follows: the equivalent strain of a deformation.
    pub law: &'a Law,
    /// The constants of an element of the call.
    pub constants: C,
    /// The history, to be updated.
    pub history: [&'b mut [f64]; HISTORY],
}

impl<C: Fn(usize) -> Constants> WithSimd for Growth<'_, '_, C> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { elements, law, constants, history: [damage, width] } = self;
        let (nodes, shapes, begin) = (elements.corners::<4>(), Shapes::new(elements), elements.rest_data(STRIDE));
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let f = shapes.load(simd, e).deformation_gradient(gather(simd, nodes, e, elements.x()));
            let columns = transposed(&f);
            let c = product_transposed(&columns, &columns);
            let mut distance = c[0][0].splat(0.0);
            for i in 0..3 {
                for j in 0..3 {
                    let entry = if i == j { c[i][j] - c[i][j].splat(1.0) } else { c[i][j] };
                    distance = distance + entry * entry;
                }
            }
            let (distance, f) = (distance.to_array(), f.map(|row| row.0.map(|entry| entry.to_array())));
            for lane in 0..S::F64_LANES.min(nodes.len() - e) {
                let e = e + lane;
                if distance[lane] <= law.certainly_elastic(begin[e]) {
                    continue;
                }
                let state = law.state(&[0, 1, 2].map(|i| Vec3([0, 1, 2].map(|j| f[i][j][lane]))));
                // Below the strength nothing is remembered, so rounding at rest is not either.
                if state.strain.is_nan() || state.strain <= begin[e] {
                    continue;
                }
                if width[e] == 0.0 {
                    width[e] = shapes.at(e).crack_band_width(state.normal);
                }
                let band = constants(e).band(begin[e], width[e]);
                damage[e] = damage[e].max(band.damage(state.strain, |e| e));
            }
        }
    }
}
