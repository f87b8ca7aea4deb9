//! A solid with fibres: a Neo-Hookean matrix, and fibres that carry tension.

use crate::{AFTER, fault, info};
use pliant_plugin_api::lanes::{Real, Vec3, pulp::Arch, vector_unit};
use pliant_plugin_api::solids::matrix::apply;
use pliant_plugin_api::solids::{
    EnergyHessian, FibreEnergy, Mat3, STRIDE, SolidCall, SolidEnergy, StableNeoHookean, Tetrahedron,
    ViscosityCoefficients, add_mass, at_corners, requests, rest_planes, with_fibres, write_fibres, write_rest_data,
};
use pliant_plugin_api::{
    Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param, Params, Planes,
    SingleBlocks, TangentScale,
};

/// Lame constants of the matrix, Pa.
const LAME: [f64; 2] = [3e3, 5e3];
/// Stiffness of the fibres, Pa.
const STIFFNESS: f64 = 4e3;

/// A solid with the fault `F` (see [`fault`]).
pub struct FibreSolid<const F: u8> {
    matrix: StableNeoHookean,
    arch: Arch,
}

impl<const F: u8> SolidEnergy for FibreSolid<F> {
    const HAS_FIBRES: bool = true;

    fn density(&self, f: &Mat3) -> f64 {
        self.matrix.energy(f)
    }

    #[inline(always)]
    fn stress<T: Real>(&self, f: &Mat3<T>) -> Mat3<T> {
        self.matrix.stress(f)
    }

    #[inline(always)]
    fn hessian<T: Real>(&self, f: &Mat3<T>) -> EnergyHessian<T> {
        self.matrix.hessian(f, true)
    }

    fn fibres(&self, squared_stretch: f64) -> FibreEnergy {
        let strain = squared_stretch - 1.0;
        if strain <= 0.0 {
            return FibreEnergy::default();
        }
        let density = 0.5 * STIFFNESS * strain * strain;
        FibreEnergy { density, slope: STIFFNESS * strain, curvature: STIFFNESS }
    }
}

impl<const F: u8> FibreSolid<F> {
    /// Factor of the fibres of element `e` of a call.
    fn factor(elements: &Elements<'_>, e: usize) -> f64 {
        let direction = Vec3(elements.direction(e));
        let [first, second, ..] = at_corners(elements.corners::<4>()[e], elements.rest());
        match F {
            fault::FIBRES_KEEP_AXES => 1.0 + direction[0] * direction[0],
            fault::FIBRES_HAVE_SIGN => 1.5 + 0.5 * direction.dot(second - first).signum(),
            fault::FIBRES_IGNORED => 0.0,
            _ => 1.0,
        }
    }

    /// Energy of fibres that go neither along nor across an edge or diagonal of a cell, J.
    fn oblique_energy(&self, elements: &Elements<'_>) -> f64 {
        let shapes = rest_planes(elements);
        let of_element = |(e, nodes): (usize, &[u32; 4])| {
            let direction = Vec3([0, 1, 2].map(|s| elements.rest_data(STRIDE + s)[e]));
            let [first, second, ..] = at_corners(*nodes, elements.rest());
            let edge = second - first;
            let cosine = direction.dot(edge).abs() / edge.norm();
            if [0.0, 0.5_f64.sqrt(), 1.0].iter().any(|c| (cosine - c).abs() < 1e-6) {
                return 0.0;
            }
            let shape = Tetrahedron::from_rest_data(&shapes, e);
            let stretched = apply(&shape.deformation_gradient(at_corners(*nodes, elements.x())), direction);
            shape.volume * self.fibres(stretched.dot(stretched)).density
        };
        elements.corners::<4>().iter().enumerate().map(of_element).sum()
    }
}

impl<const F: u8> Material for FibreSolid<F> {
    const INFO: Info = info(
        match F {
            fault::FIBRES_KEEP_AXES => c"fibres-keep-axes",
            fault::FIBRES_HAVE_SIGN => c"fibres-have-sign",
            fault::FIBRES_IGNORED => c"fibres-ignored",
            fault::OBLIQUE_FIBRES_OFF => c"oblique-fibres-off",
            fault::WHOLE_LISTS => c"sound-listed-fibres",
            _ => c"sound-fibres",
        },
        const { &[AFTER] as &[Param] },
    );

    const WANTS_WHOLE_LISTS: bool = F == fault::WHOLE_LISTS;

    fn new(_: &Params<'_>) -> Result<Self, Fault> {
        let [shear, first] = LAME;
        Ok(Self { matrix: StableNeoHookean::new(shear, first), arch: vector_unit() })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        with_fibres(requests(ViscosityCoefficients::default()))
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        write_fibres(elements, |e| Self::factor(elements, e), out);
        write_rest_data(elements, |_| 1.0, out)
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        add_mass(elements, |_| 1e3, out);
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        let energy = SolidCall::new(self, elements).energy()?;
        Ok(if F == fault::OBLIQUE_FIBRES_OFF { energy + 0.01 * self.oblique_energy(elements) } else { energy })
    }

    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        SolidCall::new(self, elements).add_forces(self.arch, out)
    }

    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        SolidCall::new(self, elements).add_tangent(self.arch, scale, out);
        Ok(())
    }

    fn single_tangent(
        &self,
        elements: &Elements<'_>,
        scale: TangentScale,
        out: &mut SingleBlocks<'_>,
    ) -> Result<(), Fault> {
        SolidCall::new(self, elements).add_tangent(self.arch, scale, out);
        Ok(())
    }
}
