//! The material plugin behind laws written in Python; this module is its library.
//!
//! Mass, shape functions, damping and assembly are here; the law gives energy density, stress and stiffness of deformation gradients.

use super::law::{ENTRIES, Functions};
use super::law_element::{STRIDE, Stiffness, Tetrahedron, at_corners, strain_rate};
use nalgebra::{Matrix3, SVector};
use pliant_plugin_api::{
    AsMaterial, Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, Param, Params,
    Planes, TangentScale, abi, export_plugins, pair_index,
};
use std::sync::Arc;

/// A law on the tetrahedra of a body.
pub struct LawMaterial {
    functions: Arc<Functions>,
    /// kg/m^3
    density: f64,
    /// Second derivatives at rest times the damping time, Pa s; `None` without damping.
    viscosity: Option<Stiffness>,
    /// Whether the matrix is made positive semi-definite.
    project: bool,
}

const PARAMS: &[Param] = &[
    Param::text(c"law", c"number of the law in this process"),
    Param::number(c"density", c"kg/m^3", 1e-6..=1e6, 1e3, c"mass per volume"),
    Param::number(c"damping-time", c"s", 0.0..=10.0, 2e-4, c"damping over stiffness, both at rest"),
    Param::choice(c"tangent", c"projected|exact", c"matrix of implicit steps: made positive semi-definite, or exact"),
];

impl LawMaterial {
    /// Shapes of the elements of a call.
    fn shapes(elements: &Elements<'_>) -> Vec<Tetrahedron> {
        (0..elements.corners::<4>().len()).map(|e| Tetrahedron::of(elements, e)).collect()
    }

    /// Their deformation gradients.
    fn gradients(elements: &Elements<'_>, shapes: &[Tetrahedron], vectors: &[[f64; 3]]) -> Vec<Matrix3<f64>> {
        let corners = elements.corners::<4>().iter();
        corners.zip(shapes).map(|(&nodes, shape)| shape.gradient(at_corners(nodes, vectors))).collect()
    }

    /// The damping of an element by the rate of its deformation gradient, Pa s: objective, since it acts on the rate of Green's strain.
    fn damping(viscosity: &Stiffness, f: &Matrix3<f64>) -> Stiffness {
        let rate = strain_rate(f);
        rate.transpose() * viscosity * rate
    }
}

/// Matrices row by row, as laws take them.
fn flat(matrices: &[Matrix3<f64>]) -> Vec<f64> {
    matrices.iter().flat_map(|m| m.transpose().as_slice().to_vec()).collect()
}

impl Material for LawMaterial {
    const INFO: Info = Info {
        id: c"python-law",
        name: c"Energy density written in Python",
        version: c"0.1.0",
        summary: c"a hyperelastic law given by functions of Python, for trying ideas",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let functions = Functions::find(params.text("law"))?;
        let time = params.number("damping-time");
        let viscosity = if time > 0.0 {
            let at_rest = functions.stiffness(flat(&[Matrix3::identity()]), true)?;
            Some(time * Stiffness::from_row_slice(&at_rest))
        } else {
            None
        };
        Ok(Self { functions, density: params.number("density"), viscosity, project: params.choice("tangent") == 0 })
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let damping = if self.viscosity.is_some() { abi::HAS_DAMPING } else { 0 };
        let point =
            ElementRequest { kind: abi::POINT, families: 0, flags: abi::HAS_MASS, rest_stride: 0, history_stride: 0 };
        let flags = abi::HAS_FORCES | damping;
        vec![point, ElementRequest { kind: abi::TETRAHEDRON, flags, rest_stride: STRIDE as u32, ..point }]
    }

    fn rest(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let planes = out.first_planes::<STRIDE>();
        for (e, (&nodes, &share)) in elements.corners::<4>().iter().zip(elements.measure()).enumerate() {
            let Some(shape) = Tetrahedron::new(at_corners(nodes, elements.rest()), share) else {
                return Err(Fault::bad_argument("a tetrahedron has no volume at rest, or is inverted"));
            };
            shape.rest_data().into_iter().enumerate().for_each(|(s, value)| planes[s][e] = value);
        }
        Ok(())
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        for (&[node], &volume) in elements.corners::<1>().iter().zip(elements.measure()) {
            out.add(node, self.density * volume);
        }
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        let shapes = Self::shapes(elements);
        let densities = self.functions.energy(flat(&Self::gradients(elements, &shapes, elements.x())))?;
        Ok(shapes.iter().zip(densities).map(|(shape, density)| shape.volume * density).sum())
    }

    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        let shapes = Self::shapes(elements);
        let gradients = Self::gradients(elements, &shapes, elements.x());
        let stresses = self.functions.stress(flat(&gradients))?;
        for (e, &nodes) in elements.corners::<4>().iter().enumerate() {
            let mut stress = Matrix3::from_row_slice(&stresses[ENTRIES * e..ENTRIES * (e + 1)]);
            if let Some(viscosity) = &self.viscosity {
                let rate = shapes[e].gradient(at_corners(nodes, elements.v()));
                let viscous = Self::damping(viscosity, &gradients[e])
                    * SVector::<f64, ENTRIES>::from_row_slice(rate.transpose().as_slice());
                stress += Matrix3::from_row_slice(viscous.as_slice());
            }
            for (node, force) in nodes.into_iter().zip(shapes[e].forces(&stress)) {
                out.add(node, force);
            }
        }
        Ok(())
    }

    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        const SIZE: usize = ENTRIES * ENTRIES;
        let shapes = Self::shapes(elements);
        let gradients = Self::gradients(elements, &shapes, elements.x());
        let stiffness = match scale.stiffness {
            0.0 => None,
            _ => Some(self.functions.stiffness(flat(&gradients), self.project)?),
        };
        for (e, shape) in shapes.iter().enumerate() {
            let mut sum = Stiffness::zeros();
            if let Some(stiffness) = &stiffness {
                sum += scale.stiffness * Stiffness::from_row_slice(&stiffness[SIZE * e..SIZE * (e + 1)]);
            }
            if let Some(viscosity) = &self.viscosity {
                sum += scale.damping * Self::damping(viscosity, &gradients[e]);
            }
            for a in 0..4 {
                for b in a..4 {
                    out.add(e, pair_index(a, b, 4), &shape.block(a, b, &sum));
                }
            }
        }
        Ok(())
    }
}

export_plugins!(AsMaterial<LawMaterial>);
