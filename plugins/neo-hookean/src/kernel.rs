//! The flow of the elements of a call, one element for each lane of a vector register.

use crate::plasticity::{HISTORY, PlasticState, Plasticity};
use pliant_plugin_api::Elements;
use pliant_plugin_api::lanes::{Real, Vec3};
use pliant_plugin_api::solids::matrix::{product_transposed, transposed};
use pliant_plugin_api::solids::{Shapes, gather};
use pulp::{Simd, WithSimd};

/// Updates the history of elements that yield in a step.
pub(crate) struct Flow<'a, 'b> {
    pub(crate) plasticity: &'a Plasticity,
    pub(crate) elements: &'a Elements<'a>,
    pub(crate) history: [&'b mut [f64]; HISTORY],
}

impl WithSimd for Flow<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { plasticity, elements, mut history } = self;
        let nodes = elements.corners::<4>();
        let plastic: [&[f64]; HISTORY] = std::array::from_fn(|s| elements.history(s));
        let shapes = Shapes::new(elements).after_flow(std::array::from_fn(|s| plastic[s]));
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
            if !(-distance).any_below(-plasticity.certainly_elastic()) {
                continue;
            }
            let f = f.map(|row| row.0.map(|entry| entry.to_array()));
            for lane in 0..S::F64_LANES.min(nodes.len() - e) {
                let fe = [0, 1, 2].map(|i| Vec3([0, 1, 2].map(|j| f[i][j][lane])));
                let state = PlasticState::new(plastic.map(|plane| plane[e + lane]));
                if let Some(next) = plasticity.flow(&fe, &state, elements.dt()) {
                    next.history().into_iter().zip(&mut history).for_each(|(value, plane)| plane[e + lane] = value);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::NeoHookean;
    use pliant_plugin_api::lanes::units;
    use pliant_plugin_api::{TangentScale, abi, kit};

    #[test]
    fn every_vector_unit_gives_the_same_bytes() {
        let block = kit::block([3, 3, 2], 0.01, abi::STRUCTURAL);
        for (tangent, tau) in [(0.0, 1e-3), (1.0, 0.0)] {
            let mut material: NeoHookean = kit::material(&[("tangent", tangent), ("damping-time", tau)]).unwrap();
            let mut body = kit::Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
            for (i, (x, v)) in body.x.iter_mut().zip(&mut body.v).enumerate() {
                let i = i as f64;
                *x = [x[0] + 3e-3 * i.sin(), 0.8 * x[1] - 2e-3 * (2.0 * i).cos(), x[2] + 2e-3 * (0.7 * i).sin()];
                *v = [i.cos(), 0.5, -i.sin()];
            }
            // Elements that have collapsed to a plane, a line and a point.
            [1, 4, 5, 16].into_iter().for_each(|node| body.x[node] = body.x[0]);
            let mut results = Vec::new();
            for arch in units() {
                material.arch = arch;
                let both = TangentScale { stiffness: 0.7, damping: 0.3 };
                let single = body.single_blocks(&material, both, usize::MAX).unwrap();
                let single = single.into_iter().flatten().flatten().map(f64::from);
                let forces = body.forces(&material).unwrap().into_iter().flatten();
                let summed = body.summed_blocks(&material, both).unwrap();
                let summed_single = summed.single.into_iter().flatten().flatten().map(f64::from);
                let summed = summed.double.into_iter().flatten().flatten().chain(summed_single);
                let all = forces.chain(body.tangent(&material, both).unwrap()).chain(single).chain(summed);
                results.push(all.map(f64::to_bits).collect::<Vec<_>>());
            }
            for result in &results[1..] {
                assert_eq!(results[0].iter().zip(result).position(|(a, b)| a != b), None, "tangent {tangent}");
            }
            assert!(results[0].iter().all(|&bits| f64::from_bits(bits).is_finite()));
            assert!(results[0].iter().filter(|&&bits| f64::from_bits(bits) != 0.0).count() > 1000);
        }
    }

    #[test]
    fn nan_stays_and_does_not_reach_the_neighbouring_lanes() {
        let block = kit::block([3, 3, 2], 0.01, abi::STRUCTURAL);
        let material: NeoHookean = kit::material(&[("damping-time", 0.0)]).unwrap();
        let mut body = kit::Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
        // Inverted, so that the projection has something to do.
        body.x.iter_mut().for_each(|x| *x = [-0.5 * x[0], 0.4 * x[1] + 0.3 * x[0], 0.9 * x[2]]);
        let single_blocks = |body: &kit::Body| {
            let scale = TangentScale { stiffness: 1.0, damping: 0.0 };
            let single = body.single_blocks(&material, scale, usize::MAX).unwrap();
            single.into_iter().flatten().flatten().map(f32::to_bits).collect::<Vec<_>>()
        };
        let before = single_blocks(&body);
        body.x[0][1] = f64::NAN;
        let after = single_blocks(&body);
        assert!(after.iter().any(|bits| f32::from_bits(*bits).is_nan()));
        assert!(before.iter().zip(&after).all(|(a, b)| a == b || f32::from_bits(*b).is_nan()));
        assert!(before.iter().zip(&after).filter(|(a, b)| a == b).count() > before.len() / 2);
    }
}
