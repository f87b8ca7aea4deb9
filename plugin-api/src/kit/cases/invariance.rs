//! Cases for what energy and forces must not depend on: rigid motions, and the order of elements.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::super::tested_material::MaterialUnderTest;
use super::super::{ElementList, block, corners, sheet};
use super::material::{EDGE, default_body, deform, force_tolerance, max_component};
use super::{CaseResult, describe_fault, ensure, skipped};

/// Requires that `moved` has the energy of `body`, and the forces of `body` with `rotation` applied.
pub(super) fn compare(
    material: &TestInstance,
    body: &Body,
    moved: &Body,
    rotation: impl Fn([f64; 3]) -> [f64; 3],
) -> Result<(), String> {
    let energy = |body: &Body| body.energy(material).map_err(describe_fault);
    let (energy_before, energy_after) = (energy(body)?, energy(moved)?);
    let forces = |body: &Body| body.forces(material).map_err(describe_fault);
    let (before, after) = (forces(body)?, forces(moved)?);
    let scale = max_component(&before);
    let tolerance = force_tolerance(material, body)?.max(1e-9 * scale);
    ensure(scale > tolerance, || "no force in a deformed state".into())?;
    let differences = before.iter().zip(&after).flat_map(|(before, after)| {
        let expected = rotation(*before);
        [0, 1, 2].map(|i| (expected[i] - after[i]).abs())
    });
    let change = differences.fold(0.0, f64::max);
    ensure(change <= 100.0 * tolerance, || format!("a force changed by {change:.3e} N of {scale:.3e} N"))?;
    let change = (energy_before - energy_after).abs();
    ensure(change <= 1e-7 * energy_before.abs().max(energy_after.abs()), || {
        format!("the energy changed from {energy_before:.9e} J to {energy_after:.9e} J")
    })
}

/// A translation changes neither energy nor forces.
pub(super) fn translation(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    deform(&mut body, 1.05, 0.05);
    let mut moved = body.clone();
    moved.x.iter_mut().for_each(|x| *x = translate(*x));
    compare(&material, &body, &moved, |f| f)?;
    Ok(())
}

/// A rotation keeps the energy and rotates the forces.
pub(super) fn rotation(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    deform(&mut body, 1.05, 0.05);
    let mut turned = body.clone();
    turned.x.iter_mut().for_each(|x| *x = rotate(*x));
    compare(&material, &body, &turned, rotate)?;
    Ok(())
}

/// Skips a material whose elastic forces depend on how a body lies: what follows from that is no news.
pub(super) fn ensure_objective(c: &Candidate) -> CaseResult {
    rotation(c).map_err(|_| skipped("a rotation changes its energy or forces: see `rotation-invariance`"))
}

/// A body with its element lists reversed has the same energy and forces.
pub(super) fn element_order(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    deform(&mut body, 1.05, 0.05);
    let requests = material.element_requests().map_err(describe_fault)?;
    let families = requests.iter().fold(0, |all, r| all | r.families);
    let (block, sheet) = (block([2, 2, 2], EDGE, families), sheet([3, 3], EDGE));
    let is_sheet = body.rest.len() == sheet.rest.len();
    let elements = |kind: u32| if is_sheet { sheet.elements(kind) } else { block.elements(kind) };
    let mut other = Body::new(&material, body.rest.clone(), |r| reversed(elements(r.kind), corners(r.kind)))
        .map_err(describe_fault)?;
    other.x.clone_from(&body.x);
    compare(&material, &body, &other, |f| f)?;
    Ok(())
}

/// The elements in reversed order, each with its corners in their order.
fn reversed(list: ElementList, corners: usize) -> ElementList {
    let reverse = |values: &[f64], width: usize| values.chunks(width.max(1)).rev().flatten().copied().collect();
    ElementList {
        nodes: list.nodes.chunks(corners).rev().flatten().copied().collect(),
        family: list.family.iter().rev().copied().collect(),
        measure: reverse(&list.measure, 1),
        material: reverse(&list.material, 2 * corners),
    }
}

/// Rotates a vector by 2.2 rad about (1, 2, 2)/3 (Rodrigues' formula).
pub(super) fn rotate(p: [f64; 3]) -> [f64; 3] {
    let (s, c) = 2.2_f64.sin_cos();
    let axis = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
    let along: f64 = (0..3).map(|i| axis[i] * p[i]).sum();
    let cross = [axis[1] * p[2] - axis[2] * p[1], axis[2] * p[0] - axis[0] * p[2], axis[0] * p[1] - axis[1] * p[0]];
    [0, 1, 2].map(|i| c * p[i] + s * cross[i] + (1.0 - c) * along * axis[i])
}

/// Moves a point, m.
fn translate(x: [f64; 3]) -> [f64; 3] {
    [x[0] + 0.3, x[1] - 0.2, x[2] + 0.1]
}

/// Moves a point (m), then rotates it about the origin by [`rotate`].
pub(super) fn rigid_motion(x: [f64; 3]) -> [f64; 3] {
    rotate(translate(x))
}
