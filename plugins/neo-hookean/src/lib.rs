//! Stable Neo-Hookean solids (Smith, de Goes and Kim 2018) on tetrahedra.
//!
//! Poisson's ratios up to 0.499 and any deformation: flattened and inverted elements recover. The matrix for implicit steps is positive
//! semi-definite unless the exact one is asked for. Damping acts on the rate of Green's strain, so it does not resist rotation; its
//! coefficients are `damping-time` times the Lame constants.
//!
//! With a `yield-strain` the shape at rest flows beyond it, as clay and dough do (module `plasticity`); without one the solid is elastic.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod kernel;
mod plasticity;

use plasticity::{HISTORY, Plasticity};
use pliant_plugin_api::lanes::{Real, vector_unit};
use pliant_plugin_api::solids::{
    EnergyHessian, Mat3, Shapes, SolidCall, SolidEnergy, StableNeoHookean, ViscosityCoefficients, add_mass,
    lame_constants, requests, write_rest_data,
};
use pliant_plugin_api::{
    AsMaterial, Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param, Params,
    Planes, SingleBlocks, TangentScale, abi, export_plugins,
};

/// The material of one body.
pub struct NeoHookean {
    /// Constants of the energy density.
    moduli: StableNeoHookean,
    /// Mass per volume, kg/m^3.
    density: f64,
    /// Coefficients of viscosity.
    viscosity: ViscosityCoefficients,
    /// Plastic flow; `None` for an elastic solid.
    plasticity: Option<Plasticity>,
    /// Whether the matrix is made positive semi-definite.
    project: bool,
    /// The vector unit on which kernels run.
    arch: pulp::Arch,
}

const PARAMS: &[Param] = &[
    Param::number(c"young", c"Pa", 1e-6..=1e12, 1e4, c"Young's modulus of small strains").field(),
    Param::number(c"poisson", c"1", 0.0..=0.499, 0.45, c"Poisson's ratio of small strains"),
    Param::number(c"density", c"kg/m^3", 1e-6..=1e6, 1e3, c"mass per volume").field(),
    Param::number(
        c"damping-time",
        c"s",
        0.0..=10.0,
        2e-4,
        c"damping over stiffness: a mode of w rad/s has a damping ratio of w/2 times this",
    ),
    Param::choice(c"tangent", c"projected|exact", c"matrix of implicit steps: made positive semi-definite, or exact"),
    Param::number(
        c"yield-strain",
        c"1",
        0.0..=1.0,
        0.0,
        c"strain of a drawn bar beyond which its shape at rest flows, as clay's does; 0: elastic, flows never",
    ),
    Param::number(
        c"hardening",
        c"1",
        0.0..=100.0,
        0.0,
        c"increase of the yield strain per plastic strain: the hardening modulus over Young's",
    ),
    Param::number(
        c"flow-time",
        c"s",
        0.0..=10.0,
        0.0,
        c"time constant of the flow at fixed deformation (Perzyna's overstress law); 0: does not depend on speed",
    ),
];

impl NeoHookean {
    /// A call for tetrahedra, after their plastic flow.
    fn call<'a>(&'a self, elements: &'a Elements<'a>) -> SolidCall<'a, Self> {
        let shapes = Shapes::new(elements);
        let has_flow = self.plasticity.is_some();
        let shapes = if has_flow { shapes.after_flow(std::array::from_fn(|s| elements.history(s))) } else { shapes };
        SolidCall { energy: self, elements, shapes }
    }
}

impl SolidEnergy for NeoHookean {
    fn density(&self, f: &Mat3) -> f64 {
        self.moduli.energy(f)
    }

    #[inline(always)]
    fn stress<T: Real>(&self, f: &Mat3<T>) -> Mat3<T> {
        self.moduli.stress(f)
    }

    #[inline(always)]
    fn hessian<T: Real>(&self, f: &Mat3<T>) -> EnergyHessian<T> {
        self.moduli.hessian(f, self.project)
    }

    #[inline(always)]
    fn viscosity(&self) -> ViscosityCoefficients {
        self.viscosity
    }
}

impl Material for NeoHookean {
    const INFO: Info = Info {
        id: c"neo-hookean",
        name: c"Stable Neo-Hookean solid",
        version: c"0.1.0",
        summary: c"nearly incompressible solids that survive inversion (Smith, de Goes and Kim 2018)",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let (young, poisson) = (params.number("young"), params.number("poisson"));
        let [shear, first_lame] = lame_constants(young, poisson);
        let (time, yield_strain) = (params.number("damping-time"), params.number("yield-strain"));
        Ok(Self {
            moduli: StableNeoHookean::new(shear, first_lame),
            density: params.number("density"),
            viscosity: ViscosityCoefficients { shear: time * shear, dilatation: time * first_lame },
            plasticity: (yield_strain > 0.0).then(|| {
                Plasticity::new(yield_strain, params.number("hardening"), params.number("flow-time"), poisson)
            }),
            project: params.choice("tangent") == 0,
            arch: vector_unit(),
        })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let mut requests = requests(self.viscosity);
        if self.plasticity.is_some() {
            requests[1].flags |= abi::HAS_HISTORY;
            requests[1].history_stride = HISTORY as u32;
        }
        requests
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let young = elements.field("young");
        write_rest_data(elements, |e| young.factor(e), out)
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        let density = elements.field("density");
        add_mass(elements, |e| self.density * density.factor(e), out);
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        self.call(elements).energy()
    }

    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        self.call(elements).add_forces(self.arch, out)
    }

    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        self.call(elements).add_tangent(self.arch, scale, out);
        Ok(())
    }

    fn single_tangent(
        &self,
        elements: &Elements<'_>,
        scale: TangentScale,
        out: &mut SingleBlocks<'_>,
    ) -> Result<(), Fault> {
        self.call(elements).add_tangent(self.arch, scale, out);
        Ok(())
    }

    fn advance(&self, elements: &Elements<'_>, history: &mut Planes<'_>) -> Result<(), Fault> {
        if let Some(plasticity) = &self.plasticity {
            let history = history.first_planes::<HISTORY>();
            self.arch.dispatch(kernel::Flow { plasticity, elements, history });
        }
        Ok(())
    }
}

export_plugins!(AsMaterial<NeoHookean>);
