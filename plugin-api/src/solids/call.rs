//! The calls of a material, for a solid with an energy density.

use super::energy::SolidEnergy;
use super::fibres::FibrePlanes;
use super::kernel::{Forces, Tangent};
use super::matrix::Mat3;
use super::tetrahedron::{STRIDE, Tetrahedron, at_corners, rest_planes};
use super::viscosity::ViscosityCoefficients;
use crate::lanes::{Vec3, Wide};
use crate::{BlockScalar, Blocks, ElementRequest, Elements, Fault, NodeScalars, NodeVectors, TangentScale, abi};
use pulp::{Arch, Simd};

/// The requests of a solid: points that have mass, and tetrahedra that have forces.
pub fn requests(viscosity: ViscosityCoefficients) -> Vec<ElementRequest> {
    let damping = if viscosity.shear > 0.0 { abi::HAS_DAMPING } else { 0 };
    let flags = abi::HAS_FORCES | abi::HAS_SINGLE | damping;
    let point =
        ElementRequest { kind: abi::POINT, families: 0, flags: abi::HAS_MASS, rest_stride: 0, history_stride: 0 };
    vec![point, ElementRequest { kind: abi::TETRAHEDRON, flags, rest_stride: STRIDE as u32, ..point }]
}

/// Adds the mass of points: `density` (kg/m^3) of an element times its volume.
pub fn add_mass(elements: &Elements<'_>, density: impl Fn(usize) -> f64, out: &mut NodeScalars<'_>) {
    for (e, (&[node], &volume)) in elements.corners::<1>().iter().zip(elements.measure()).enumerate() {
        out.add(node, density(e) * volume);
    }
}

/// The shapes at rest of a call's elements, and their plastic flow, damage or fibres if they have any.
#[derive(Clone, Copy)]
pub struct Shapes<'a> {
    rest: [&'a [f64]; STRIDE],
    flow: Option<[&'a [f64]; 9]>,
    damage: Option<&'a [f64]>,
    pub(super) fibres: Option<FibrePlanes<'a>>,
}

impl<'a> Shapes<'a> {
    /// The shapes of elements whose rest data [`write_rest_data`](super::write_rest_data) wrote.
    pub fn new(elements: &Elements<'a>) -> Self {
        Self { rest: rest_planes(elements), flow: None, damage: None, fibres: None }
    }

    /// Adds a plastic deformation Fp: planes of `Fp^-1 - I` by rows, from the history. The energy is then a function of `F Fp^-1`.
    pub fn after_flow(self, flow: [&'a [f64]; 9]) -> Self {
        Self { flow: Some(flow), ..self }
    }

    /// Adds a damage d, 0 to 1, of each element, from the history: energy, forces, stiffness and viscosity are multiplied by 1 - d.
    pub fn with_damage(self, damage: &'a [f64]) -> Self {
        Self { damage: Some(damage), ..self }
    }

    /// Adds fibres, whose rest data [`write_fibres`](super::write_fibres) wrote.
    fn with_fibres(self, elements: &Elements<'a>) -> Self {
        Self { fibres: Some(FibrePlanes::new(elements)), ..self }
    }

    /// Shapes of elements `e, e + 1, ..`, one per lane; lanes past the end repeat the last one.
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S, e: usize) -> Tetrahedron<Wide<S>> {
        let mut gradients = [Vec3([Wide(simd.splat_f64s(0.0), simd); 3]); 3];
        for corner in 0..3 {
            for i in 0..3 {
                gradients[corner][i] = Wide::load_clamped(simd, self.rest[3 * corner + i], e);
            }
        }
        let mut volume = Wide::load_clamped(simd, self.rest[9], e);
        if let Some(damage) = self.damage {
            volume = volume * (Wide(simd.splat_f64s(1.0), simd) - Wide::load_clamped(simd, damage, e));
        }
        let shape = Tetrahedron::from_gradients(gradients, volume);
        let Some(flow) = &self.flow else { return shape };
        let mut inverse = [Vec3([Wide(simd.splat_f64s(0.0), simd); 3]); 3];
        for i in 0..3 {
            for j in 0..3 {
                let one = Wide(simd.splat_f64s(if i == j { 1.0 } else { 0.0 }), simd);
                inverse[i][j] = one + Wide::load_clamped(simd, flow[3 * i + j], e);
            }
        }
        shape.after_flow(&inverse)
    }

    /// Shape of element `e`.
    pub fn at(&self, e: usize) -> Tetrahedron {
        let mut shape = Tetrahedron::from_rest_data(&self.rest, e);
        if let Some(damage) = self.damage {
            shape.volume *= 1.0 - damage[e];
        }
        let Some(flow) = &self.flow else { return shape };
        let entry = |i: usize, j: usize| (if i == j { 1.0 } else { 0.0 }) + flow[3 * i + j][e];
        let inverse: Mat3 = [0, 1, 2].map(|i| Vec3([0, 1, 2].map(|j| entry(i, j))));
        shape.after_flow(&inverse)
    }
}

/// A call for the elements of a solid.
pub struct SolidCall<'a, E> {
    /// The energy density.
    pub energy: &'a E,
    /// The tetrahedra of the call.
    pub elements: &'a Elements<'a>,
    /// Their shapes at rest.
    pub shapes: Shapes<'a>,
}

impl<'a, E: SolidEnergy> SolidCall<'a, E> {
    /// A call for elements whose rest data [`write_rest_data`](super::write_rest_data) wrote, without plastic flow.
    pub fn new(energy: &'a E, elements: &'a Elements<'a>) -> Self {
        let shapes = Shapes::new(elements);
        Self { energy, elements, shapes: if E::HAS_FIBRES { shapes.with_fibres(elements) } else { shapes } }
    }

    /// Sum of the energies, J.
    ///
    /// # Errors
    /// A state that is not finite.
    pub fn energy(&self) -> Result<f64, Fault> {
        let x = self.elements.x();
        let energies = self.elements.corners::<4>().iter().enumerate().map(|(e, &nodes)| {
            let shape = self.shapes.at(e);
            let f = shape.deformation_gradient(at_corners(nodes, x));
            let density = self.energy.density(&f);
            match &self.shapes.fibres {
                Some(fibres) => shape.volume * (density + fibres.density(self.energy, e, &f)),
                None => shape.volume * density,
            }
        });
        finite(energies.sum())
    }

    /// Adds the forces, N, on the vector unit `arch`.
    ///
    /// # Errors
    /// A state that is not finite.
    pub fn add_forces(&self, arch: Arch, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        finite(arch.dispatch(Forces { call: self, out })).map(drop)
    }

    /// Adds the blocks of `scale.stiffness` K + `scale.damping` C on the vector unit `arch`.
    pub fn add_tangent<T: BlockScalar>(&self, arch: Arch, scale: TangentScale, out: &mut Blocks<'_, T>) {
        arch.dispatch(Tangent { call: self, scale, out });
    }
}

/// `value`, or a fault if it is not finite.
fn finite(value: f64) -> Result<f64, Fault> {
    if value.is_finite() { Ok(value) } else { Err(Fault::diverged("a tetrahedron's state is not finite")) }
}
