//! Energies of vertex normals: forces at fixed normals, slopes in them, and how stiffly they tilt.

use super::super::Given;
use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::opened::Opened;
use super::invariance::turn;
use super::linear::largest;
use super::material::{deform, random, sound};
use super::{Verdict, judge, told};
use crate::abi;

/// m, and rad
const STEP: f64 = 1e-5;

/// An instance, a body of it, and its triangles.
type Found = (Opened, Body, Vec<[u32; 3]>);

/// A body with an energy of normals, if the material asks for them with its defaults.
fn of_normals(c: &Candidate) -> Result<Option<Found>, String> {
    let (material, body) = sound(c)?;
    let flags =
        |kind: u32| body.counts().find(|(r, _)| r.kind == kind).map_or(0, |(r, _)| r.flags & abi::WANTS_NORMALS);
    let (hinges, triangles) = (flags(abi::HINGE), flags(abi::TRIANGLE));
    judge(hinges == triangles, || "hinges and triangles want normals together, or neither does".into())?;
    if triangles == 0 {
        return Ok(None);
    }
    let (_, corners) = body.tilts(&material).map_err(told)?;
    Ok(Some((material, body, corners)))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn parts(all: &[[f64; 6]]) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    all.iter().map(|[a, b, c, p, q, r]| ([*a, *b, *c], [*p, *q, *r])).unzip()
}

/// The slope of `at` at zero, of fourth order.
fn slope(at: impl Fn(f64) -> Result<f64, String>, h: f64) -> Result<f64, String> {
    Ok((8.0 * (at(h)? - at(-h)?) - (at(2.0 * h)? - at(-2.0 * h)?)) / (12.0 * h))
}

pub(super) fn force_slope(c: &Candidate) -> Result<Verdict, String> {
    let Some((material, mut body, triangles)) = of_normals(c)? else { return Ok(Verdict::Passed) };
    deform(&mut body, 1.02, 0.2);
    let normals = body.normals(&triangles);
    let (force, _) = parts(&body.normals_forces(&material, &normals).map_err(told)?);
    let (most, mut same) = (1e-6 * largest(force.iter().flatten()), true);
    judge(most > 0.0, || "no force in a deformed state".into())?;
    for node in 0..body.x.len() {
        for axis in 0..3 {
            let at = |step: f64| {
                let mut moved = body.clone();
                moved.x[node][axis] += step;
                moved.normals_energy(&material, &normals).map_err(told)
            };
            let (found, given) = (slope(at, STEP)?, force[node][axis]);
            same &= found == -given;
            judge((found + given).abs() <= most, || {
                format!("node {node}, axis {axis}: force {given:.6e} N, slope of the energy {found:.6e} N")
            })?;
        }
    }
    judge(!same, || "force and slope are the same to the last bit: a thing is compared with itself".into())?;
    Ok(Verdict::Passed)
}

pub(super) fn normal_slope(c: &Candidate) -> Result<Verdict, String> {
    let Some((material, mut body, triangles)) = of_normals(c)? else { return Ok(Verdict::Passed) };
    deform(&mut body, 1.02, 0.2);
    let normals = body.normals(&triangles);
    let (_, slopes) = parts(&body.normals_forces(&material, &normals).map_err(told)?);
    let (most, mut same, mut next) = (1e-6 * largest(slopes.iter().flatten()), true, random());
    judge(most > 0.0, || "no slope in a deformed state".into())?;
    for (node, n) in normals.iter().enumerate() {
        // A unit normal only turns.
        let any = [next(), next(), next()];
        let across = [0, 1, 2].map(|i| any[i] - dot(any, *n) * n[i]);
        let across = across.map(|c| c / dot(across, across).sqrt());
        let at = |angle: f64| {
            let mut turned = normals.clone();
            let (s, c) = angle.sin_cos();
            turned[node] = [0, 1, 2].map(|i| c * n[i] + s * across[i]);
            body.normals_energy(&material, &turned).map_err(told)
        };
        let (found, given) = (slope(at, 100.0 * STEP)?, dot(slopes[node], across));
        same &= found == given;
        judge((found - given).abs() <= most, || {
            format!("the normal of node {node}: given {given:.6e} J, slope of the energy {found:.6e} J")
        })?;
    }
    judge(!same, || "given and found are the same to the last bit: a thing is compared with itself".into())?;
    Ok(Verdict::Passed)
}

pub(super) fn turns(c: &Candidate) -> Result<Verdict, String> {
    let Some((material, mut body, triangles)) = of_normals(c)? else { return Ok(Verdict::Passed) };
    deform(&mut body, 1.02, 0.2);
    let mut moved = body.clone();
    moved.x.iter_mut().for_each(|x| *x = turn([x[0] + 0.3, x[1] - 0.2, x[2] + 0.1]));
    let of = |body: &Body| -> Result<_, String> {
        let normals = body.normals(&triangles);
        let all = parts(&body.normals_forces(&material, &normals).map_err(told)?);
        Ok((body.normals_energy(&material, &normals).map_err(told)?, all))
    };
    let ((e0, (f0, s0)), (e1, (f1, s1))) = (of(&body)?, of(&moved)?);
    judge((e0 - e1).abs() <= 1e-9 * e0, || format!("the energy changed from {e0:.9e} J to {e1:.9e} J"))?;
    for (what, before, after) in [("force", &f0, &f1), ("slope", &s0, &s1)] {
        let most = 1e-9 * largest(before.iter().flatten());
        for (node, (b, a)) in before.iter().zip(after).enumerate() {
            let off = (0..3).fold(0.0, |off: f64, i| off.max((turn(*b)[i] - a[i]).abs()));
            judge(off <= most, || format!("the {what} of node {node} changed by {off:.3e}"))?;
        }
    }
    Ok(Verdict::Passed)
}

pub(super) fn rest(c: &Candidate) -> Result<Verdict, String> {
    let Some((material, body, triangles)) = of_normals(c)? else { return Ok(Verdict::Passed) };
    let of = |body: &Body| -> Result<_, String> {
        let normals = body.normals(&triangles);
        let (force, slopes) = parts(&body.normals_forces(&material, &normals).map_err(told)?);
        // What does not turn a normal does nothing.
        let turning: Vec<f64> =
            slopes.iter().zip(&normals).flat_map(|(s, n)| [0, 1, 2].map(|i| s[i] - dot(*s, *n) * n[i])).collect();
        Ok((largest(force.iter().flatten()), largest(&turning)))
    };
    let mut bent = body.clone();
    deform(&mut bent, 1.0, 0.2);
    let ((force, slope), (more, steeper)) = (of(&body)?, of(&bent)?);
    judge(force <= 1e-9 * more, || format!("a force of {force:.3e} N on a flat body at rest"))?;
    judge(slope <= 1e-9 * steeper, || format!("a normal is turned by {slope:.3e} J on a flat body at rest"))?;
    Ok(Verdict::Passed)
}

pub(super) fn tilt(c: &Candidate) -> Result<Verdict, String> {
    let Some((material, ..)) = of_normals(c)? else { return Ok(Verdict::Passed) };
    // One triangle, askew: its normals are tied to nothing else.
    let corners = [[0.0, 0.0], [0.012, 0.001], [0.004, 0.009]];
    let given = Given { nodes: vec![0, 1, 2], material: corners.concat(), ..Given::default() };
    let place = |p: [f64; 2]| [p[0], p[1], 0.0];
    let body = Body::new(&material, corners.map(place).to_vec(), |r| match r.kind {
        abi::TRIANGLE => given.clone(),
        _ => Given::default(),
    });
    let body = body.map_err(told)?;
    let (tilts, _) = body.tilts(&material).map_err(told)?;
    judge(tilts.iter().all(|t| t.is_finite() && *t >= 0.0), || format!("{tilts:?} N m: negative or not written"))?;
    let up = vec![[0.0, 0.0, 1.0]; 3];
    for (side, tilt) in tilts.iter().enumerate() {
        let (a, b) = (corners[side], corners[(side + 1) % 3]);
        let across = [b[1] - a[1], a[0] - b[0], 0.0];
        let across = across.map(|c| c / dot(across, across).sqrt());
        for corner in 0..3 {
            let at = |angle: f64| -> Result<f64, String> {
                let mut tilted = up.clone();
                let (s, c) = angle.sin_cos();
                tilted[corner] = [s * across[0], s * across[1], c];
                let all = body.normals_forces(&material, &tilted).map_err(told)?;
                Ok((0..3).map(|i| all[corner][3 + i] * across[i]).sum())
            };
            let found = slope(at, 100.0 * STEP)?;
            judge(found <= 1.0001 * tilt, || {
                format!("side {side}, corner {corner}: {tilt:.6e} N m given, {found:.6e} found")
            })?;
        }
    }
    Ok(Verdict::Passed)
}
