//! Energy, force and matrices against each other's differences. Each case first proves that it does not compare a thing with
//! itself: a difference is never the same to the last bit.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::opened::Opened;
use super::linear::{is_definite, largest};
use super::material::{deform, random, set_moving, size, sound, specimen};
use super::{Verdict, judge, told};
use crate::abi;
use crate::material::Tangent;

const STIFFNESS: Tangent = Tangent { stiffness: 1.0, damping: 0.0 };
const DAMPING: Tangent = Tangent { stiffness: 0.0, damping: 1.0 };
/// m
const STEP: f64 = 1e-7;

pub(super) fn force_slope(c: &Candidate) -> Result<Verdict, String> {
    let (material, mut body) = sound(c)?;
    deform(&mut body, 1.1, 0.08);
    let force = body.forces(&material).map_err(told)?;
    let scale = size(&force);
    judge(scale > 0.0, || "no force in a deformed state".into())?;
    let (mut next, mut same) = (random(), true);
    for trial in 0..24 {
        // Whole-body directions, and single components in turn.
        let mut along = vec![[0.0; 3]; body.x.len()];
        if trial < 6 {
            along.iter_mut().for_each(|d| *d = [next(), next(), next()]);
        } else {
            along[trial * 7 % body.x.len()][trial % 3] = 1.0;
        }
        let at = |step: f64| -> Result<f64, String> {
            let mut moved = body.clone();
            for (x, d) in moved.x.iter_mut().zip(&along) {
                (0..3).for_each(|i| x[i] += step * d[i]);
            }
            moved.energy(&material).map_err(told)
        };
        // Fourth order, so that the differences can be long and lose few digits.
        let h = 100.0 * STEP;
        let slope = (8.0 * (at(h)? - at(-h)?) - (at(2.0 * h)? - at(-2.0 * h)?)) / (12.0 * h);
        let pull: f64 = force.iter().flatten().zip(along.iter().flatten()).map(|(f, d)| f * d).sum();
        same &= pull == -slope;
        let most = 1e-5 * scale * (trial < 6).then_some(body.x.len() as f64).map_or(1.0, f64::sqrt);
        judge((pull + slope).abs() <= most, || format!("force {pull:.6e} N, slope of the energy {slope:.6e} N"))?;
    }
    judge(!same, || "force and slope are the same to the last bit: a thing is compared with itself".into())?;
    Ok(Verdict::Passed)
}

/// `-df/dx` or `-df/dv` (3n x 3n) by central differences.
fn slopes(material: &Opened, body: &Body, over_velocity: bool) -> Result<Vec<f64>, String> {
    let width = 3 * body.x.len();
    let step = if over_velocity { 1e-3 } else { STEP };
    let mut dense = vec![0.0; width * width];
    for column in 0..width {
        let at = |step: f64| -> Result<Vec<[f64; 3]>, String> {
            let mut moved = body.clone();
            let field = if over_velocity { &mut moved.v } else { &mut moved.x };
            field[column / 3][column % 3] += step;
            moved.forces(material).map_err(told)
        };
        let (plus, minus) = (at(step)?, at(-step)?);
        for row in 0..width {
            dense[row * width + column] = (minus[row / 3][row % 3] - plus[row / 3][row % 3]) / (2.0 * step);
        }
    }
    Ok(dense)
}

/// The largest difference of two matrices, over the largest entry of the first.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / largest(a)
}

fn symmetric(a: &[f64], width: usize) -> bool {
    let most = 1e-9 * largest(a);
    (0..width * width).all(|i| (a[i] - a[i % width * width + i / width]).abs() <= most)
}

pub(super) fn stiffness_slope(c: &Candidate) -> Result<Verdict, String> {
    let (material, rest) = sound(c)?;
    let width = 3 * rest.x.len();
    let (k, slope) = (rest.tangent(&material, STIFFNESS).map_err(told)?, slopes(&material, &rest, false)?);
    judge(largest(&k) > 0.0, || "no stiffness at rest".into())?;
    judge(k != slope, || "stiffness and slope are the same to the last bit".into())?;
    let error = apart(&k, &slope);
    judge(error <= 1e-5, || format!("at rest it is {error:.2e} of its largest entry off"))?;
    let mut body = rest;
    deform(&mut body, 0.97, 0.08);
    let k = body.tangent(&material, STIFFNESS).map_err(told)?;
    judge(symmetric(&k, width), || "it is not symmetric".into())?;
    let slope = slopes(&material, &body, false)?;
    let over: Vec<f64> = k.iter().zip(&slope).map(|(k, s)| k - s).collect();
    judge(is_definite(&over, width, 1e-5 * largest(&k)), || {
        "deformed it is softer than the slope of the force".into()
    })?;
    exact(c)
}

/// A choice `exact` of a parameter `tangent` must give the slope itself.
fn exact(c: &Candidate) -> Result<Verdict, String> {
    let params = c.params();
    let found = params.iter().enumerate().find_map(|(place, p)| {
        let choice = Candidate::choices(p).iter().position(|choice| *choice == "exact")?;
        (p.kind == abi::PARAM_CHOICE && Candidate::key(p) == "tangent").then_some((place, choice as f64))
    });
    let Some(setting) = found else { return Ok(Verdict::Passed) };
    let material = c.open(&[setting]).map_err(told)?;
    let mut body = specimen(&material)?;
    deform(&mut body, 0.97, 0.08);
    let (k, slope) = (body.tangent(&material, STIFFNESS).map_err(told)?, slopes(&material, &body, false)?);
    let error = apart(&k, &slope);
    judge(error <= 1e-5, || format!("with `tangent` exact it is {error:.2e} of its largest entry off"))?;
    Ok(Verdict::Passed)
}

pub(super) fn damping(c: &Candidate) -> Result<Verdict, String> {
    let (material, mut body) = sound(c)?;
    let width = 3 * body.x.len();
    deform(&mut body, 1.05, 0.05);
    let still = body.forces(&material).map_err(told)?;
    set_moving(&mut body);
    let moving = body.forces(&material).map_err(told)?;
    if !body.has(abi::HAS_DAMPING) {
        judge(still == moving, || "it declares no damping, and its force depends on velocity".into())?;
        return Ok(Verdict::Skipped("it declares no damping with its defaults".into()));
    }
    let (damping, slope) = (body.tangent(&material, DAMPING).map_err(told)?, slopes(&material, &body, true)?);
    judge(largest(&damping) > 0.0, || "it declares damping and has none".into())?;
    judge(damping != slope, || "damping and slope are the same to the last bit".into())?;
    judge(symmetric(&damping, width), || "it is not symmetric".into())?;
    let error = apart(&damping, &slope);
    judge(error <= 1e-6, || format!("it is {error:.2e} of its largest entry off the slope of the force"))?;
    judge(is_definite(&damping, width, 1e-9 * largest(&damping)), || "there is a motion it gives energy to".into())?;
    let power: f64 = (0..width).map(|d| (moving[d / 3][d % 3] - still[d / 3][d % 3]) * body.v[d / 3][d % 3]).sum();
    judge(power < 0.0, || format!("a moving body gains {power:.3e} W"))?;
    Ok(Verdict::Passed)
}
