//! A membrane that tears: St. Venant-Kirchhoff in plane stress, with isotropic damage whose fracture energy does not depend on the mesh.
//!
//! The stress is `(1 - d) C : E` with Green's strain E and a damage d that follows from the largest principal stretch a triangle has had (Rankine).
//! Beyond the strength f the nominal stress falls linearly with the stretch. Where it comes to zero depends on the width h of the triangle, such that
//! its work is G / h for each volume (crack band, Bažant and Oh 1983): a band of triangles that tears takes the fracture energy G for each area
//! of the crack, whatever their size. There the triangle has failed (`pliant.failure/1`). Triangles that at their strength have stored more than that,
//! those wider than about `2 G Y / f^2` with Young's modulus Y, tear at once and take what they have stored.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod damage;
mod triangle;

use damage::{Strength, nominal};
use pliant_plugin_api::{
    AsMaterial, Blocks, CrackBand, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param,
    Params, Planes, TangentScale, TooWide, abi, export_plugins, pair_index,
};
use triangle::{PlaneStress, Triangle, Vec2};

/// The material of one sheet.
pub struct Tearing {
    /// Young's modulus, Pa.
    young: f64,
    /// Poisson's ratio.
    poisson: f64,
    /// Thickness of the sheet, m.
    thickness: f64,
    /// Mass per volume, kg/m^3.
    density: f64,
    /// Tensile strength, Pa.
    strength: f64,
    /// Fracture energy per area of crack, J/m^2.
    fracture_energy: f64,
    /// Damping over stiffness, s.
    damping_time: f64,
}

const PARAMS: &[Param] = &[
    Param::number(c"young", c"Pa", 1.0..=1e12, 1e6, c"Young's modulus").field(),
    Param::number(c"poisson", c"1", 0.0..=0.49, 0.3, c"Poisson's ratio"),
    Param::number(c"thickness", c"m", 1e-6..=0.1, 1e-3, c"thickness"),
    Param::number(c"density", c"kg/m^3", 1e-3..=1e5, 1e3, c"mass per volume"),
    Param::number(c"strength", c"Pa", 1.0..=1e12, 1e5, c"tensile strength: stress at which damage begins").field(),
    Param::number(
        c"fracture-energy",
        c"J/m^2",
        1e-6..=1e9,
        200.0,
        c"energy per area of a crack; triangles wider than 2 G Y / f^2 tear at once and take more",
    )
    .field(),
    Param::number(c"damping-time", c"s", 0.0..=1.0, 1e-3, c"damping over stiffness"),
];

/// Planes of rest data: the inverse of the sides in material coordinates (1/m, row-major), volume (m^3), Young's modulus (Pa), and the strains
/// (principal stretch less 1) at which damage begins and is complete.
const REST: u32 = 8;

/// Twice the area of a triangle with these material coordinates (m), m^2.
fn double_area([a, b, c]: &[Vec2; 3]) -> f64 {
    let side = |to: &Vec2| [to[0] - a[0], to[1] - a[1]];
    let (p, q) = (side(b), side(c));
    p[0] * q[1] - p[1] * q[0]
}

impl Tearing {
    /// Young's modulus (Pa), strength, and fracture energy (J/m^2) of triangle `e` of a call.
    fn constants(&self, elements: &Elements<'_>, e: usize) -> (f64, Strength, f64) {
        let factor = |key: &str| elements.field(key).factor(e);
        let young = self.young * factor("young");
        let strength = Strength::new(young, self.strength * factor("strength"));
        (young, strength, self.fracture_energy * factor("fracture-energy"))
    }

    /// Triangle `e` of a call in its present state, with its damage.
    fn triangle(&self, elements: &Elements<'_>, e: usize, nodes: [u32; 3]) -> Triangle {
        let rest = |plane: usize| elements.rest_data(plane)[e];
        let inverse = [[rest(0), rest(1)], [rest(2), rest(3)]];
        let at = |of: &[[f64; 3]]| nodes.map(|n| of[n as usize]);
        let law = PlaneStress::new(rest(5), self.poisson);
        let band = CrackBand { begin: rest(6), end: rest(7) };
        let intact = rest(4) * (1.0 - band.damage(elements.history(0)[e], nominal));
        Triangle::new(at(elements.x()), at(elements.v()), inverse, law, intact, self.damping_time)
    }
}

impl Material for Tearing {
    const INFO: Info = Info {
        id: c"tearing",
        name: c"Tearing membrane",
        version: c"0.1.0",
        summary: c"sheet that tears: damage whose fracture energy does not depend on the size of triangles",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        Ok(Self {
            young: params.number("young"),
            poisson: params.number("poisson"),
            thickness: params.number("thickness"),
            density: params.number("density"),
            strength: params.number("strength"),
            fracture_energy: params.number("fracture-energy"),
            damping_time: params.number("damping-time"),
        })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let damping = if self.damping_time > 0.0 { abi::HAS_DAMPING } else { 0 };
        let flags = abi::HAS_MASS | abi::HAS_FORCES | abi::HAS_HISTORY | abi::CAN_FAIL | damping;
        vec![ElementRequest { kind: abi::TRIANGLE, families: 0, flags, rest_stride: REST, history_stride: 1 }]
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let out = out.first_planes::<{ REST as usize }>();
        for (e, corners) in elements.material_coordinates::<3>().iter().enumerate() {
            let [a, b, c] = corners;
            let side = |to: &Vec2| [to[0] - a[0], to[1] - a[1]];
            let (p, q) = (side(b), side(c));
            let double_area = double_area(corners);
            if double_area.is_nan() || double_area <= 0.0 {
                let index = elements.first_index() + e;
                return Err(Fault::bad_argument(format!("triangle {index} has no area at rest")));
            }
            let (young, strength, energy) = self.constants(elements, e);
            let band = strength.band(energy, double_area.sqrt());
            let values = [
                q[1] / double_area,
                -q[0] / double_area,
                -p[1] / double_area,
                p[0] / double_area,
                0.5 * double_area * self.thickness,
                young,
                band.begin,
                band.end,
            ];
            values.into_iter().enumerate().for_each(|(plane, value)| out[plane][e] = value);
        }
        Ok(())
    }

    fn rest_warning(&self, elements: &Elements<'_>) -> Option<String> {
        let mut met = TooWide::default();
        for (e, corners) in elements.material_coordinates::<3>().iter().enumerate() {
            let (_, strength, energy) = self.constants(elements, e);
            met.meet(double_area(corners).sqrt(), strength.largest_width(energy));
        }
        met.warning("triangles")
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        for (e, nodes) in elements.corners::<3>().iter().enumerate() {
            let share = self.density * elements.rest_data(4)[e] / 3.0;
            nodes.iter().for_each(|node| out.add(*node, share));
        }
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        let all = elements.corners::<3>().iter().enumerate();
        let energy: f64 = all.map(|(e, nodes)| self.triangle(elements, e, *nodes).energy()).sum();
        if energy.is_finite() { Ok(energy) } else { Err(Fault::diverged("the energy is not finite")) }
    }

    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        for (e, nodes) in elements.corners::<3>().iter().enumerate() {
            let forces = self.triangle(elements, e, *nodes).forces();
            if !forces.iter().flatten().all(|f| f.is_finite()) {
                return Err(Fault::diverged("a force is not finite"));
            }
            nodes.iter().zip(forces).for_each(|(node, force)| out.add(*node, force));
        }
        Ok(())
    }

    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        for (e, nodes) in elements.corners::<3>().iter().enumerate() {
            let triangle = self.triangle(elements, e, *nodes);
            for (a, b) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
                out.add(e, pair_index(a, b, 3), &triangle.block(a, b, scale));
            }
        }
        Ok(())
    }

    fn advance(&self, elements: &Elements<'_>, history: &mut Planes<'_>) -> Result<(), Fault> {
        let [largest] = history.first_planes::<1>();
        for (e, nodes) in elements.corners::<3>().iter().enumerate() {
            let strain = self.triangle(elements, e, *nodes).principal_strain();
            // Below the strength nothing is remembered, so rounding at rest is not either.
            if strain > elements.rest_data(6)[e].max(largest[e]) {
                largest[e] = strain;
            }
        }
        Ok(())
    }

    fn has_failed(&self, elements: &Elements<'_>, e: usize) -> bool {
        elements.history(0)[e] >= elements.rest_data(7)[e]
    }
}

export_plugins!(AsMaterial<Tearing>);
