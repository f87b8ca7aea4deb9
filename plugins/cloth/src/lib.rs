//! Cloth as a sheet of triangles that stretch and edges that bend.
//!
//! In the plane each triangle is orthotropic, with warp, weft and shear of its own, in a frame that turns with it; forces are
//! the exact slope of the energy in every frame. Bending is the mixed method of Hellan, Herrmann and Johnson by default: its
//! hinges are coupled by the host, and it is right on any mesh. Viscosity acts on the rate of strain, so rotation is not braked.

mod arc;
mod bending;
mod dihedral;
mod fabric;
mod file;
mod frame;
mod kernel;
pub mod kes;
mod laplacian;
mod membrane;
mod settings;
mod single;
mod slip;
mod small;
mod tension;
mod tensor;
mod triangle;
mod turn;

use bending::Hinge;
use pliant_plugin_api::{
    AsMaterial, Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, NormalForces,
    Params, Planes, SingleBlocks, Source, TangentScale, abi, export_plugins, pair_index,
};
use settings::{Bending, PARAMS, Settings};
use slip::Catch;
use small::{V3, dot, scaled};
use triangle::Triangle;

/// The material.
pub struct Cloth(Settings, pulp::Arch);

impl Material for Cloth {
    const INFO: Info = Info {
        id: c"cloth",
        name: c"Cloth",
        version: c"0.1.0",
        summary: c"orthotropic sheets: corotated triangles, and bending that any mesh converges with",
        params: PARAMS,
    };
    const SOURCES: &'static [Source] = fabric::SOURCES;

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        Ok(Self(Settings::new(params)?, pulp::Arch::new()))
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let damping = if self.0.membrane.damping > 0.0 { abi::HAS_DAMPING } else { 0 };
        let coupled = if self.0.bending == Bending::Coupled { abi::IS_COUPLED } else { 0 };
        let sheet = ElementRequest {
            kind: abi::TRIANGLE,
            families: 0,
            flags: abi::HAS_MASS | abi::HAS_FORCES | abi::HAS_SINGLE | damping | coupled,
            rest_stride: triangle::STRIDE as u32,
            history_stride: 0,
        };
        if self.0.bending == Bending::Laplacian {
            let flags = sheet.flags & !abi::HAS_SINGLE | abi::WANTS_NORMALS;
            let sheet = ElementRequest { flags, rest_stride: laplacian::STRIDE as u32, ..sheet };
            return vec![
                sheet,
                ElementRequest { kind: abi::HINGE, flags: abi::WANTS_NORMALS, rest_stride: 1, ..sheet },
            ];
        }
        let flags = if coupled != 0 { coupled } else { abi::HAS_FORCES | damping };
        let hinge = ElementRequest { kind: abi::HINGE, flags, rest_stride: bending::STRIDE as u32, ..sheet };
        let hinge = match self.0.slip {
            None => hinge,
            Some(_) => ElementRequest {
                flags: flags | abi::HAS_FORCES | abi::HAS_HISTORY,
                rest_stride: bending::STRIDE_WITH_SLIP as u32,
                history_stride: 1,
                ..hinge
            },
        };
        if self.0.bending == Bending::None { vec![sheet] } else { vec![sheet, hinge] }
    }

    fn rest(&self, at: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        if at.kind() == abi::TRIANGLE {
            let values = out.first_planes::<{ triangle::STRIDE }>();
            for e in 0..at.len() {
                Triangle::of(at, e)?.values().into_iter().enumerate().for_each(|(s, value)| values[s][e] = value);
            }
            if self.0.bending == Bending::Laplacian {
                let [.., warp, weft] = out.first_planes::<{ laplacian::STRIDE }>();
                for (e, &u) in at.material_coordinates::<3>().iter().enumerate() {
                    [warp[e], weft[e]] = laplacian::stiffness(&Triangle::of(at, e)?, u, &self.0.rigidity);
                }
            }
            return Ok(());
        }
        if self.0.bending == Bending::Laplacian {
            return laplacian::flat(at, out.first_planes::<1>());
        }
        if let Some(slip) = self.0.slip {
            let [_, _, stiffness, limit] = out.first_planes::<{ bending::STRIDE_WITH_SLIP }>();
            for (e, &nodes) in at.corners::<4>().iter().enumerate() {
                let hinge = Hinge::new(corners(nodes, at.rest()), &self.0.rigidity, self.0.warp);
                let catch =
                    hinge.map_or(Catch { stiffness: 1.0, limit: 0.0 }, |hinge| slip.on(hinge.length, hinge.area));
                (stiffness[e], limit[e]) = (catch.stiffness, catch.limit);
            }
        }
        let [angles, sizes] = out.first_planes::<{ bending::STRIDE }>();
        for (e, &nodes) in at.corners::<4>().iter().enumerate() {
            let Some(hinge) = Hinge::new(corners(nodes, at.rest()), &self.0.rigidity, self.0.warp) else {
                let number = at.first_index() + e;
                return Err(Fault::bad_argument(format!("hinge {number} has a side without area: nodes {nodes:?}")));
            };
            angles[e] = hinge.angle;
            sizes[e] = if self.0.bending == Bending::Coupled { hinge.length } else { hinge.stiffness };
        }
        Ok(())
    }

    fn mass(&self, at: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        for (e, nodes) in at.corners::<3>().iter().enumerate() {
            let share = self.0.density * Triangle::of(at, e)?.area / 3.0;
            nodes.iter().for_each(|&n| out.add(n, share));
        }
        Ok(())
    }

    fn energy(&self, at: &Elements<'_>) -> Result<f64, Fault> {
        let x = at.x();
        if at.kind() == abi::HINGE {
            let hinges = self.hinges(at);
            let energies = at.corners::<4>().iter().enumerate().map(|(e, &nodes)| {
                let folded = dihedral::angle(corners(nodes, x)) - hinges.angles[e];
                let sprung = 0.5 * hinges.stiffness(e) * folded * folded;
                sprung + hinges.catch(e).map_or(0.0, |(catch, slipped)| catch.energy(folded - slipped))
            });
            return finite(energies.sum());
        }
        let planes = std::array::from_fn(|s| at.rest_data(s));
        let energies = at.corners::<3>().iter().enumerate().map(|(e, &nodes)| {
            let shape = Triangle::read(&planes, e);
            shape.area * self.0.membrane.energy(&shape, shape.derivative(corners(nodes, x)))
        });
        finite(energies.sum())
    }

    fn forces(&self, at: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        if at.kind() == abi::HINGE {
            return self.hinge_forces(at, out);
        }
        finite(self.1.dispatch(kernel::Forces { membrane: &self.0.membrane, at, out })).map(drop)
    }

    fn tangent(&self, at: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        if at.kind() == abi::HINGE {
            let (x, hinges) = (at.x(), self.hinges(at));
            let factor = scale.stiffness + scale.damping * self.0.membrane.damping;
            for (e, &nodes) in at.corners::<4>().iter().enumerate() {
                let place = corners(nodes, x);
                let folded = dihedral::angle(place) - hinges.angles[e];
                let held = hinges.catch(e).map_or(0.0, |(catch, slipped)| catch.slope(folded - slipped));
                let (g, size) = (dihedral::gradient(place), factor * hinges.stiffness(e) + scale.stiffness * held);
                for (a, b) in (0..4).flat_map(|a| (a..4).map(move |b| (a, b))) {
                    out.add(e, pair_index(a, b, 4), &g[a].map(|p| g[b].map(|q| size * p * q)));
                }
            }
            return Ok(());
        }
        let factors = (scale.stiffness, scale.damping);
        self.1.dispatch(kernel::Stiffness { membrane: &self.0.membrane, at, factors, out });
        Ok(())
    }

    fn single_tangent(&self, at: &Elements<'_>, scale: TangentScale, out: &mut SingleBlocks<'_>) -> Result<(), Fault> {
        let factors = (scale.stiffness, scale.damping);
        self.1.dispatch(kernel::SingleStiffness { membrane: &self.0.membrane, at, factors, out });
        Ok(())
    }

    fn advance(&self, at: &Elements<'_>, history: &mut Planes<'_>) -> Result<(), Fault> {
        let (x, hinges) = (at.x(), self.hinges(at));
        let [slipped] = history.first_planes::<1>();
        for (e, &nodes) in at.corners::<4>().iter().enumerate() {
            let Some((catch, before)) = hinges.catch(e) else { continue };
            let folded = dihedral::angle(corners(nodes, x)) - hinges.angles[e];
            slipped[e] = folded - catch.caught(folded - before);
        }
        Ok(())
    }

    fn strain(&self, at: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        finite(self.1.dispatch(kernel::Strains { at, out: out.first_planes::<13>() })).map(drop)
    }

    fn compliance(&self, at: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let out = out.first_planes::<6>();
        for (e, u) in at.material_coordinates::<3>().iter().enumerate() {
            let Some(values) = self.0.rigidity.compliance(*u) else {
                Triangle::of(at, e)?;
                return Err(Fault::bad_argument(format!(
                    "triangle {} is too thin to bend: {u:?}",
                    at.first_index() + e
                )));
            };
            (0..6).for_each(|s| out[s][e] = values[s]);
        }
        Ok(())
    }

    fn normals_energy(&self, at: &Elements<'_>, normals: &[V3]) -> Result<f64, Fault> {
        finite(laplacian::Sheet::new(at, normals).energy())
    }

    fn normals_forces(&self, at: &Elements<'_>, normals: &[V3], out: &mut NormalForces<'_>) -> Result<(), Fault> {
        finite(laplacian::Sheet::new(at, normals).forces(out)).map(drop)
    }

    fn tilt(&self, at: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let out = out.first_planes::<3>();
        for (e, &u) in at.material_coordinates::<3>().iter().enumerate() {
            let shape = Triangle::of(at, e)?;
            let tilts = laplacian::tilt(&shape, u, laplacian::stiffness(&shape, u, &self.0.rigidity));
            (0..3).for_each(|s| out[s][e] = tilts[s]);
        }
        Ok(())
    }
}

impl Cloth {
    /// What is known of the hinges of a call.
    fn hinges<'a>(&self, at: &Elements<'a>) -> Hinges<'a> {
        let slip = self.0.slip.map(|_| [at.rest_data(2), at.rest_data(3), at.history(0)]);
        Hinges { angles: at.rest_data(0), stiffness: (self.0.bending == Bending::Hinge).then(|| at.rest_data(1)), slip }
    }

    fn hinge_forces(&self, at: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        let (x, v, hinges) = (at.x(), at.v(), self.hinges(at));
        let mut seen = 0.0;
        for (e, &nodes) in at.corners::<4>().iter().enumerate() {
            let place = corners(nodes, x);
            let (gradient, speeds) = (dihedral::gradient(place), corners(nodes, v));
            let speed: f64 = (0..4).map(|a| dot(gradient[a], speeds[a])).sum();
            let folded = dihedral::angle(place) - hinges.angles[e];
            let caught = hinges.catch(e).map_or(0.0, |(catch, slipped)| catch.torque(folded - slipped));
            let torque = hinges.stiffness(e) * (folded + self.0.membrane.damping * speed) + caught;
            (0..4).for_each(|a| out.add(nodes[a], scaled(gradient[a], -torque)));
            seen += folded + speed;
        }
        finite(seen).map(drop)
    }
}

/// Of a call's hinges: rest angles, stiffness where each is alone, and what friction has to go by.
struct Hinges<'a> {
    angles: &'a [f64],
    stiffness: Option<&'a [f64]>,
    slip: Option<[&'a [f64]; 3]>,
}

impl Hinges<'_> {
    /// N m
    fn stiffness(&self, e: usize) -> f64 {
        self.stiffness.map_or(0.0, |all| all[e])
    }

    /// The catch of a hinge, and rad, by how much it has given way.
    fn catch(&self, e: usize) -> Option<(Catch, f64)> {
        self.slip.map(|[stiffness, limit, slipped]| (Catch { stiffness: stiffness[e], limit: limit[e] }, slipped[e]))
    }
}

/// Values of the corners of an element.
fn corners<const K: usize>(nodes: [u32; K], of: &[V3]) -> [V3; K] {
    nodes.map(|n| of[n as usize])
}

/// A value, if it is a number.
fn finite(value: f64) -> Result<f64, Fault> {
    if value.is_finite() { Ok(value) } else { Err(Fault::diverged("the state of the sheet is not finite")) }
}

export_plugins!(AsMaterial<Cloth>);
