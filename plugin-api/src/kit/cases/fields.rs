//! The case for parameters that may vary per element.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::material::{default_body, deform, set_moving, test_body};
use super::{CaseResult, describe_fault, ensure, skipped};
use crate::abi;
use crate::fault::Fault;
use crate::material::TangentScale;

/// Factors a parameter is tested with.
const FACTORS: [f64; 2] = [0.4, 2.5];
/// Largest difference that is rounding, over the largest value: products in another order.
const ROUNDING: f64 = 1e-9;

/// Everything a material computes of a state, by name.
fn results(material: &TestInstance, body: &Body) -> Result<Vec<(&'static str, Vec<f64>)>, Fault> {
    let mut all = vec![
        ("mass", body.mass(material)?),
        ("energy", vec![body.energy(material)?]),
        ("forces", body.forces(material)?.into_iter().flatten().collect()),
        ("matrix", body.tangent(material, TangentScale { stiffness: 1.0, damping: 0.5 })?),
    ];
    if body.has(abi::IS_COUPLED) {
        all.push(("compliance", body.compliances(material)?.values));
    }
    if body.has(abi::WANTS_NORMALS) {
        let tilts = body.tilts(material)?;
        let normals = body.normals(&tilts.corners);
        all.push(("energy of normals", vec![body.normals_energy(material, &normals)?]));
        all.push(("tilt", tilts.values));
    }
    Ok(all)
}

/// Requires that two sets of results agree.
fn compare(key: &str, expected: &[(&str, Vec<f64>)], found: &[(&str, Vec<f64>)]) -> Result<(), String> {
    for ((what, expected), (_, found)) in expected.iter().zip(found) {
        let scale = expected.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        // NaN, of a plane that is not there, is never within.
        let within = |(a, b): (&f64, &f64)| (a - b).abs() <= ROUNDING * scale;
        let wrong = expected.iter().zip(found).position(|pair| !within(pair));
        if let Some(i) = wrong {
            return Err(format!("field of `{key}`: {what} {i} is {:.6e} instead of {:.6e}", found[i], expected[i]));
        }
    }
    Ok(())
}

fn moved(mut body: Body) -> Body {
    deform(&mut body, 1.05, 0.05);
    set_moving(&mut body);
    body
}

pub(super) fn scale_their_parameters(c: &Candidate) -> CaseResult {
    let params = c.params();
    let fields: Vec<usize> = (0..params.len()).filter(|i| params[*i].flags & abi::PARAM_FIELD != 0).collect();
    if fields.is_empty() {
        return Err(skipped("no parameter is declared as a field"));
    }
    for (field, &index) in fields.iter().enumerate() {
        let (p, key) = (&params[index], Candidate::key(&params[index]));
        ensure(p.kind == abi::PARAM_NUMBER, || format!("`{key}` is a field and no number"))?;
        for factor in FACTORS.into_iter().filter(|f| (p.min..=p.max).contains(&(f * p.fallback))) {
            let scaled = c.open(&[(index, factor * p.fallback)]).map_err(describe_fault)?;
            let scaled_body = moved(test_body(&scaled)?);
            let expected = results(&scaled, &scaled_body).map_err(describe_fault)?;
            let (material, mut body) = default_body(c)?;
            body.set_fields(&material, fields.len(), |f, _| if f == field { factor } else { 1.0 })
                .map_err(describe_fault)?;
            compare(key, &expected, &results(&material, &moved(body)).map_err(describe_fault)?)?;
        }
        is_local(c, fields.len(), field, key)?;
    }
    Ok(())
}

/// Requires that two halves with different factors give what each half gives with its own, where no element of the other is near.
fn is_local(c: &Candidate, count: usize, field: usize, key: &str) -> Result<(), String> {
    let (material, rest) = default_body(c)?;
    let middle = rest.rest.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x[0]), b.max(x[0])]);
    let middle = 0.5 * (middle[0] + middle[1]);
    let with = |low: f64, high: f64| -> Result<Vec<f64>, String> {
        let mut body = rest.clone();
        let factor = |f: usize, x: [f64; 3]| {
            if f != field {
                1.0
            } else if x[0] < middle {
                low
            } else {
                high
            }
        };
        body.set_fields(&material, count, factor).map_err(describe_fault)?;
        let body = moved(body);
        let (mass, force) =
            (body.mass(&material).map_err(describe_fault)?, body.forces(&material).map_err(describe_fault)?);
        Ok(mass.into_iter().chain(force.into_iter().flatten()).collect())
    };
    let (both, low, high) =
        (with(FACTORS[0], FACTORS[1])?, with(FACTORS[0], FACTORS[0])?, with(FACTORS[1], FACTORS[1])?);
    let n = rest.rest.len();
    let node = |i: usize| if i < n { i } else { (i - n) / 3 };
    let ends = [f64::NEG_INFINITY, f64::INFINITY].map(|side| {
        rest.rest.iter().map(|x| x[0]).fold(-side, |most: f64, x| if side > 0.0 { most.max(x) } else { most.min(x) })
    });
    let scale = both.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    for (end, expected) in ends.into_iter().zip([&low, &high]) {
        for i in (0..both.len()).filter(|i| rest.rest[node(*i)][0] == end) {
            ensure((both[i] - expected[i]).abs() <= ROUNDING * scale, || {
                format!(
                    "field of `{key}`: elements with a factor of their own gave {:.6e} instead of {:.6e}",
                    both[i], expected[i]
                )
            })?;
        }
    }
    Ok(())
}
