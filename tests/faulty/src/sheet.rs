//! A sheet of springs along the sides of its triangles, with coupled hinges (springs between the opposite vertices of an edge) and an
//! energy of normals.

use crate::material::{Spring, span};
use crate::{AFTER, fault, info, normals};
use pliant_plugin_api::{
    Blocks, ElementRequest, Elements, Fault, Info, Material, NodeScalars, NodeVectors, NormalForces, Param, Params,
    Planes, TangentScale, abi, pair_index,
};

/// Stiffness of every side of every triangle, N/m.
const STIFFNESS: f64 = 20.0;
/// Corners at the ends of each side.
const SIDES: [[usize; 2]; 3] = [[0, 1], [1, 2], [0, 2]];

/// A sheet with the fault `F` (see [`fault`]).
pub struct SpringSheet<const F: u8>;

/// The springs along the sides of the triangle `nodes`.
fn springs(elements: &Elements<'_>, nodes: [u32; 3]) -> [Spring; 3] {
    SIDES.map(|side| {
        let ends = side.map(|corner| nodes[corner] as usize);
        let ((along, length), (_, l0)) = (span(ends.map(|n| elements.x()[n])), span(ends.map(|n| elements.rest()[n])));
        Spring { along, across: (1.0 - l0 / length).max(0.0), stretch: length - l0, stiffness: STIFFNESS }
    })
}

/// Distance between the opposite vertices of a hinge with these corners (m), laid flat, m.
fn flat_distance([a, b, o, p]: [[f64; 3]; 4]) -> f64 {
    let (edge, _) = span([a, b]);
    // Coordinates of a vertex along the edge and across it.
    let laid = |vertex| {
        let (direction, length) = span([a, vertex]);
        let along: f64 = (0..3).map(|i| length * direction[i] * edge[i]).sum();
        [along, (length * length - along * along).sqrt()]
    };
    let ([o, above], [p, below]) = (laid(o), laid(p));
    (o - p).hypot(above + below)
}

impl<const F: u8> Material for SpringSheet<F> {
    const INFO: Info = info(
        match F {
            fault::HINGE_GRADIENT_OFF => c"hinge-gradient-off",
            fault::HINGE_NOT_OBJECTIVE => c"hinge-not-objective",
            fault::HINGE_FLAT_AT_REST => c"hinge-flat-at-rest",
            fault::COMPLIANCE_INDEFINITE => c"compliance-indefinite",
            fault::NORMALS_FORCE_OFF => c"normals-force-off",
            fault::NORMALS_DERIVATIVE_OFF => c"normals-derivative-off",
            fault::NORMALS_NOT_OBJECTIVE => c"normals-not-objective",
            fault::NORMALS_PULL_AT_REST => c"normals-pull-at-rest",
            fault::TILT_TOO_SOFT => c"tilt-too-soft",
            _ => c"sound-net",
        },
        const { &[AFTER] as &[Param] },
    );

    fn new(_: &Params<'_>) -> Result<Self, Fault> {
        Ok(Self)
    }

    fn elements(&self) -> Vec<ElementRequest> {
        let both = abi::IS_COUPLED | abi::WANTS_NORMALS;
        let flags = abi::HAS_MASS | abi::HAS_FORCES | both;
        let triangle = ElementRequest { kind: abi::TRIANGLE, families: 0, flags, rest_stride: 0, history_stride: 0 };
        vec![triangle, ElementRequest { kind: abi::HINGE, flags: both, ..triangle }]
    }

    fn rest(&self, _: &Elements<'_>, _: &mut Planes<'_>) -> Result<(), Fault> {
        Ok(())
    }

    fn mass(&self, elements: &Elements<'_>, out: &mut NodeScalars<'_>) -> Result<(), Fault> {
        elements.corners::<3>().iter().flatten().for_each(|node| out.add(*node, 1e-3));
        Ok(())
    }

    fn energy(&self, elements: &Elements<'_>) -> Result<f64, Fault> {
        Ok(elements
            .corners::<3>()
            .iter()
            .flat_map(|nodes| springs(elements, *nodes))
            .map(|spring| spring.energy())
            .sum())
    }

    fn forces(&self, elements: &Elements<'_>, out: &mut NodeVectors<'_>) -> Result<(), Fault> {
        for nodes in elements.corners::<3>() {
            for (spring, [a, b]) in springs(elements, *nodes).iter().zip(SIDES) {
                let pull = spring.stiffness * spring.stretch;
                out.add(nodes[a], spring.along.map(|d| pull * d));
                out.add(nodes[b], spring.along.map(|d| -pull * d));
            }
        }
        Ok(())
    }

    fn tangent(&self, elements: &Elements<'_>, scale: TangentScale, out: &mut Blocks<'_>) -> Result<(), Fault> {
        for (e, nodes) in elements.corners::<3>().iter().enumerate() {
            for (spring, [a, b]) in springs(elements, *nodes).iter().zip(SIDES) {
                let block = spring.block(scale.stiffness, 0.0);
                out.add(e, pair_index(a, a, 3), &block);
                out.add(e, pair_index(b, b, 3), &block);
                out.add(e, pair_index(a, b, 3), &block.map(|row| row.map(|k| -k)));
            }
        }
        Ok(())
    }

    fn strain(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let out = out.first_planes::<13>();
        for (e, &[a, b, o, p]) in elements.corners::<4>().iter().enumerate() {
            let ends = [o, p].map(|node| node as usize);
            let (mut along, length) = span(ends.map(|n| elements.x()[n]));
            let (rest, mut l0) = span(ends.map(|n| elements.rest()[n]));
            if F == fault::HINGE_FLAT_AT_REST {
                l0 = flat_distance([a, b, o, p].map(|node| elements.rest()[node as usize]));
            }
            out[0][e] = length - l0;
            if F == fault::HINGE_NOT_OBJECTIVE {
                along = rest;
                out[0][e] =
                    (0..3).map(|i| (elements.x()[ends[1]][i] - elements.x()[ends[0]][i]) * rest[i]).sum::<f64>() - l0;
            }
            let factor = if F == fault::HINGE_GRADIENT_OFF { 1.01 } else { 1.0 };
            for i in 0..3 {
                (out[1 + i][e], out[4 + i][e]) = (0.0, 0.0);
                (out[7 + i][e], out[10 + i][e]) = (-factor * along[i], factor * along[i]);
            }
        }
        Ok(())
    }

    fn compliance(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let others = if F == fault::COMPLIANCE_INDEFINITE { 2.0 } else { 0.2 };
        let out = out.first_planes::<6>();
        for e in 0..elements.len() {
            [1.0, others, others, 1.0, others, 1.0].into_iter().enumerate().for_each(|(s, g)| out[s][e] = g);
        }
        Ok(())
    }

    fn normals_energy(&self, elements: &Elements<'_>, unit_normals: &[[f64; 3]]) -> Result<f64, Fault> {
        Ok(normals::energy(F, elements, unit_normals))
    }

    fn normals_forces(
        &self,
        elements: &Elements<'_>,
        unit_normals: &[[f64; 3]],
        out: &mut NormalForces<'_>,
    ) -> Result<(), Fault> {
        normals::forces(F, elements, unit_normals, out);
        Ok(())
    }

    fn tilt(&self, elements: &Elements<'_>, out: &mut Planes<'_>) -> Result<(), Fault> {
        let out = out.first_planes::<3>();
        for e in 0..elements.len() {
            normals::tilt(F, elements, e).into_iter().enumerate().for_each(|(s, tilt)| out[s][e] = tilt);
        }
        Ok(())
    }
}
