//! SIMD kernels over the elements of a call: one element per lane of a vector register. Results are added element by element in the order
//! of the list, so the bytes do not depend on the vector unit.

use crate::NeoHookean;
use crate::matrix::{Mat3, Vec3, product_transposed, transposed};
use crate::plasticity::{HISTORY, PlasticState, Plasticity};
use crate::tetrahedron::{
    Damping, STRIDE, Stiffness, Tetrahedron, ViscosityCoefficients, add_viscous_stress, rest_planes,
};
use pliant_plugin_api::lanes::{MAX_LANES, Real, Wide};
use pliant_plugin_api::{BlockScalar, Blocks, Elements, NodeVectors, TangentScale, pair_index};
use pulp::{Simd, WithSimd};

/// The vectors at the corners of elements `e, e + 1, ..`; lanes past the end repeat the last element.
#[inline(always)]
fn gather<S: Simd>(simd: S, nodes: &[[u32; 4]], e: usize, vectors: &[[f64; 3]]) -> [Vec3<Wide<S>>; 4] {
    let mut lanes = [[[0.0; MAX_LANES]; 3]; 4];
    for lane in 0..S::F64_LANES {
        let nodes = nodes[(e + lane).min(nodes.len() - 1)];
        for corner in 0..4 {
            let vector = vectors[nodes[corner] as usize];
            for i in 0..3 {
                lanes[corner][i][lane] = vector[i];
            }
        }
    }
    let mut all = [Vec3([Wide(simd.splat_f64s(0.0), simd); 3]); 4];
    for corner in 0..4 {
        for i in 0..3 {
            all[corner][i] = Wide::load(simd, &lanes[corner][i]);
        }
    }
    all
}

/// The planes of data that give the shapes of a call's elements.
struct ShapePlanes<'a> {
    /// Rest data.
    rest: [&'a [f64]; STRIDE],
    /// History of a plastic solid; `None` for an elastic one.
    plastic: Option<[&'a [f64]; HISTORY]>,
}

impl<'a> ShapePlanes<'a> {
    /// The planes of a call.
    fn of(material: &NeoHookean, elements: &Elements<'a>) -> Self {
        Self { rest: rest_planes(elements), plastic: material.plastic_planes(elements) }
    }

    /// Shapes of elements `e, e + 1, ..`, after their plastic flow.
    #[inline(always)]
    fn load<S: Simd>(&self, simd: S, e: usize) -> Tetrahedron<Wide<S>> {
        let mut gradients = [Vec3([Wide(simd.splat_f64s(0.0), simd); 3]); 3];
        for corner in 0..3 {
            for i in 0..3 {
                gradients[corner][i] = Wide::load_clamped(simd, self.rest[3 * corner + i], e);
            }
        }
        let shape = Tetrahedron::from_gradients(gradients, Wide::load_clamped(simd, self.rest[9], e));
        let Some(plastic) = &self.plastic else { return shape };
        let mut inverse = [Vec3([Wide(simd.splat_f64s(0.0), simd); 3]); 3];
        for i in 0..3 {
            for j in 0..3 {
                let one = Wide(simd.splat_f64s(if i == j { 1.0 } else { 0.0 }), simd);
                inverse[i][j] = one + Wide::load_clamped(simd, plastic[3 * i + j], e);
            }
        }
        shape.after_flow(&inverse)
    }
}

/// Adds forces. Returns a sum over the elements that is finite only if the forces are.
pub(crate) struct Forces<'a, 'b> {
    pub(crate) material: &'a NeoHookean,
    pub(crate) elements: &'a Elements<'a>,
    pub(crate) out: &'a mut NodeVectors<'b>,
}

impl WithSimd for Forces<'_, '_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { material, elements, out } = self;
        let (nodes, planes, mut sum) = (elements.corners::<4>(), ShapePlanes::of(material, elements), 0.0);
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let shape = planes.load(simd, e);
            let f = shape.deformation_gradient(gather(simd, nodes, e, elements.x()));
            let mut stress = material.moduli.stress(&f);
            if material.is_damped() {
                let f_rate = shape.deformation_gradient(gather(simd, nodes, e, elements.v()));
                add_viscous_stress(&f, &f_rate, material.viscosity, &mut stress);
            }
            let forces = shape.forces(&stress);
            // By corner, axis and lane.
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
                sum += lanes[1][0][lane] + lanes[2][1][lane] + lanes[3][2][lane];
            }
        }
        sum
    }
}

/// Adds `scale.stiffness` K + `scale.damping` C.
pub(crate) struct Tangent<'a, 'b, T> {
    pub(crate) material: &'a NeoHookean,
    pub(crate) elements: &'a Elements<'a>,
    pub(crate) scale: TangentScale,
    pub(crate) out: &'a mut Blocks<'b, T>,
}

impl<T: BlockScalar> WithSimd for Tangent<'_, '_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { material, elements, scale, out } = self;
        let (nodes, planes) = (elements.corners::<4>(), ShapePlanes::of(material, elements));
        let viscosity = ViscosityCoefficients {
            shear: scale.damping * material.viscosity.shear,
            dilatation: scale.damping * material.viscosity.dilatation,
        };
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let shape = planes.load(simd, e);
            let f = shape.deformation_gradient(gather(simd, nodes, e, elements.x()));
            let stiffness = if scale.stiffness == 0.0 {
                None
            } else {
                Some(Stiffness::new(&shape, scale.stiffness, material.moduli.hessian(&f, material.project)))
            };
            let damping = if viscosity.shear == 0.0 { None } else { Some(Damping::new(&shape, &f, viscosity)) };
            let elements = e..nodes.len().min(e + S::F64_LANES);
            for a in 0..4 {
                for b in a..4 {
                    if a == b && !T::HAS_DIAGONAL_BLOCKS {
                        continue;
                    }
                    let mut block = [Vec3([Wide(simd.splat_f64s(0.0), simd); 3]); 3];
                    if let Some(stiffness) = &stiffness {
                        block = stiffness.block(a, b);
                    }
                    if let Some(damping) = &damping {
                        damping.add_block(a, b, &mut block);
                    }
                    add_blocks(out, elements.clone(), pair_index(a, b, 4), &block);
                }
            }
        }
    }
}

/// Adds the block of a pair of corners to the matrix for a range of elements, one per lane.
#[inline(always)]
fn add_blocks<S: Simd, T: BlockScalar>(
    out: &mut Blocks<'_, T>,
    elements: core::ops::Range<usize>,
    pair: usize,
    block: &Mat3<Wide<S>>,
) {
    let mut blocks = [[[T::from_f64(0.0); 3]; 3]; MAX_LANES];
    for i in 0..3 {
        for j in 0..3 {
            let entries = block[i][j].to_array();
            for lane in 0..S::F64_LANES {
                blocks[lane][i][j] = T::from_f64(entries[lane]);
            }
        }
    }
    for (e, block) in elements.zip(&blocks) {
        out.add(e, pair, block);
    }
}

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
        let plastic = std::array::from_fn(|s| elements.history(s));
        let planes = ShapePlanes { rest: rest_planes(elements), plastic: Some(plastic) };
        for e in (0..nodes.len()).step_by(S::F64_LANES) {
            let f = planes.load(simd, e).deformation_gradient(gather(simd, nodes, e, elements.x()));
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
