//! Cloth: a sheet of orthotropic triangles with bending stiffness at its edges.
//!
//! In its plane each triangle has stiffness along warp, along weft and in shear, in a corotated frame; the forces are the exact gradient
//! of the energy in every frame. The default bending model is the mixed method of Hellan, Herrmann and Johnson: its hinges are
//! coupled by the host, and it converges on any mesh. Viscosity acts on the rate of strain, so it does not resist rotation.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod atan2;
mod bending;
mod dihedral;
mod elasticity;
mod fabric;
mod fabric_file;
mod frame;
mod friction;
mod kernel;
pub mod kes;
mod laplacian;
mod membrane;
mod settings;
mod tangent;
mod triangle;
mod vector;
mod wrinkling;

use bending::Hinge;
use friction::FrictionElement;
use pliant_plugin_api::lanes::vector_unit;
use pliant_plugin_api::{
    AsMaterial, Blocks, ElementRequest, Elements, Fault, Field, Info, Material, NodeScalars, NodeVectors, NormalForces,
    Params, Planes, SingleBlocks, Source, TangentScale, abi, export_plugins, pair_index,
};
use settings::{Bending, PARAMS, Settings};
use triangle::Triangle;
use vector::Vec3;

/// The cloth of one body: its moduli and the choices of strain measure and bending model.
pub struct Cloth {
    /// The parameters, checked.
    settings: Settings,
    /// The vector unit on which kernels run.
    arch: pulp::Arch,
}

impl Material for Cloth {
    const INFO: Info = Info {
        id: c"cloth",
        name: c"Cloth",
        version: c"0.1.0",
        summary: c"orthotropic sheets: corotated triangles, and bending that converges on any mesh",
        params: PARAMS,
    };
    const SOURCES: &'static [Source] = fabric::SOURCES;

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        Ok(Self { settings: Settings::new(params)?, arch: vector_unit() })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let damping = if self.settings.membrane.damping_time > 0.0 { abi::HAS_DAMPING } else { 0 };
        let coupled = if self.settings.bending == Bending::Coupled { abi::IS_COUPLED } else { 0 };
        let triangle = ElementRequest {
            kind: abi::TRIANGLE,
            families: 0,
            flags: abi::HAS_MASS | abi::HAS_FORCES | abi::HAS_SINGLE | damping | coupled,
            rest_stride: triangle::STRIDE as u32,
            history_stride: 0,
        };
        let hinge = ElementRequest { kind: abi::HINGE, rest_stride: bending::STRIDE as u32, ..triangle };
        let hinge = match self.settings.bending {
            Bending::None => return vec![triangle],
            Bending::Laplacian => {
                let flags = triangle.flags & !abi::HAS_SINGLE | abi::WANTS_NORMALS;
                let triangle = ElementRequest { flags, rest_stride: laplacian::STRIDE as u32, ..triangle };
                return vec![triangle, ElementRequest { flags: abi::WANTS_NORMALS, rest_stride: 1, ..hinge }];
            }
            Bending::Coupled => ElementRequest { flags: abi::IS_COUPLED, ..hinge },
            Bending::Hinge => ElementRequest { flags: abi::HAS_FORCES | damping, ..hinge },
        };
        if self.settings.friction.is_none() {
            return vec![triangle, hinge];
        }
        let hinge = ElementRequest {
            flags: hinge.flags | abi::HAS_FORCES | abi::HAS_HISTORY,
            rest_stride: bending::STRIDE_WITH_FRICTION as u32,
            history_stride: 1,
            ..hinge
        };
        vec![triangle, hinge]
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        match elements.kind() {
            abi::TRIANGLE => self.triangle_rest(elements, out),
            _ if self.settings.bending == Bending::Laplacian => {
                let [angles] = out.first_planes::<1>();
                laplacian::write_flat_angles(elements, angles)
            }
            _ => self.hinge_rest(elements, out),
        }
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        let thickness = elements.field("thickness");
        for (e, nodes) in elements.corners::<3>().iter().enumerate() {
            let share = self.settings.density * thickness.factor(e) * Triangle::of_element(elements, e)?.area / 3.0;
            nodes.iter().for_each(|&n| out.add(n, share));
        }
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        let x = elements.x();
        if elements.kind() == abi::HINGE {
            let hinges = self.hinges(elements);
            let energies = elements.corners::<4>().iter().enumerate().map(|(e, &nodes)| {
                let angle = dihedral::angle(at_corners(nodes, x)) - hinges.rest_angles[e];
                let elastic = 0.5 * hinges.stiffness(e) * angle * angle;
                elastic + hinges.friction(e).map_or(0.0, |f| f.element.energy(angle - f.slider))
            });
            return finite(energies.sum());
        }
        let planes = std::array::from_fn(|s| elements.rest_data(s));
        let energies = elements.corners::<3>().iter().enumerate().map(|(e, &nodes)| {
            let shape = Triangle::from_rest_data(&planes, e);
            let f = shape.deformation_gradient(at_corners(nodes, x));
            shape.area * self.settings.membrane.energy(&shape, f)
        });
        finite(energies.sum())
    }

    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        if elements.kind() == abi::HINGE {
            return self.hinge_forces(elements, out);
        }
        let kernel = kernel::Forces { membrane: &self.settings.membrane, elements, out };
        finite(self.arch.dispatch(kernel)).map(drop)
    }

    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        if elements.kind() == abi::HINGE {
            self.hinge_tangent(elements, scale, out);
            return Ok(());
        }
        self.arch.dispatch(kernel::Stiffness { membrane: &self.settings.membrane, elements, scale, out });
        Ok(())
    }

    fn single_tangent(
        &self,
        elements: &Elements<'_>,
        scale: TangentScale,
        out: &mut SingleBlocks<'_>,
    ) -> Result<(), Fault> {
        self.arch.dispatch(kernel::SingleStiffness { membrane: &self.settings.membrane, elements, scale, out });
        Ok(())
    }

    fn advance(&self, elements: &Elements<'_>, history: &mut Planes<'_>) -> Result<(), Fault> {
        let (x, hinges) = (elements.x(), self.hinges(elements));
        let [sliders] = history.first_planes::<1>();
        for (e, &nodes) in elements.corners::<4>().iter().enumerate() {
            let Some(FrictionState { element, slider }) = hinges.friction(e) else { continue };
            let angle = dihedral::angle(at_corners(nodes, x)) - hinges.rest_angles[e];
            sliders[e] = angle - element.angle_after_sliding(angle - slider);
        }
        Ok(())
    }

    fn strain(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        finite(self.arch.dispatch(kernel::Strains { elements, out: out.first_planes::<13>() })).map(drop)
    }

    fn compliance(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let (planes, factors) = (out.first_planes::<6>(), StiffnessFactors::of(elements));
        for (e, u) in elements.material_coordinates::<3>().iter().enumerate() {
            let Some(values) = self.settings.rigidity.compliance(*u) else {
                Triangle::of_element(elements, e)?;
                let number = elements.first_index() + e;
                return Err(Fault::bad_argument(format!("triangle {number} is too thin to bend: {u:?}")));
            };
            (0..6).for_each(|s| planes[s][e] = values[s] / factors.bending(e));
        }
        Ok(())
    }

    fn normals_energy(&self, elements: &Elements<'_>, normals: &[[f64; 3]]) -> Result<f64, Fault> {
        finite(laplacian::BendingTriangles::new(elements, normals).energy())
    }

    fn normals_forces(
        &self,
        elements: &Elements<'_>,
        normals: &[[f64; 3]],
        out: &mut NormalForces<'_>,
    ) -> Result<(), Fault> {
        finite(laplacian::BendingTriangles::new(elements, normals).add_forces(out)).map(drop)
    }

    fn tilt(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let (planes, factors) = (out.first_planes::<3>(), StiffnessFactors::of(elements));
        for (e, &u) in elements.material_coordinates::<3>().iter().enumerate() {
            let shape = Triangle::of_element(elements, e)?;
            let tilts = laplacian::tilt(&shape, u, laplacian::stiffness(&shape, u, &self.settings.rigidity));
            (0..3).for_each(|s| planes[s][e] = factors.bending(e) * tilts[s]);
        }
        Ok(())
    }
}

impl Cloth {
    /// Writes the rest data of triangles.
    fn triangle_rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let (planes, factors) = (out.first_planes::<{ triangle::STRIDE }>(), StiffnessFactors::of(elements));
        for e in 0..elements.len() {
            // Membrane energy, stress and viscosity are proportional to stiffness times area, so the stored area includes the factor of the
            // stiffness.
            let shape = Triangle::of_element(elements, e)?;
            let values = Triangle { area: shape.area * factors.membrane(e), ..shape }.rest_data();
            (0..triangle::STRIDE).for_each(|s| planes[s][e] = values[s]);
        }
        if self.settings.bending == Bending::Laplacian {
            let [.., warp, weft] = out.first_planes::<{ laplacian::STRIDE }>();
            for (e, &u) in elements.material_coordinates::<3>().iter().enumerate() {
                let shape = Triangle::of_element(elements, e)?;
                let factor = factors.bending(e) / factors.membrane(e); // the stored area includes the factor of the membrane
                [warp[e], weft[e]] = laplacian::stiffness(&shape, u, &self.settings.rigidity).map(|b| factor * b);
            }
        }
        Ok(())
    }

    /// Writes the rest data of hinges.
    fn hinge_rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let factors = StiffnessFactors::of(elements);
        let hinge = |nodes| Hinge::new(at_corners(nodes, elements.rest()), &self.settings.rigidity, self.settings.warp);
        for (e, &nodes) in elements.corners::<4>().iter().enumerate() {
            let Some(hinge) = hinge(nodes) else {
                let number = elements.first_index() + e;
                return Err(Fault::bad_argument(format!("hinge {number} has a side without area: nodes {nodes:?}")));
            };
            let [angles, sizes] = out.first_planes::<{ bending::STRIDE }>();
            angles[e] = hinge.angle;
            sizes[e] = if self.settings.bending == Bending::Coupled {
                hinge.length
            } else {
                factors.bending(e) * hinge.stiffness
            };
            if let Some(friction) = self.settings.friction {
                let [_, _, stiffness, limit] = out.first_planes::<{ bending::STRIDE_WITH_FRICTION }>();
                let element = friction.element(hinge.length, hinge.area);
                (stiffness[e], limit[e]) = (element.stiffness, element.limit);
            }
        }
        Ok(())
    }

    /// Rest data and history of the hinges of a call.
    fn hinges<'a>(&self, elements: &Elements<'a>) -> Hinges<'a> {
        Hinges {
            rest_angles: elements.rest_data(0),
            stiffness: (self.settings.bending == Bending::Hinge).then(|| elements.rest_data(1)),
            friction: self.settings.friction.map(|_| FrictionPlanes {
                stiffness: elements.rest_data(2),
                limit: elements.rest_data(3),
                slider: elements.history(0),
            }),
        }
    }

    /// Adds the forces of hinges that bend by themselves, and of yarn friction.
    fn hinge_forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        let (x, v, hinges) = (elements.x(), elements.v(), self.hinges(elements));
        let damping_time = self.settings.membrane.damping_time;
        let mut sum = 0.0;
        for (e, &nodes) in elements.corners::<4>().iter().enumerate() {
            let corners = at_corners(nodes, x);
            let (gradient, velocities) = (dihedral::gradient(corners), at_corners(nodes, v));
            let rate: f64 = (0..4).map(|a| gradient[a].dot(velocities[a])).sum();
            let angle = dihedral::angle(corners) - hinges.rest_angles[e];
            let friction = hinges.friction(e).map_or(0.0, |f| f.element.torque(angle - f.slider));
            let torque = hinges.stiffness(e) * (angle + damping_time * rate) + friction;
            (0..4).for_each(|a| out.add(nodes[a], (gradient[a] * -torque).0));
            sum += angle + rate;
        }
        finite(sum).map(drop)
    }

    /// Adds the stiffness of hinges that bend by themselves, and of yarn friction. It is that at fixed gradients of the angle, which is
    /// positive semi-definite.
    fn hinge_tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) {
        let (x, hinges) = (elements.x(), self.hinges(elements));
        let factor = scale.stiffness + scale.damping * self.settings.membrane.damping_time;
        for (e, &nodes) in elements.corners::<4>().iter().enumerate() {
            let corners = at_corners(nodes, x);
            let angle = dihedral::angle(corners) - hinges.rest_angles[e];
            let friction = hinges.friction(e).map_or(0.0, |f| f.element.tangent(angle - f.slider));
            let gradient = dihedral::gradient(corners);
            let stiffness = factor * hinges.stiffness(e) + scale.stiffness * friction;
            for (a, b) in (0..4).flat_map(|a| (a..4).map(move |b| (a, b))) {
                let block = gradient[a].0.map(|p| gradient[b].0.map(|q| stiffness * p * q));
                out.add(e, pair_index(a, b, 4), &block);
            }
        }
    }
}

/// Factors of the stiffness of elements, from the fields of `young` and `thickness`.
struct StiffnessFactors<'a> {
    /// Factor of Young's modulus by element.
    young: Field<'a>,
    /// Factor of the thickness by element.
    thickness: Field<'a>,
}

impl<'a> StiffnessFactors<'a> {
    /// The factors of the elements of a call.
    fn of(elements: &Elements<'a>) -> Self {
        Self { young: elements.field("young"), thickness: elements.field("thickness") }
    }

    /// Factor of the membrane stiffness of element `e`, proportional to the thickness.
    fn membrane(&self, e: usize) -> f64 {
        self.young.factor(e) * self.thickness.factor(e)
    }

    /// Factor of the bending stiffness of element `e`, proportional to the cube of the thickness.
    fn bending(&self, e: usize) -> f64 {
        self.young.factor(e) * self.thickness.factor(e).powi(3)
    }
}

/// Rest data and history of the hinges of a call.
struct Hinges<'a> {
    /// Dihedral angles at rest, rad.
    rest_angles: &'a [f64],
    /// Stiffness against a change of the angle, N m; `None` where hinges are coupled.
    stiffness: Option<&'a [f64]>,
    /// Friction elements, if the fabric has yarn friction.
    friction: Option<FrictionPlanes<'a>>,
}

/// Planes of the friction elements of hinges.
#[derive(Clone, Copy)]
struct FrictionPlanes<'a> {
    /// Stiffness of the spring, N m.
    stiffness: &'a [f64],
    /// Torque at which the slider moves, N m.
    limit: &'a [f64],
    /// Angle by which the slider has moved, rad.
    slider: &'a [f64],
}

/// The friction element of one hinge, and the angle by which its slider has moved, rad.
struct FrictionState {
    element: FrictionElement,
    slider: f64,
}

impl Hinges<'_> {
    /// Stiffness of a hinge against folding, N m; zero where hinges are coupled.
    fn stiffness(&self, e: usize) -> f64 {
        self.stiffness.map_or(0.0, |all| all[e])
    }

    /// The friction element of a hinge, if the fabric has yarn friction.
    fn friction(&self, e: usize) -> Option<FrictionState> {
        self.friction.map(|planes| FrictionState {
            element: FrictionElement { stiffness: planes.stiffness[e], limit: planes.limit[e] },
            slider: planes.slider[e],
        })
    }
}

/// Vectors at the corners of an element.
fn at_corners<const K: usize>(nodes: [u32; K], vectors: &[[f64; 3]]) -> [Vec3; K] {
    nodes.map(|n| Vec3(vectors[n as usize]))
}

/// `value`, or a fault if it is not finite.
fn finite(value: f64) -> Result<f64, Fault> {
    if value.is_finite() { Ok(value) } else { Err(Fault::diverged("the state of the sheet is not finite")) }
}

export_plugins!(AsMaterial<Cloth>);
