//! Cases for every material, and the bodies they use.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::super::random::Random;
use super::super::tested_material::MaterialUnderTest;
use super::super::{block, sheet};
use super::coupled::{compliance_is_positive_definite, strain_gradient, strain_is_objective};
use super::derivatives::{
    damping_dissipates, force_is_energy_gradient, stiffness_is_force_gradient, tangent_is_linear,
};
use super::invariance::{element_order, rotation, translation};
use super::matrix::max_abs;
use super::repeatability::{
    calls_are_bit_identical, instances_are_independent, no_allocation, state_is_bit_identical,
    threads_are_bit_identical,
};
use super::{
    Case, CaseResult, NO_EXTREMES, damping, describe_fault, directions, ensure, far_from_rest, fields, guards, history,
    measure, normals, pages, panics, rest_shape, single, tested, whole_lists,
};
use crate::abi;
use crate::material::TangentScale;

pub(super) const CASES: &[Case] = &[
    Case {
        name: "mass-is-positive",
        promise: "every node of a body has a finite mass above zero",
        run: mass_is_positive,
    },
    Case {
        name: "measure-scales-contributions",
        promise: "mass, energy, forces and matrix of a point, link or tetrahedron are proportional to its measure",
        run: measure::scales_contributions,
    },
    Case {
        name: "rest-is-force-free",
        promise: "a body at rest has no forces, and a stretched one has",
        run: rest_is_force_free,
    },
    Case {
        name: "curved-rest-is-force-free",
        promise: "a sheet that is curved at rest has no forces and no strain of coupled hinges there",
        run: rest_shape::curved_is_force_free,
    },
    Case {
        name: "axes-turn-with-the-shape-at-rest",
        promise: "turning the shape at rest changes neither energy nor forces",
        run: rest_shape::axes_turn_with_it,
    },
    Case {
        name: "force-is-energy-gradient",
        promise: "the force is minus the gradient of the energy",
        run: force_is_energy_gradient,
    },
    Case {
        name: "force-is-energy-gradient-far-from-rest",
        promise: "the force is minus the gradient of the energy of a stretched, squeezed and inverted body",
        run: far_from_rest::force_is_energy_gradient,
    },
    Case {
        name: "force-is-energy-gradient-with-any-parameter",
        promise: "the force is minus the gradient of the energy with other parameters than the defaults",
        run: far_from_rest::force_is_energy_gradient_with_any_parameter,
    },
    Case {
        name: "stiffness-is-force-gradient",
        promise: "the stiffness is minus the gradient of the force at rest, and nowhere softer than it elsewhere",
        run: stiffness_is_force_gradient,
    },
    Case {
        name: "single-precision-stiffness-matches",
        promise: "off-diagonal blocks in single precision are those in double precision, and the blocks of a row sum to zero",
        run: single::stiffness_matches,
    },
    Case {
        name: "damping-dissipates",
        promise: "damping is symmetric, dissipates energy, and is minus the gradient of the force by the velocity",
        run: damping_dissipates,
    },
    Case {
        name: "damping-is-linear-in-velocity",
        promise: "at any speed the force of damping is `-C v`, with a matrix that does not depend on velocity",
        run: damping::is_linear,
    },
    Case {
        name: "rigid-motion-is-not-damped",
        promise: "a body that moves or turns as a whole has no damping forces",
        run: damping::spares_rigid_motions,
    },
    Case {
        name: "tangent-is-linear-in-its-factors",
        promise: "the matrix of stiffness and damping is the sum of both, each with its factor",
        run: tangent_is_linear,
    },
    Case {
        name: "advance-dissipates",
        promise: "at fixed positions an update of the history adds no elastic energy, and changes nothing at rest",
        run: history::advance_dissipates,
    },
    Case {
        name: "advance-is-objective",
        promise: "a rigid motion of a deformed body changes neither the history it leads to nor the energy after it",
        run: history::advance_is_objective,
    },
    Case {
        name: "failure-follows-from-history",
        promise: "which elements have failed follows from their history alone, and none is while that is zero",
        run: history::failure_follows_from_history,
    },
    Case {
        name: "fields-scale-their-parameters",
        promise: "a field of a parameter multiplies its number, in every element by the element's own factor",
        run: fields::scale_their_parameters,
    },
    Case {
        name: "directions-turn-with-the-shape-at-rest",
        promise: "turning the shape at rest together with the fibre directions changes neither energy nor forces",
        run: directions::turn_with_the_shape_at_rest,
    },
    Case {
        name: "directions-have-no-sign",
        promise: "a fibre direction and its opposite give the same energy and forces, and one across gives others",
        run: directions::have_no_sign,
    },
    Case {
        name: "derivatives-hold-with-any-direction",
        promise: "the force is minus the gradient of the energy with random fibre directions, and an exact matrix that of the force",
        run: directions::derivatives_hold,
    },
    Case {
        name: "coupled-strain-gradient",
        promise: "the gradient of a coupled hinge's strain is its derivative, and the strain is zero at rest",
        run: strain_gradient,
    },
    Case {
        name: "coupled-strain-is-objective",
        promise: "a rigid motion keeps the strains of coupled hinges and rotates their gradients",
        run: strain_is_objective,
    },
    Case {
        name: "compliance-is-positive-definite",
        promise: "the compliance between coupled hinges is positive definite, of each triangle and of the sum",
        run: compliance_is_positive_definite,
    },
    Case {
        name: "normals-force-is-energy-gradient",
        promise: "at fixed normals, the force of an energy of normals is minus its gradient",
        run: normals::force_is_energy_gradient,
    },
    Case {
        name: "normals-derivative-is-energy-gradient",
        promise: "the derivative by the normals is that of the energy",
        run: normals::derivative_is_energy_gradient,
    },
    Case {
        name: "normals-energy-is-objective",
        promise: "a rigid motion keeps the energy of normals and rotates its forces and derivatives",
        run: normals::energy_is_objective,
    },
    Case {
        name: "normals-rest-is-force-free",
        promise: "an energy of normals has no forces on a flat body at rest",
        run: normals::rest_is_force_free,
    },
    Case {
        name: "tilt-is-an-upper-bound",
        promise: "no normal is stiffer against tilting across a side than `tilt` says",
        run: normals::tilt_is_an_upper_bound,
    },
    Case {
        name: "translation-invariance",
        promise: "a translation changes neither energy nor forces",
        run: translation,
    },
    Case { name: "rotation-invariance", promise: "a rotation keeps the energy and rotates the forces", run: rotation },
    Case {
        name: "element-order-invariance",
        promise: "energy and forces do not depend on the order of the elements",
        run: element_order,
    },
    Case {
        name: "ranges-are-bit-identical",
        promise: "calls over ranges of the elements give the bytes of one call",
        run: calls_are_bit_identical,
    },
    Case {
        name: "whole-lists-are-taken",
        promise: "a call takes as many elements as a body has, and fewer after more, and gives the bytes of short calls",
        run: whole_lists::are_taken,
    },
    Case {
        name: "results-are-deterministic",
        promise: "a state gives the same bytes whatever was computed before",
        run: state_is_bit_identical,
    },
    Case {
        name: "instances-are-independent",
        promise: "the parameters of one instance do not affect another",
        run: instances_are_independent,
    },
    Case {
        name: "threads-do-not-interfere",
        promise: "calls from two threads at the same time give the bytes of one after the other",
        run: threads_are_bit_identical,
    },
    Case {
        name: "finite-at-extremes",
        promise: "parameters at the ends of their ranges give finite results",
        run: finite_at_extremes,
    },
    Case {
        name: "nan-is-reported",
        promise: "a position that is NaN gives a fault or forces that are not finite",
        run: nan_is_reported,
    },
    Case {
        name: "planes-are-kept-to",
        promise: "calls read nothing around the planes of rest data, history and fields, and write nothing into or around them",
        run: guards::planes_are_kept_to,
    },
    Case {
        name: "arrays-are-kept-to",
        promise: "calls read nothing around positions, elements, measures and all other arrays, and write nothing into inputs or around outputs",
        run: guards::arrays_are_kept_to,
    },
    Case {
        name: "pages-around-arrays-are-left-alone",
        promise: "with each array in turn next to a guard page, no call touches that page",
        run: pages::are_left_alone,
    },
    Case {
        name: "writes-stay-at-own-elements",
        promise: "a call writes to the nodes, blocks and values of its own elements alone",
        run: guards::writes_stay_at_own_elements,
    },
    Case {
        name: "no-call-panics",
        promise: "no call of a step panics, however far from sense the state is",
        run: panics::no_call_panics,
    },
    Case { name: "no-allocation-in-a-step", promise: "calls inside a step do not allocate", run: no_allocation },
];

/// Edge of a cell or square of the test bodies, m.
pub(super) const EDGE: f64 = 0.01;

/// A small body at rest with the elements the material works on: a sheet for triangles and hinges, else a block.
pub(super) fn test_body(material: &TestInstance) -> Result<Body, String> {
    body_of_size(material, 2, 3)
}

/// As [`test_body`], of `cells` cells or `squares` squares along each side.
pub(super) fn body_of_size(material: &TestInstance, cells: u32, squares: u32) -> Result<Body, String> {
    let requests = material.element_requests().map_err(describe_fault)?;
    let is_sheet = requests.iter().any(|r| [abi::TRIANGLE, abi::HINGE].contains(&r.kind));
    let families = requests.iter().fold(0, |all, r| all | r.families);
    let body = if is_sheet {
        let sheet = sheet([squares; 2], EDGE);
        Body::new(material, sheet.rest.clone(), |r| sheet.elements(r.kind))
    } else {
        let block = block([cells; 3], EDGE, families);
        Body::new(material, block.rest.clone(), |r| block.elements(r.kind))
    };
    let body = body.map_err(|fault| format!("at rest: {}", describe_fault(fault)))?;
    let without_elements = body.element_counts().find(|(_, count)| *count == 0);
    match without_elements {
        Some((r, _)) => Err(format!("the test body has no elements of kind {} and families {}", r.kind, r.families)),
        None => Ok(body),
    }
}

/// An instance with its defaults, and its test body.
pub(super) fn default_body(c: &Candidate) -> Result<(TestInstance, Body), String> {
    let material = c.open(&[]).map_err(describe_fault)?;
    let body = test_body(&material)?;
    Ok((material, body))
}

/// Scales all positions by `stretch`, then moves every coordinate by a random part of `jitter` cell edges.
pub(super) fn deform(body: &mut Body, stretch: f64, jitter: f64) {
    let mut random = Random(1);
    for x in &mut body.x {
        *x = x.map(|c| stretch * c + jitter * EDGE * random.signed());
    }
}

/// Sets random velocities with components of up to 1 m/s.
pub(super) fn set_moving(body: &mut Body) {
    let mut random = Random(1);
    for v in &mut body.v {
        *v = random.vector();
    }
}

/// A force that counts as zero, N: what moves a node by 1e-9 of an edge.
pub(super) fn force_tolerance(material: &TestInstance, body: &Body) -> Result<f64, String> {
    let k = body.tangent(material, TangentScale { stiffness: 1.0, damping: 0.0 }).map_err(describe_fault)?;
    Ok(1e-9 * EDGE * max_abs(&k))
}

/// The largest absolute component of forces, N.
pub(super) fn max_component(forces: &[[f64; 3]]) -> f64 {
    max_abs(forces.iter().flatten())
}

fn mass_is_positive(c: &Candidate) -> CaseResult {
    let (material, body) = default_body(c)?;
    let mass = body.mass(&material).map_err(describe_fault)?;
    match mass.iter().position(|m| !(m.is_finite() && *m > 0.0)) {
        Some(node) => Err(format!("node {node} has a mass of {} kg", mass[node]).into()),
        None => Ok(()),
    }
}

fn rest_is_force_free(c: &Candidate) -> CaseResult {
    let (material, body) = default_body(c)?;
    let tolerance = force_tolerance(&material, &body)?;
    let force = max_component(&body.forces(&material).map_err(describe_fault)?);
    ensure(force <= tolerance, || format!("a force of {force:.3e} N at rest"))?;
    let mut stretched = body;
    deform(&mut stretched, 1.02, 0.0);
    let force = max_component(&stretched.forces(&material).map_err(describe_fault)?);
    ensure(force > tolerance, || "no force on a stretched body either".into())?;
    Ok(())
}

fn finite_at_extremes(c: &Candidate) -> CaseResult {
    let mut tried = 0;
    for (index, p) in c.params().iter().enumerate() {
        let values = match p.kind {
            abi::PARAM_NUMBER => vec![p.min, p.max],
            abi::PARAM_CHOICE => (0..Candidate::choices(p).len()).map(|i| i as f64).collect(),
            _ => continue,
        };
        for value in values {
            let setting = || format!("`{}` = {value}", Candidate::key(p));
            let material = match c.open(&[(index, value)]) {
                Ok(material) => material,
                // A plugin may refuse a combination with the other defaults.
                Err(fault) if fault.status == abi::Status::BAD_ARGUMENT => continue,
                Err(fault) => return Err(format!("{}: {}", setting(), describe_fault(fault)).into()),
            };
            tried += 1;
            let mut body = test_body(&material).map_err(|why| format!("{}: {why}", setting()))?;
            deform(&mut body, 1.1, 0.05);
            set_moving(&mut body);
            let results = || -> Result<[f64; 4], crate::Fault> {
                let tangent = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 1.0 })?;
                let (force, mass) = (body.forces(&material)?, body.mass(&material)?);
                Ok([body.energy(&material)?, sum_abs(force.iter().flatten()), sum_abs(&tangent), sum_abs(&mass)])
            };
            let results = results().map_err(|fault| format!("{}: {}", setting(), describe_fault(fault)))?;
            for (what, value) in ["energy", "force", "matrix", "mass"].iter().zip(results) {
                ensure(value.is_finite(), || format!("{}: the {what} is not finite", setting()))?;
            }
        }
    }
    tested(tried, NO_EXTREMES)
}

/// Sum of absolute values, which is finite only if all are.
fn sum_abs<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().map(|v| v.abs()).sum()
}

fn nan_is_reported(c: &Candidate) -> CaseResult {
    let (material, body) = default_body(c)?;
    for node in [0, body.x.len() / 2, body.x.len() - 1] {
        let mut broken = body.clone();
        broken.x[node][1] = f64::NAN;
        if let Ok(force) = broken.forces(&material) {
            let hidden = force.iter().flatten().all(|f| f.is_finite());
            ensure(!hidden, || format!("node {node} at NaN gave finite forces and no fault"))?;
        }
    }
    Ok(())
}
