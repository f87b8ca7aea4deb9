//! Membrane forces of triangles.

use super::{load_triangles, prefetch_elements, sum_of_lanes};
use crate::membrane::Membrane;
use crate::triangle;
use pliant_plugin_api::lanes::{MAX_LANES, NodeVectorsView, Wide, gather};
use pliant_plugin_api::{Elements, NodeVectors, NodeWindow};
use pulp::{Simd, WithSimd};

/// Adds the forces of triangles. Returns a sum of all forces, which is finite only if each is.
pub(crate) struct Forces<'a, 'b> {
    pub(crate) membrane: &'a Membrane,
    pub(crate) elements: &'a Elements<'a>,
    pub(crate) out: &'a mut NodeVectors<'b>,
}

impl WithSimd for Forces<'_, '_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let NodeWindow { first_node, values } = self.out.window();
        // Implicit steps evaluate forces at zero velocity. The window has all nodes of the call.
        let velocities = &self.elements.v()[first_node..first_node + values.len()];
        let is_still = velocities.as_flattened().iter().all(|v| *v == 0.0);
        if is_still || self.membrane.damping_time == 0.0 {
            self.add::<S, false>(simd)
        } else {
            self.add::<S, true>(simd)
        }
    }
}

impl Forces<'_, '_> {
    #[inline(always)]
    fn add<S: Simd, const VISCOUS: bool>(self, simd: S) -> f64 {
        let Self { membrane, elements, out } = self;
        let (x, v) = (NodeVectorsView::new(elements.x()), NodeVectorsView::new(elements.v()));
        let nodes = elements.corners::<3>();
        let planes = core::array::from_fn(|s| elements.rest_data(s));
        let mut sum = Wide(simd.splat_f64s(0.0), simd);
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            prefetch_elements::<S, 3, { triangle::STRIDE }>(nodes, &planes, e);
            let shape = load_triangles(simd, &planes, e);
            let f = shape.deformation_gradient(gather(simd, nodes, e, x));
            let rate = if VISCOUS { Some(shape.deformation_gradient(gather(simd, nodes, e, v))) } else { None };
            let count = S::F64_LANES.min(nodes.len() - e);
            let wide = shape.forces(membrane.stress(&shape, f, rate));
            // By corner, axis and lane.
            let mut forces = [[[0.0; MAX_LANES]; 3]; 3];
            for corner in 0..3 {
                for i in 0..3 {
                    forces[corner][i] = wide[corner][i].to_array();
                }
                sum = sum + (wide[corner][0] + wide[corner][1] + wide[corner][2]);
            }
            for lane in 0..count {
                for corner in 0..3 {
                    let [x, y, z] = &forces[corner];
                    out.add(nodes[e + lane][corner], [x[lane], y[lane], z[lane]]);
                }
            }
        }
        sum_of_lanes(sum)
    }
}
