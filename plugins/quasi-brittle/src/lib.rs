//! Solids that fracture, as biscuit, chalk, plaster, ice or a stiff gel: the stable Neo-Hookean energy of Smith, de Goes and Kim (2018), with isotropic
//! damage whose fracture energy does not depend on the mesh.
//!
//! The energy is `(1 - d) psi(F)` with a damage d that follows from the largest equivalent strain e a tetrahedron has had (module `law`). Beyond the strength f
//! the stress `(1 - d) Y e` falls linearly with e. Where it comes to zero depends on the extent h of the tetrahedron across the crack (Oliver 1989), such
//! that what it dissipates is G / h for each volume (crack band, Bažant and Oh 1983): a layer of tetrahedra that a crack goes through takes the
//! fracture energy G for each area of it, whatever their size. There the tetrahedron has failed (`pliant.failure/1`). Tetrahedra that at their strength
//! have stored more than that, those wider than about `2 G Y / f^2` with Young's modulus Y, fail at once and take what they have stored.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod damage;
mod law;

use damage::{Growth, HISTORY, REST};
use law::{Constants, Law};
use pliant_plugin_api::lanes::{Real, pulp::Arch, vector_unit};
use pliant_plugin_api::solids::{
    EnergyHessian, Mat3, STRIDE, Shapes, SolidCall, SolidEnergy, StableNeoHookean, ViscosityCoefficients, add_mass,
    lame_constants, requests, write_rest_data,
};
use pliant_plugin_api::{
    AsMaterial, Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param, Params,
    Planes, SingleBlocks, TangentScale, TooWide, abi, export_plugins,
};

/// The material of one body.
pub struct QuasiBrittle {
    /// Energy of what is not damaged.
    moduli: StableNeoHookean,
    /// What damage follows from.
    law: Law,
    /// Constants of an element without fields.
    constants: Constants,
    /// Mass per volume, kg/m^3.
    density: f64,
    /// Coefficients of viscosity.
    viscosity: ViscosityCoefficients,
    /// Whether the matrix is made positive semi-definite.
    project: bool,
    /// The vector unit on which kernels run.
    arch: Arch,
}

const PARAMS: &[Param] = &[
    Param::number(c"young", c"Pa", 1.0..=1e12, 1e6, c"Young's modulus of small strains").field(),
    Param::number(c"poisson", c"1", 0.0..=0.499, 0.2, c"Poisson's ratio of small strains"),
    Param::number(c"density", c"kg/m^3", 1e-3..=1e5, 1e3, c"mass per volume").field(),
    Param::number(c"strength", c"Pa", 1.0..=1e12, 5e4, c"tensile strength: stress at which damage begins").field(),
    Param::number(
        c"fracture-energy",
        c"J/m^2",
        1e-6..=1e9,
        50.0,
        c"energy per area of a crack; tetrahedra wider than 2 G Y / f^2 fail at once and take more",
    )
    .field(),
    Param::number(c"compression-ratio", c"1", 1.0..=1e6, 10.0, c"compressive over tensile strength"),
    Param::number(
        c"damping-time",
        c"s",
        0.0..=10.0,
        2e-4,
        c"damping over stiffness: a mode of w rad/s has a damping ratio of w/2 times this",
    ),
    Param::choice(c"tangent", c"projected|exact", c"matrix of implicit steps: made positive semi-definite, or exact"),
];

impl QuasiBrittle {
    /// A call for tetrahedra, with their damage.
    fn call<'a>(&'a self, elements: &'a Elements<'a>) -> SolidCall<'a, Self> {
        SolidCall { energy: self, elements, shapes: Shapes::new(elements).with_damage(elements.history(0)) }
    }

    /// The constants of each element of a call.
    fn constants<'a>(&self, elements: &Elements<'a>) -> impl Fn(usize) -> Constants + use<'a> {
        let [young, strength, energy] = ["young", "strength", "fracture-energy"].map(|key| elements.field(key));
        let Constants { young: y, strength: f, fracture_energy: g } = self.constants;
        move |e| Constants {
            young: y * young.factor(e),
            strength: f * strength.factor(e),
            fracture_energy: g * energy.factor(e),
        }
    }

    /// The constants of each element of a call, and the equivalent strain at which its damage begins. Those with the same ratio of strength to modulus, as all
    /// without fields, share one evaluation.
    fn strengths<'a>(&'a self, elements: &Elements<'a>) -> impl FnMut(usize) -> (Constants, f64) + use<'a> {
        let (constants, mut last) = (self.constants(elements), (f64::NAN, 0.0));
        move |e| {
            let constants = constants(e);
            let ratio = constants.strength / constants.young;
            if ratio != last.0 {
                last = (ratio, self.law.begin(ratio));
            }
            (constants, last.1)
        }
    }
}

impl SolidEnergy for QuasiBrittle {
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

impl Material for QuasiBrittle {
    const INFO: Info = Info {
        id: c"quasi-brittle",
        name: c"Quasi-brittle solid",
        version: c"0.1.0",
        summary: c"solids that fracture: damage whose fracture energy does not depend on the size of tetrahedra",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let (young, poisson) = (params.number("young"), params.number("poisson"));
        let ([shear, first_lame], time) = (lame_constants(young, poisson), params.number("damping-time"));
        Ok(Self {
            moduli: StableNeoHookean::new(shear, first_lame),
            law: Law::new(poisson, params.number("compression-ratio")),
            constants: Constants {
                young,
                strength: params.number("strength"),
                fracture_energy: params.number("fracture-energy"),
            },
            density: params.number("density"),
            viscosity: ViscosityCoefficients { shear: time * shear, dilatation: time * first_lame },
            project: params.choice("tangent") == 0,
            arch: vector_unit(),
        })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let mut requests = requests(self.viscosity);
        requests[1].flags |= abi::HAS_HISTORY | abi::CAN_FAIL;
        (requests[1].rest_stride, requests[1].history_stride) = (REST as u32, HISTORY as u32);
        requests
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let young = elements.field("young");
        write_rest_data(elements, |e| young.factor(e), out)?;
        let (mut strengths, planes) = (self.strengths(elements), out.first_planes::<REST>());
        (0..elements.len()).for_each(|e| planes[STRIDE][e] = strengths(e).1);
        Ok(())
    }

    fn rest_warning(&self, elements: &Elements<'_>) -> Option<String> {
        let (mut strengths, mut met) = (self.strengths(elements), TooWide::default());
        for (e, nodes) in elements.corners::<4>().iter().enumerate() {
            let ([a, b, c, d], (constants, begin)) = (nodes.map(|n| elements.rest()[n as usize]), strengths(e));
            let square = |p: [f64; 3], q: [f64; 3]| (0..3).map(|i| (p[i] - q[i]) * (p[i] - q[i])).sum::<f64>();
            // The greatest width of all directions is that of the longest edge.
            let edges = [square(a, b), square(a, c), square(a, d), square(b, c), square(b, d), square(c, d)];
            let widest = edges.into_iter().fold(0.0, f64::max).sqrt();
            met.meet(widest, constants.largest_width(begin));
        }
        met.warning("tetrahedra")
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
        let (constants, history) = (self.constants(elements), history.first_planes::<HISTORY>());
        self.arch.dispatch(Growth { elements, law: &self.law, constants, history });
        Ok(())
    }

    fn has_failed(&self, elements: &Elements<'_>, e: usize) -> bool {
        elements.history(0)[e] >= 1.0
    }
}

export_plugins!(AsMaterial<QuasiBrittle>);
