//! Passes over the elements of a call, as many at once as the vector unit takes; results are added element by element in their order.

use crate::NeoHookean;
use crate::matrix::{M3, V3};
use crate::tetrahedron::{STRIDE, Stiffness, Tetrahedron, Viscosity, add_viscous, planes};
use pliant_plugin_api::lanes::{MAX_LANES, Wide};
use pliant_plugin_api::{BlockScalar, Blocks, Elements, NodeVectors, TangentScale, pair_index};
use pulp::{Simd, WithSimd};

/// What is known of the corners of elements `e ..`; lanes past the end repeat the last element.
#[inline(always)]
fn gather<S: Simd>(simd: S, nodes: &[[u32; 4]], e: usize, of: &[[f64; 3]]) -> [V3<Wide<S>>; 4] {
    let mut lanes = [[[0.0; MAX_LANES]; 3]; 4];
    for lane in 0..S::F64_LANES {
        let nodes = nodes[(e + lane).min(nodes.len() - 1)];
        for corner in 0..4 {
            let value = of[nodes[corner] as usize];
            for i in 0..3 {
                lanes[corner][i][lane] = value[i];
            }
        }
    }
    let mut all = [[Wide(simd.splat_f64s(0.0), simd); 3]; 4];
    for corner in 0..4 {
        for i in 0..3 {
            all[corner][i] = Wide::load(simd, &lanes[corner][i]);
        }
    }
    all
}

#[inline(always)]
fn shapes<S: Simd>(simd: S, planes: &[&[f64]; STRIDE], e: usize) -> Tetrahedron<Wide<S>> {
    let mut gradients = [[Wide(simd.splat_f64s(0.0), simd); 3]; 3];
    for corner in 0..3 {
        for i in 0..3 {
            gradients[corner][i] = Wide::load_clamped(simd, planes[3 * corner + i], e);
        }
    }
    Tetrahedron::whole(gradients, Wide::load_clamped(simd, planes[9], e))
}

/// Adds forces. Gives a sum of them, to see whether all is finite.
pub(crate) struct Forces<'a, 'b> {
    pub(crate) material: &'a NeoHookean,
    pub(crate) at: &'a Elements<'a>,
    pub(crate) out: &'a mut NodeVectors<'b>,
}

impl WithSimd for Forces<'_, '_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { material, at, out } = self;
        let (nodes, planes, mut seen) = (at.corners::<4>(), planes(at), 0.0);
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let shape = shapes(simd, &planes, e);
            let f = shape.derivative(gather(simd, nodes, e, at.x()));
            let mut stress = material.moduli.stress(&f);
            if material.is_damped() {
                let rate = shape.derivative(gather(simd, nodes, e, at.v()));
                add_viscous(&f, &rate, material.viscosity, &mut stress);
            }
            let forces = shape.forces(&stress);
            let mut lanes = [[[0.0; MAX_LANES]; 3]; 4];
            for corner in 0..4 {
                for i in 0..3 {
                    lanes[corner][i] = forces[corner][i].to_array();
                }
            }
            for lane in 0..S::F64_LANES.min(nodes.len() - e) {
                for corner in 0..4 {
                    let [x, y, z] = &lanes[corner];
                    out.add(nodes[e + lane][corner], [x[lane], y[lane], z[lane]]);
                }
                seen += lanes[1][0][lane] + lanes[2][1][lane] + lanes[3][2][lane];
            }
        }
        seen
    }
}

/// Adds `scale.stiffness` K + `scale.damping` C.
pub(crate) struct Tangents<'a, 'b, T> {
    pub(crate) material: &'a NeoHookean,
    pub(crate) at: &'a Elements<'a>,
    pub(crate) scale: TangentScale,
    pub(crate) out: &'a mut Blocks<'b, T>,
}

impl<T: BlockScalar> WithSimd for Tangents<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { material, at, scale, out } = self;
        let (nodes, planes) = (at.corners::<4>(), planes(at));
        let (eta, zeta) = material.viscosity;
        let viscosity = (scale.damping * eta, scale.damping * zeta);
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let shape = shapes(simd, &planes, e);
            let f = shape.derivative(gather(simd, nodes, e, at.x()));
            let stiffness = if scale.stiffness == 0.0 {
                None
            } else {
                Some(Stiffness::new(&shape, scale.stiffness, material.moduli.curvature(&f, material.project)))
            };
            let viscous = if viscosity.0 == 0.0 { None } else { Some(Viscosity::new(&shape, &f, viscosity)) };
            let count = S::F64_LANES.min(nodes.len() - e);
            for a in 0..4 {
                for b in a..4 {
                    if a == b && !T::HAS_DIAGONAL_BLOCKS {
                        continue;
                    }
                    let mut block = [[Wide(simd.splat_f64s(0.0), simd); 3]; 3];
                    if let Some(stiffness) = &stiffness {
                        block = stiffness.block(a, b);
                    }
                    if let Some(viscous) = &viscous {
                        viscous.add(a, b, &mut block);
                    }
                    add(out, (e, count, pair_index(a, b, 4)), &block);
                }
            }
        }
    }
}

/// Adds blocks of `count` elements from `e` on.
#[inline(always)]
fn add<S: Simd, T: BlockScalar>(out: &mut Blocks<'_, T>, (e, count, pair): (usize, usize, usize), block: &M3<Wide<S>>) {
    let mut rows = [[[T::from_f64(0.0); 3]; 3]; MAX_LANES];
    for i in 0..3 {
        for j in 0..3 {
            let entries = block[i][j].to_array();
            for lane in 0..S::F64_LANES {
                rows[lane][i][j] = T::from_f64(entries[lane]);
            }
        }
    }
    for lane in 0..count {
        out.add(e + lane, pair, &rows[lane]);
    }
}

#[cfg(test)]
mod tests {
    use crate::NeoHookean;
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
            // Some that have collapsed, to a plane, a line and a point.
            [1, 4, 5, 16].into_iter().for_each(|node| body.x[node] = body.x[0]);
            let units = [Some(pulp::Arch::Scalar), Some(pulp::Arch::new())].into_iter();
            #[cfg(target_arch = "x86_64")]
            let units = units.chain([pulp::x86::V3::try_new().map(pulp::Arch::V3)]);
            let mut results = Vec::new();
            for arch in units.flatten() {
                material.arch = arch;
                let both = TangentScale { stiffness: 0.7, damping: 0.3 };
                let single = body.single_blocks(&material, both, usize::MAX).unwrap();
                let single = single.into_iter().flatten().flatten().map(f64::from);
                let forces = body.forces(&material).unwrap().into_iter().flatten();
                let all = forces.chain(body.tangent(&material, both).unwrap()).chain(single);
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
    fn stiffness_of_what_is_no_number_is_none_and_that_of_others_stays() {
        let block = kit::block([3, 3, 2], 0.01, abi::STRUCTURAL);
        let material: NeoHookean = kit::material(&[("damping-time", 0.0)]).unwrap();
        let mut body = kit::Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).unwrap();
        // Turned inside out, so that it has to be made positive.
        body.x.iter_mut().for_each(|x| *x = [-0.5 * x[0], 0.4 * x[1] + 0.3 * x[0], 0.9 * x[2]]);
        let of = |body: &kit::Body| {
            let scale = TangentScale { stiffness: 1.0, damping: 0.0 };
            let single = body.single_blocks(&material, scale, usize::MAX).unwrap();
            single.into_iter().flatten().flatten().map(f32::to_bits).collect::<Vec<_>>()
        };
        let before = of(&body);
        body.x[0][1] = f64::NAN;
        let after = of(&body);
        assert!(after.iter().any(|bits| f32::from_bits(*bits).is_nan()));
        assert!(before.iter().zip(&after).all(|(a, b)| a == b || f32::from_bits(*b).is_nan()));
        assert!(before.iter().zip(&after).filter(|(a, b)| a == b).count() > before.len() / 2);
    }
}
