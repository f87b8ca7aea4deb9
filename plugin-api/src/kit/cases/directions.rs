//! Cases for materials with fibre directions.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::super::random::Random;
use super::derivatives::{ensure_energy_gradient, ensure_exact_tangent_is_force_gradient};
use super::invariance::rotate;
use super::material::{default_body, deform, max_component};
use super::{CaseResult, NotPassed, describe_fault, ensure, skipped};
use crate::abi;

/// Largest difference that is rounding, over the largest value: products in another order.
const ROUNDING: f64 = 1e-9;
/// One in so many elements of a body has no fibres.
const BARE: usize = 7;

/// A random unit vector.
fn unit_vector(random: &mut Random) -> [f64; 3] {
    loop {
        let v = random.vector();
        let length = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        if (0.1..=1.0).contains(&length) {
            return v.map(|c| c / length);
        }
    }
}

/// A material and a stretched body with a random direction in each element, some of them without fibres. Skips a material that wants no
/// directions with its defaults.
fn directed_body(c: &Candidate) -> Result<(TestInstance, Body), NotPassed> {
    let (material, mut body) = default_body(c)?;
    let wanting = |kind: u32| kind == abi::TETRAHEDRON;
    let wrong = body
        .element_counts()
        .find(|(r, _)| r.flags & abi::WANTS_DIRECTIONS != 0 && !wanting(r.kind))
        .map(|(r, _)| r.kind);
    ensure(wrong.is_none(), || {
        format!("the flag WANTS_DIRECTIONS is set for elements of kind {}; allowed is tetrahedra", wrong.unwrap_or(0))
    })?;
    if !body.has(abi::WANTS_DIRECTIONS) {
        return Err(skipped("no element wants fibre directions"));
    }
    set_random_directions(&material, &mut body)?;
    deform(&mut body, 1.1, 0.08);
    Ok((material, body))
}

/// Gives each element a random direction, and some none.
fn set_random_directions(material: &TestInstance, body: &mut Body) -> Result<(), String> {
    let (mut random, mut index) = (Random(5), 0);
    let direction = |_| {
        index += 1;
        let unit = unit_vector(&mut random);
        if index % BARE == 0 { [0.0; 3] } else { unit }
    };
    body.set_directions(material, direction).map_err(describe_fault)
}

/// What a material gives for the shape of a body.
struct EnergyAndForces {
    /// Elastic energy, J.
    energy: f64,
    /// Forces on the nodes, N (n x 3).
    forces: Vec<[f64; 3]>,
}

/// Energy and forces of a body.
fn results(material: &TestInstance, body: &Body) -> Result<EnergyAndForces, String> {
    let energy = body.energy(material).map_err(describe_fault)?;
    Ok(EnergyAndForces { energy, forces: body.forces(material).map_err(describe_fault)? })
}

/// Requires that two bodies have the same energy and forces.
fn ensure_same(before: &EnergyAndForces, after: &EnergyAndForces) -> Result<(), String> {
    let scale = max_component(&before.forces);
    ensure(scale > 0.0, || "no force in a deformed state".into())?;
    ensure((before.energy - after.energy).abs() <= ROUNDING * before.energy.abs(), || {
        format!("the energy changed from {:.9e} J to {:.9e} J", before.energy, after.energy)
    })?;
    let off = before.forces.iter().flatten().zip(after.forces.iter().flatten()).map(|(a, b)| (a - b).abs());
    let off = off.fold(0.0, f64::max);
    ensure(off <= ROUNDING * scale, || format!("a force changed by {off:.3e} N of {scale:.3e} N"))
}

/// Turning the shape at rest together with the directions changes nothing: the law knows no axes of its own.
pub(super) fn turn_with_the_shape_at_rest(c: &Candidate) -> CaseResult {
    let (material, body) = directed_body(c)?;
    let mut turned = body.clone();
    turned.rotate_rest(&material, rotate).map_err(describe_fault)?;
    ensure_same(&results(&material, &body)?, &results(&material, &turned)?)?;
    Ok(())
}

/// A direction and its opposite are one line; another line gives other forces.
pub(super) fn have_no_sign(c: &Candidate) -> CaseResult {
    let (material, mut body) = directed_body(c)?;
    let line = unit_vector(&mut Random(11));
    let mut with = |direction: [f64; 3]| {
        body.set_directions(&material, |_| direction).map_err(describe_fault)?;
        results(&material, &body)
    };
    let (forth, back) = (with(line)?, with(line.map(|c| -c))?);
    ensure_same(&forth, &back)?;
    let across = with([line[1], -line[0], 0.0].map(|c| c / (line[0] * line[0] + line[1] * line[1]).sqrt()))?;
    ensure(ensure_same(&forth, &across).is_err(), || "a direction across it gives the same energy and forces".into())?;
    Ok(())
}

/// Derivatives hold with any directions.
pub(super) fn derivatives_hold(c: &Candidate) -> CaseResult {
    let (material, body) = directed_body(c)?;
    ensure_energy_gradient(&material, &body, 1e-5)?;
    ensure_exact_tangent_is_force_gradient(c, set_random_directions)?;
    Ok(())
}
