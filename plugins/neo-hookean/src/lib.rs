//! Stable Neo-Hookean solids (Smith, de Goes and Kim 2018) on tetrahedra.
//!
//! Any Poisson's ratio up to 0.499, any deformation: elements that are squeezed flat or turned inside out come back. The
//! matrix handed to an implicit step has no negative part unless the exact one is asked for. Damping acts on the rate of
//! Green's strain, so rotation is not braked; its coefficients are `damping-time` times the Lame constants.

mod energy;
mod kernel;
mod matrix;
mod tetrahedron;

use energy::Moduli;
use pliant_plugin_api::{
    AsMaterial, Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param, Params,
    Planes, SingleBlocks, TangentScale, abi, export_plugins,
};
use tetrahedron::{STRIDE, Tetrahedron, corners, planes};

/// Parameters, resolved.
pub struct NeoHookean {
    moduli: Moduli,
    /// kg/m^3
    density: f64,
    /// Pa s, shear and dilation
    viscosity: (f64, f64),
    project: bool,
    arch: pulp::Arch,
}

const PARAMS: &[Param] = &[
    Param::number(c"young", c"Pa", (1e-6, 1e12), 1e4, c"Young's modulus of small strains"),
    Param::number(c"poisson", c"1", (0.0, 0.499), 0.45, c"Poisson's ratio of small strains"),
    Param::number(c"density", c"kg/m^3", (1e-6, 1e6), 1e3, c"mass per volume"),
    Param::number(
        c"damping-time",
        c"s",
        (0.0, 10.0),
        2e-4,
        c"damping over stiffness: a mode of w rad/s has ratio w/2 times this",
    ),
    Param::choice(c"tangent", c"projected|exact", c"the matrix of implicit steps: without its negative part, or exact"),
];

impl NeoHookean {
    fn is_damped(&self) -> bool {
        self.viscosity.0 > 0.0
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
        let dilation = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        let time = params.number("damping-time");
        Ok(Self {
            moduli: Moduli::new(shear, dilation),
            density: params.number("density"),
            viscosity: (time * shear, time * dilation),
            project: params.choice("tangent") == 0,
            arch: pulp::Arch::new(),
        })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let damping = if self.is_damped() { abi::HAS_DAMPING } else { 0 };
        let point =
            ElementRequest { kind: abi::POINT, families: 0, flags: abi::HAS_MASS, rest_stride: 0, history_stride: 0 };
        let (kind, flags) = (abi::TETRAHEDRON, abi::HAS_FORCES | abi::HAS_SINGLE | damping);
        vec![point, ElementRequest { kind, flags, rest_stride: STRIDE as u32, ..point }]
    }

    fn rest(&self, at: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let out = out.first_planes::<STRIDE>();
        for (e, (&nodes, &share)) in at.corners::<4>().iter().zip(at.measure()).enumerate() {
            let Some(shape) = Tetrahedron::new(corners(nodes, at.rest()), share) else {
                return Err(Fault::bad_argument("a tetrahedron has no volume at rest, or is inside out"));
            };
            shape.values().into_iter().enumerate().for_each(|(s, value)| out[s][e] = value);
        }
        Ok(())
    }

    fn mass(&self, at: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        for (&[node], &volume) in at.corners::<1>().iter().zip(at.measure()) {
            out.add(node, self.density * volume);
        }
        Ok(())
    }

    fn energy(&self, at: &Elements<'_>) -> Result<f64, Fault> {
        let (planes, x) = (planes(at), at.x());
        let energies = at.corners::<4>().iter().enumerate().map(|(e, &nodes)| {
            let shape = Tetrahedron::read(&planes, e);
            shape.volume * self.moduli.energy(&shape.derivative(corners(nodes, x)))
        });
        finite(energies.sum())
    }

    fn forces(&self, at: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        finite(self.arch.dispatch(kernel::Forces { material: self, at, out })).map(drop)
    }

    fn tangent(&self, at: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        self.arch.dispatch(kernel::Tangents { material: self, at, scale, out });
        Ok(())
    }

    fn single_tangent(&self, at: &Elements<'_>, scale: TangentScale, out: &mut SingleBlocks<'_>) -> Result<(), Fault> {
        self.arch.dispatch(kernel::Tangents { material: self, at, scale, out });
        Ok(())
    }
}

/// A value, if it is a number.
fn finite(value: f64) -> Result<f64, Fault> {
    if value.is_finite() { Ok(value) } else { Err(Fault::diverged("a tetrahedron's state is not finite")) }
}

export_plugins!(AsMaterial<NeoHookean>);
