//! Stable Neo-Hookean solids (Smith, de Goes and Kim 2018) on tetrahedra.
//!
//! Poisson's ratios up to 0.499 and any deformation: flattened and inverted elements recover. The matrix for implicit steps is positive
//! semi-definite unless the exact one is asked for. Damping acts on the rate of Green's strain, so it does not resist rotation; its
//! coefficients are `damping-time` times the Lame constants.
//!
//! With a `yield-strain` the shape at rest flows beyond it, as clay and dough do (module `plasticity`); without one the solid is elastic.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod energy;
mod kernel;
mod matrix;
mod plasticity;
mod svd;
mod tetrahedron;

use energy::Moduli;
use plasticity::{HISTORY, PlasticState, Plasticity};
use pliant_plugin_api::{
    AsMaterial, Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param, Params,
    Planes, SingleBlocks, TangentScale, abi, export_plugins,
};
use tetrahedron::{STRIDE, Tetrahedron, ViscosityCoefficients, at_corners, rest_planes};

/// The material of one body.
pub struct NeoHookean {
    /// Constants of the energy density.
    moduli: Moduli,
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
    Param::number(c"young", c"Pa", (1e-6, 1e12), 1e4, c"Young's modulus of small strains").field(),
    Param::number(c"poisson", c"1", (0.0, 0.499), 0.45, c"Poisson's ratio of small strains"),
    Param::number(c"density", c"kg/m^3", (1e-6, 1e6), 1e3, c"mass per volume").field(),
    Param::number(
        c"damping-time",
        c"s",
        (0.0, 10.0),
        2e-4,
        c"damping over stiffness: a mode of w rad/s has a damping ratio of w/2 times this",
    ),
    Param::choice(c"tangent", c"projected|exact", c"matrix of implicit steps: made positive semi-definite, or exact"),
    Param::number(
        c"yield-strain",
        c"1",
        (0.0, 1.0),
        0.0,
        c"strain of a drawn bar beyond which its shape at rest flows, as clay's does; 0: elastic, flows never",
    ),
    Param::number(
        c"hardening",
        c"1",
        (0.0, 100.0),
        0.0,
        c"increase of the yield strain per plastic strain: the hardening modulus over Young's",
    ),
    Param::number(
        c"flow-time",
        c"s",
        (0.0, 10.0),
        0.0,
        c"time constant of the flow at fixed deformation (Perzyna's overstress law); 0: does not depend on speed",
    ),
];

impl NeoHookean {
    /// Whether forces depend on velocity.
    fn is_damped(&self) -> bool {
        self.viscosity.shear > 0.0
    }

    /// The planes of history of a call; `None` for an elastic solid.
    fn plastic_planes<'a>(&self, elements: &Elements<'a>) -> Option<[&'a [f64]; HISTORY]> {
        self.plasticity.is_some().then(|| std::array::from_fn(|s| elements.history(s)))
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
        let shear = young / (2.0 * (1.0 + poisson));
        let first_lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        let (time, yield_strain) = (params.number("damping-time"), params.number("yield-strain"));
        Ok(Self {
            moduli: Moduli::new(shear, first_lame),
            density: params.number("density"),
            viscosity: ViscosityCoefficients { shear: time * shear, dilatation: time * first_lame },
            plasticity: (yield_strain > 0.0).then(|| {
                Plasticity::new(yield_strain, params.number("hardening"), params.number("flow-time"), poisson)
            }),
            project: params.choice("tangent") == 0,
            arch: pulp::Arch::new(),
        })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let damping = if self.is_damped() { abi::HAS_DAMPING } else { 0 };
        let point =
            ElementRequest { kind: abi::POINT, families: 0, flags: abi::HAS_MASS, rest_stride: 0, history_stride: 0 };
        let (history, history_stride) =
            if self.plasticity.is_some() { (abi::HAS_HISTORY, HISTORY as u32) } else { (0, 0) };
        let (kind, flags) = (abi::TETRAHEDRON, abi::HAS_FORCES | abi::HAS_SINGLE | damping | history);
        vec![point, ElementRequest { kind, flags, rest_stride: STRIDE as u32, history_stride, ..point }]
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let (planes, young) = (out.first_planes::<STRIDE>(), elements.field("young"));
        for (e, (&nodes, &share)) in elements.corners::<4>().iter().zip(elements.measure()).enumerate() {
            // Energy, stress and viscosity are proportional to Young's modulus times volume, so the stored volume includes the factor of the
            // modulus.
            let Some(shape) = Tetrahedron::new(at_corners(nodes, elements.rest()), share * young.factor(e)) else {
                return Err(Fault::bad_argument("a tetrahedron has no volume at rest, or is inverted"));
            };
            shape.rest_data().into_iter().enumerate().for_each(|(s, value)| planes[s][e] = value);
        }
        Ok(())
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        let density = elements.field("density");
        for (e, (&[node], &volume)) in elements.corners::<1>().iter().zip(elements.measure()).enumerate() {
            out.add(node, self.density * density.factor(e) * volume);
        }
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        let (planes, x) = (rest_planes(elements), elements.x());
        let plastic = self.plastic_planes(elements);
        let energies = elements.corners::<4>().iter().enumerate().map(|(e, &nodes)| {
            let mut shape = Tetrahedron::from_rest_data(&planes, e);
            if let Some(plastic) = &plastic {
                shape = shape.after_flow(&PlasticState::new(plastic.map(|plane| plane[e])).inverse);
            }
            shape.volume * self.moduli.energy(&shape.deformation_gradient(at_corners(nodes, x)))
        });
        finite(energies.sum())
    }

    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        finite(self.arch.dispatch(kernel::Forces { material: self, elements, out })).map(drop)
    }

    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        self.arch.dispatch(kernel::Tangent { material: self, elements, scale, out });
        Ok(())
    }

    fn single_tangent(
        &self,
        elements: &Elements<'_>,
        scale: TangentScale,
        out: &mut SingleBlocks<'_>,
    ) -> Result<(), Fault> {
        self.arch.dispatch(kernel::Tangent { material: self, elements, scale, out });
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

/// `value`, or a fault if it is not finite.
fn finite(value: f64) -> Result<f64, Fault> {
    if value.is_finite() { Ok(value) } else { Err(Fault::diverged("a tetrahedron's state is not finite")) }
}

export_plugins!(AsMaterial<NeoHookean>);
