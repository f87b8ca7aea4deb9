//! Mass-spring lattice of cubic cells: the material of Qi, Zhu and Fan (2019), with physical parameters.
//!
//! The paper gives all springs one stiffness and all particles one mass, so the modulus and the density depend on the level of the grid.
//! The default mode here keeps them: with structural springs of stiffness `k = 0.4 E h`, shear springs of `0.4 E l / sqrt(2)` (the same
//! number, as their length l is `sqrt(2) h`), and weights for the share of the cells around a spring that belong to the body, a block has
//! exactly Young's modulus E and Poisson's ratio 1/4 at every level. A lattice of central springs cannot have another ratio (Cauchy
//! relation). Springs alone fold when they are squeezed by more than about a third, so the tetrahedra of cells resist the loss of volume,
//! with a law that adds nothing to either at small strains (`volume`). The paper's mode is there for comparison and has no such law.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod gather;
mod kernel;
mod stiffness;
mod volume;

use kernel::Springs;
use pliant_plugin_api::lanes::Vec3;
use pliant_plugin_api::{
    AsMaterial, BlockScalar, Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param,
    Params, Planes, SingleBlocks, TangentScale, abi, export_plugins,
};
use volume::Tetrahedra;

/// The material of one body.
pub struct MassSpring {
    /// Stiffness and mass.
    law: Law,
    /// Damping along each spring's axis over its stiffness, s.
    damping_time: f64,
    /// Whether springs on the surface of the body have the boundary weight.
    is_weighted: bool,
    /// Modulus of the resistance of cells to the loss of volume, Pa; 0 for none.
    volume_modulus: f64,
    /// Loops over elements.
    kernel: kernel::Kernel,
}

/// Stiffness of springs and mass of particles.
enum Law {
    /// Young's modulus, Pa; density, kg/m^3; stiffness of flexion springs over that of shear springs.
    Physical { young: f64, density: f64, flexion: f64 },
    /// Stiffness of every spring, N/m; mass of every particle, kg.
    Paper { stiffness: f64, mass: f64 },
}

const PARAMS: &[Param] = &[
    Param::choice(
        c"mode",
        c"physical|paper",
        c"physical: from Young's modulus and density; paper: one stiffness, mass and damping for all",
    ),
    Param::number(c"young", c"Pa", 1e-6..=1e12, 1e4, c"Young's modulus; Poisson's ratio is 1/4").field(),
    Param::number(c"density", c"kg/m^3", 1e-6..=1e6, 1e3, c"mass per volume").field(),
    Param::number(
        c"damping-time",
        c"s",
        0.0..=10.0,
        2e-4,
        c"damping over stiffness: a mode of w rad/s has a damping ratio of w/2 times this",
    ),
    Param::number(
        c"flexion",
        c"1",
        0.0..=0.2,
        0.0,
        c"stiffness of flexion springs over that of shear springs; the modulus stays",
    ),
    Param::number(
        c"volume-resistance",
        c"1",
        0.0..=2.0,
        1.5,
        c"modulus against the loss of volume of squeezed cells, over Young's modulus; 0 lets them collapse",
    ),
    Param::number(c"spring", c"N/m", 1e-9..=1e12, 10.0, c"paper mode: stiffness K of every spring"),
    Param::number(c"particle-mass", c"kg", 1e-12..=1e6, 1e-4, c"paper mode: mass M of every particle"),
    Param::number(c"spring-damping", c"N s/m", 0.0..=1e9, 0.01, c"paper mode: damping C_d along each spring's axis"),
    Param::choice(
        c"boundary-weights",
        c"on|off",
        c"reduce springs on faces to 1/2 and on edges of the body to 1/4; off makes small blocks too stiff",
    ),
];

impl MassSpring {
    /// Families of links the law uses.
    fn families(&self) -> u32 {
        let flexion = match self.law {
            Law::Physical { flexion, .. } => flexion > 0.0,
            Law::Paper { .. } => true,
        };
        abi::STRUCTURAL | abi::SHEAR | if flexion { abi::FLEXION } else { 0 }
    }

    /// Stiffness of a link of `family` with rest length `length` (m), before its weight, N/m.
    fn stiffness(&self, family: u32, length: f64) -> f64 {
        match self.law {
            Law::Paper { stiffness, .. } => stiffness,
            Law::Physical { young, flexion, .. } => match family {
                abi::STRUCTURAL => (1.0 - 4.0 * flexion) * 0.4 * young * length,
                abi::SHEAR => 0.4 * young * length / std::f64::consts::SQRT_2,
                _ => flexion * 0.4 * young * length / 2.0,
            },
        }
    }
}

impl Material for MassSpring {
    const INFO: Info = Info {
        id: c"mass-spring",
        name: c"Mass-spring lattice",
        version: c"0.1.0",
        summary: c"structural, shear and flexion springs on a cubic lattice (Qi, Zhu and Fan 2019; Lloyd et al. 2007)",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let is_physical = params.choice("mode") == 0;
        let (law, damping_time) = if is_physical {
            let (young, density) = (params.number("young"), params.number("density"));
            (Law::Physical { young, density, flexion: params.number("flexion") }, params.number("damping-time"))
        } else {
            let (stiffness, mass) = (params.number("spring"), params.number("particle-mass"));
            (Law::Paper { stiffness, mass }, params.number("spring-damping") / stiffness)
        };
        let is_weighted = params.choice("boundary-weights") == 0;
        let volume_modulus = match law {
            Law::Physical { young, .. } => young * params.number("volume-resistance"),
            Law::Paper { .. } => 0.0,
        };
        Ok(Self { law, damping_time, is_weighted, volume_modulus, kernel: kernel::Kernel::new() })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let damping = if self.damping_time > 0.0 { abi::HAS_DAMPING } else { 0 };
        let point =
            ElementRequest { kind: abi::POINT, families: 0, flags: abi::HAS_MASS, rest_stride: 0, history_stride: 0 };
        let (flags, families) = (abi::HAS_FORCES | abi::HAS_SINGLE | damping, self.families());
        let link = ElementRequest { kind: abi::LINK, families, flags, rest_stride: 2, history_stride: 0 };
        let mut requests = vec![point, link];
        if self.volume_modulus > 0.0 {
            let flags = abi::HAS_FORCES | abi::HAS_SINGLE | abi::INNER_TETRAHEDRON;
            let rest_stride = volume::STRIDE as u32;
            requests.push(ElementRequest { kind: abi::TETRAHEDRON, flags, rest_stride, ..point });
        }
        requests
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        if elements.kind() == abi::TETRAHEDRON {
            return self.rest_volumes(elements, out);
        }
        let (ends, family, weight, rest) =
            (elements.corners::<2>(), elements.family(), elements.measure(), elements.rest());
        let ([length, stiffness], young) = (out.first_planes(), self.young_field(elements));
        for e in 0..elements.len() {
            let [a, b] = ends[e].map(|node| rest[node as usize]);
            length[e] = (Vec3(b) - Vec3(a)).norm();
            if !(length[e].is_finite() && length[e] > 0.0) {
                return Err(Fault::bad_argument("a spring has no rest length"));
            }
            stiffness[e] =
                self.stiffness(family[e], length[e]) * young(e) * if self.is_weighted { weight[e] } else { 1.0 };
        }
        Ok(())
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        let field = elements.field("density");
        for (e, (&[node], &volume)) in elements.corners::<1>().iter().zip(elements.measure()).enumerate() {
            out.add(
                node,
                match self.law {
                    Law::Physical { density, .. } => density * field.factor(e) * volume,
                    Law::Paper { mass, .. } => mass,
                },
            );
        }
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        Ok(match elements.kind() {
            abi::TETRAHEDRON => Tetrahedra::new(elements).energy(),
            _ => self.kernel.energy(self.springs(elements)),
        })
    }

    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        match elements.kind() {
            abi::TETRAHEDRON => self.kernel.volume_forces(Tetrahedra::new(elements), out),
            _ => self.kernel.forces(self.springs(elements), out),
        }
        Ok(())
    }

    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        self.add_stiffness(elements, scale, out);
        Ok(())
    }

    fn single_tangent(
        &self,
        elements: &Elements<'_>,
        scale: TangentScale,
        out: &mut SingleBlocks<'_>,
    ) -> Result<(), Fault> {
        self.add_stiffness(elements, scale, out);
        Ok(())
    }
}

impl MassSpring {
    /// Factor of Young's modulus by element; the paper mode has no modulus.
    fn young_field<'a>(&self, elements: &Elements<'a>) -> impl Fn(usize) -> f64 + 'a {
        let (field, is_physical) = (elements.field("young"), matches!(self.law, Law::Physical { .. }));
        move |e| if is_physical { field.factor(e) } else { 1.0 }
    }

    /// Rest data of tetrahedra.
    fn rest_volumes(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let (corners, share, rest) = (elements.corners::<4>(), elements.measure(), elements.rest());
        let ([six_volumes, scale], young) = (out.first_planes(), self.young_field(elements));
        for e in 0..elements.len() {
            let x = corners[e].map(|node| Vec3(rest[node as usize]));
            let Some(data) = volume::rest_data(x, share[e], young(e) * self.volume_modulus) else {
                return Err(Fault::bad_argument("a tetrahedron has no volume at rest, or is inverted"));
            };
            [six_volumes[e], scale[e]] = data;
        }
        Ok(())
    }

    /// Adds `scale.stiffness` K + `scale.damping` C.
    fn add_stiffness<T: BlockScalar>(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_, T>) {
        match elements.kind() {
            abi::TETRAHEDRON => self.kernel.volume_stiffness(Tetrahedra::new(elements), scale.stiffness, out),
            _ => self.kernel.stiffness(self.springs(elements), scale, out),
        }
    }

    /// The springs of a call.
    fn springs<'a>(&self, elements: &'a Elements<'_>) -> Springs<'a> {
        Springs::new(elements, self.damping_time)
    }
}

export_plugins!(AsMaterial<MassSpring>);
