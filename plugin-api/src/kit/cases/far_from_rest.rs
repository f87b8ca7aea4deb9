//! Derivatives far from rest and with other parameters, where a case near rest sees nothing.

use super::super::candidate::Candidate;
use super::derivatives::ensure_energy_gradient;
use super::material::{default_body, deform, test_body};
use super::{CaseResult, ensure, skipped, tested};
use crate::abi;

/// States far from rest: what each coordinate is multiplied by, then by how much of a cell's edge coordinates are off at random.
const STATES: [(&str, [f64; 3], f64); 4] = [
    ("stretched to twice its size", [2.0, 2.0, 2.0], 0.3),
    ("drawn out to three times its length", [3.0, 0.6, 0.6], 0.1),
    ("squeezed to a third", [0.35, 0.35, 0.35], 0.05),
    ("turned inside out", [-0.7, 0.8, 0.9], 0.1),
];

/// Tolerance relative to the largest component of the force: a difference across a kink of the force, where wrinkles or buckling begin, is off by more
/// than rounding.
const TOLERANCE: f64 = 1e-3;

/// Skips where the force is not the gradient near rest with the defaults: these cases say nothing new then.
fn ensure_holds_near_rest(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    deform(&mut body, 1.1, 0.08);
    let holds = ensure_energy_gradient(&material, &body, TOLERANCE);
    holds.map(|_| ()).map_err(|_| skipped("it does not hold near rest: see `force-is-energy-gradient`"))
}

/// The force is minus the gradient of the energy far from rest.
pub(super) fn force_is_energy_gradient(c: &Candidate) -> CaseResult {
    ensure_holds_near_rest(c)?;
    for (state, factors, jitter) in STATES {
        let (material, mut body) = default_body(c)?;
        body.x.iter_mut().for_each(|x| (0..3).for_each(|i| x[i] *= factors[i]));
        deform(&mut body, 1.0, jitter);
        ensure_energy_gradient(&material, &body, TOLERANCE).map_err(|why| format!("a body {state}: {why}"))?;
    }
    Ok(())
}

/// The force is minus the gradient of the energy with each number at other values than its default.
pub(super) fn force_is_energy_gradient_with_any_parameter(c: &Candidate) -> CaseResult {
    ensure_holds_near_rest(c)?;
    let mut tried = 0;
    for (index, p) in c.params().iter().enumerate().filter(|(_, p)| p.kind == abi::PARAM_NUMBER) {
        // Near enough to the default for a state of moderate strain, whatever the range is.
        let values =
            [p.fallback + 0.2 * (p.max - p.fallback).min(p.fallback.abs().max(1e-3)), 0.5 * (p.fallback + p.min)];
        for value in values.into_iter().filter(|value| *value != p.fallback) {
            let Ok(material) = c.open(&[(index, value)]) else { continue };
            let mut body = test_body(&material)?;
            deform(&mut body, 1.1, 0.08);
            tried += 1;
            ensure_energy_gradient(&material, &body, TOLERANCE)
                .map_err(|why| format!("with `{}` = {value}: {why}", Candidate::key(p)))?;
        }
    }
    ensure(tried > 0 || c.params().iter().all(|p| p.kind != abi::PARAM_NUMBER), || {
        "no other value of any of its parameters is taken".into()
    })?;
    tested(tried, "it has no numbers for parameters")
}
