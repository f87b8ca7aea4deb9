//! Solids reinforced by fibres, as muscle, tendon, artery, wood or rubber with cords: the stable Neo-Hookean matrix of Smith, de Goes and Kim (2018)
//! and, in each element, one family of fibres that carry tension alone (module `fibres`; Holzapfel, Gasser and Ogden 2000).
//!
//! The directions of the fibres come from the scene (`[[body.fibre]]`); without them the solid is that of `neo-hookean`. Near rest, fibres add four
//! times `fibre-stiffness` to the modulus along them. Damping is that of the matrix.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod fibres;
#[cfg(test)]
mod tests;

use fibres::FibreLaw;
use pliant_plugin_api::lanes::{Real, pulp::Arch, vector_unit};
use pliant_plugin_api::solids::{
    EnergyHessian, FibreEnergy, Mat3, SolidCall, SolidEnergy, StableNeoHookean, ViscosityCoefficients, add_mass,
    lame_constants, requests, with_fibres, write_fibres, write_rest_data,
};
use pliant_plugin_api::{
    AsMaterial, Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param, Params,
    Planes, SingleBlocks, TangentScale, export_plugins,
};

/// The material of one body.
pub struct FibreReinforced {
    /// Energy of the matrix between the fibres.
    matrix: StableNeoHookean,
    /// Energy of the fibres.
    fibres: FibreLaw,
    /// Mass per volume, kg/m^3.
    density: f64,
    /// Coefficients of viscosity.
    viscosity: ViscosityCoefficients,
    /// Whether the Hessian of the matrix between the fibres is made positive semi-definite; that of fibres is.
    project: bool,
    /// The vector unit on which kernels run.
    arch: Arch,
}

const PARAMS: &[Param] = &[
    Param::number(c"young", c"Pa", 1e-6..=1e12, 1e4, c"Young's modulus of the matrix between the fibres").field(),
    Param::number(c"poisson", c"1", 0.0..=0.499, 0.45, c"Poisson's ratio of the matrix"),
    Param::number(c"density", c"kg/m^3", 1e-6..=1e6, 1e3, c"mass per volume").field(),
    Param::number(
        c"fibre-stiffness",
        c"Pa",
        0.0..=1e12,
        1e4,
        c"k1: a quarter of what fibres add to the modulus along them",
    )
    .field(),
    Param::number(
        c"fibre-stiffening",
        c"1",
        0.0..=1e3,
        1.0,
        c"k2: fibres stiffen by exp(k2 E^2) with E = stretch^2 - 1; 0: linearly in E",
    ),
    Param::number(
        c"damping-time",
        c"s",
        0.0..=10.0,
        2e-4,
        c"damping over stiffness of the matrix: a mode of w rad/s has a damping ratio of w/2 times this",
    ),
    Param::choice(c"tangent", c"projected|exact", c"matrix of implicit steps: made positive semi-definite, or exact"),
];

impl SolidEnergy for FibreReinforced {
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
        self.matrix.hessian(f, self.project)
    }

    fn fibres(&self, squared_stretch: f64) -> FibreEnergy {
        self.fibres.energy(squared_stretch)
    }

    #[inline(always)]
    fn viscosity(&self) -> ViscosityCoefficients {
        self.viscosity
    }
}

impl Material for FibreReinforced {
    const INFO: Info = Info {
        id: c"fibre-reinforced",
        name: c"Fibre-reinforced solid",
        version: c"0.1.0",
        summary: c"muscle, tendon, wood, reinforced rubber: fibres that carry tension (Holzapfel, Gasser and Ogden 2000) in a Neo-Hookean matrix",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let (young, poisson) = (params.number("young"), params.number("poisson"));
        let [shear, first_lame] = lame_constants(young, poisson);
        let time = params.number("damping-time");
        Ok(Self {
            matrix: StableNeoHookean::new(shear, first_lame),
            fibres: FibreLaw::new(params.number("fibre-stiffness"), params.number("fibre-stiffening")),
            density: params.number("density"),
            viscosity: ViscosityCoefficients { shear: time * shear, dilatation: time * first_lame },
            project: params.choice("tangent") == 0,
            arch: vector_unit(),
        })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        with_fibres(requests(self.viscosity))
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let (young, stiffness) = (elements.field("young"), elements.field("fibre-stiffness"));
        // The volume includes the factor of the matrix.
        write_fibres(elements, |e| stiffness.factor(e) / young.factor(e), out);
        write_rest_data(elements, |e| young.factor(e), out)
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        let density = elements.field("density");
        add_mass(elements, |e| self.density * density.factor(e), out);
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        SolidCall::new(self, elements).energy()
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

export_plugins!(AsMaterial<FibreReinforced>);
