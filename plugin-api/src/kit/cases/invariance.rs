//! What must not matter: where, which way round, in which order.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::opened::Opened;
use super::super::subject::Subject;
use super::super::{Given, block, corners, sheet};
use super::material::{deform, nothing, size, sound};
use super::{Verdict, judge, told};

/// How far off energy and forces of `moved` are from those of `body`, turned: parts of their size.
fn compare(material: &Opened, body: &Body, moved: &Body, turn: impl Fn([f64; 3]) -> [f64; 3]) -> Result<(), String> {
    let energies = (body.energy(material).map_err(told)?, moved.energy(material).map_err(told)?);
    let (before, after) = (body.forces(material).map_err(told)?, moved.forces(material).map_err(told)?);
    let most = nothing(material, body)?.max(1e-9 * size(&before));
    judge(size(&before) > most, || "no force in a deformed state".into())?;
    let off =
        before.iter().zip(&after).flat_map(|(b, a)| (0..3).map(|i| (turn(*b)[i] - a[i]).abs()).collect::<Vec<_>>());
    let off = off.fold(0.0, f64::max);
    judge(off <= 100.0 * most, || format!("a force changed by {off:.3e} N of {:.3e} N", size(&before)))?;
    let scale = energies.0.abs().max(energies.1.abs());
    let lost = (energies.0 - energies.1).abs();
    judge(lost <= 1e-7 * scale, || format!("the energy changed from {:.9e} J to {:.9e} J", energies.0, energies.1))
}

pub(super) fn translation(c: &Candidate) -> Result<Verdict, String> {
    let (material, mut body) = sound(c)?;
    deform(&mut body, 1.05, 0.05);
    let mut moved = body.clone();
    moved.x.iter_mut().for_each(|x| *x = [x[0] + 0.3, x[1] - 0.2, x[2] + 0.1]);
    compare(&material, &body, &moved, |f| f)?;
    Ok(Verdict::Passed)
}

pub(super) fn rotation(c: &Candidate) -> Result<Verdict, String> {
    let (material, mut body) = sound(c)?;
    deform(&mut body, 1.05, 0.05);
    let mut turned = body.clone();
    turned.x.iter_mut().for_each(|x| *x = turn(*x));
    compare(&material, &body, &turned, turn)?;
    Ok(Verdict::Passed)
}

pub(super) fn order(c: &Candidate) -> Result<Verdict, String> {
    let (material, mut body) = sound(c)?;
    deform(&mut body, 1.05, 0.05);
    let wanted = material.wants().map_err(told)?;
    let families = wanted.iter().fold(0, |all, r| all | r.families);
    let (block, sheet) = (block([2, 2, 2], 0.01, families), sheet([3, 3], 0.01));
    let given = |kind: u32| {
        let surface = body.rest.len() == sheet.rest.len();
        if surface { sheet.given(kind) } else { block.given(kind) }
    };
    let mut other =
        Body::new(&material, body.rest.clone(), |r| backwards(given(r.kind), corners(r.kind))).map_err(told)?;
    other.x.clone_from(&body.x);
    compare(&material, &body, &other, |f| f)?;
    Ok(Verdict::Passed)
}

/// The list the other way round, each element with its nodes as they were.
fn backwards(given: Given, corners: usize) -> Given {
    let turned = |list: &[f64], width: usize| list.chunks(width.max(1)).rev().flatten().copied().collect();
    Given {
        nodes: given.nodes.chunks(corners).rev().flatten().copied().collect(),
        family: given.family.iter().rev().copied().collect(),
        measure: turned(&given.measure, 1),
        material: turned(&given.material, 2 * corners),
    }
}

/// By 2.2 rad about (1, 2, 2)/3, through the origin.
pub(super) fn turn(p: [f64; 3]) -> [f64; 3] {
    let (s, c) = 2.2_f64.sin_cos();
    let axis = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
    let along: f64 = (0..3).map(|i| axis[i] * p[i]).sum();
    let cross = [axis[1] * p[2] - axis[2] * p[1], axis[2] * p[0] - axis[0] * p[2], axis[0] * p[1] - axis[1] * p[0]];
    [0, 1, 2].map(|i| c * p[i] + s * cross[i] + (1.0 - c) * along * axis[i])
}
