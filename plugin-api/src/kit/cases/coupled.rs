//! Cases for coupled hinges: their strains, and the compliance between them.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::invariance::{rigid_motion, rotate};
use super::material::{default_body, deform};
use super::matrix::{is_positive_definite, max_abs};
use super::{CaseResult, NotPassed, describe_fault, ensure, skipped};
use crate::abi;

/// Step of finite differences, m.
const STEP: f64 = 1e-6;

/// An instance and a body with coupled hinges; skips a material that does not ask for them with its defaults.
fn coupled_body(c: &Candidate) -> Result<(TestInstance, Body), NotPassed> {
    let (material, body) = default_body(c)?;
    let is_coupled = |kind: u32| body.element_counts().any(|(r, _)| r.kind == kind && r.flags & abi::IS_COUPLED != 0);
    let (hinges, triangles) = (is_coupled(abi::HINGE), is_coupled(abi::TRIANGLE));
    ensure(hinges == triangles, || {
        "the flag IS_COUPLED is set for one of hinges and triangles, and not for both".into()
    })?;
    if hinges { Ok((material, body)) } else { Err(skipped("no hinge is coupled with its defaults")) }
}

/// The gradient of the strain is its derivative by the positions, by central differences; there is no strain at rest.
pub(super) fn strain_gradient(c: &Candidate) -> CaseResult {
    let (material, mut body) = coupled_body(c)?;
    let at_rest = body.strains(&material).map_err(describe_fault)?;
    deform(&mut body, 1.02, 0.2);
    let deformed = body.strains(&material).map_err(describe_fault)?;
    let finite = deformed.values.iter().all(|s| s.is_finite());
    ensure(finite, || "a strain or gradient is not finite or was not written".into())?;
    let tolerance = 1e-9 * max_abs(deformed.plane(0));
    ensure(tolerance > 0.0, || "no strain in a deformed state".into())?;
    let rest_strain = max_abs(at_rest.plane(0));
    ensure(rest_strain <= tolerance, || format!("a strain of {rest_strain:.3e} m at rest"))?;
    let m = deformed.corners.len();
    let (scale, mut bit_identical) = (max_abs(&deformed.values[m..]), true);
    for node in 0..body.x.len() {
        for axis in 0..3 {
            let strain_at = |step: f64| -> Result<Vec<f64>, String> {
                let mut moved = body.clone();
                moved.x[node][axis] += step;
                moved.strains(&material).map_err(describe_fault).map(|s| s.plane(0).to_vec())
            };
            let (plus, minus) = (strain_at(STEP)?, strain_at(-STEP)?);
            for (e, corners) in deformed.corners.iter().enumerate() {
                let corner = corners.iter().position(|n| *n as usize == node);
                let gradient = corner.map_or(0.0, |corner| deformed.plane(1 + 3 * corner + axis)[e]);
                let difference = (plus[e] - minus[e]) / (2.0 * STEP);
                bit_identical &= gradient == difference;
                ensure((gradient - difference).abs() <= 1e-5 * scale, || {
                    format!(
                        "hinge {e}, node {node}, axis {axis}: gradient {gradient:.6e}, finite difference {difference:.6e}"
                    )
                })?;
            }
        }
    }
    ensure(!bit_identical, || {
        "gradient and finite difference are identical to the last bit: one is made of the other".into()
    })?;
    Ok(())
}

/// A rigid motion keeps the strains and rotates their gradients.
pub(super) fn strain_is_objective(c: &Candidate) -> CaseResult {
    let (material, mut body) = coupled_body(c)?;
    deform(&mut body, 1.02, 0.2);
    let mut moved = body.clone();
    moved.x.iter_mut().for_each(|x| *x = rigid_motion(*x));
    let before = body.strains(&material).map_err(describe_fault)?;
    let after = moved.strains(&material).map_err(describe_fault)?;
    let m = before.corners.len();
    let (strain, gradient) = (max_abs(before.plane(0)), max_abs(&before.values[m..]));
    for e in 0..m {
        let change = (before.plane(0)[e] - after.plane(0)[e]).abs();
        ensure(change <= 1e-9 * strain, || format!("the strain of hinge {e} changed by {change:.3e} m"))?;
        for corner in 0..4 {
            let [expected, found] = [&before, &after].map(|s| [0, 1, 2].map(|i| s.plane(1 + 3 * corner + i)[e]));
            let expected = rotate(expected);
            let change = (0..3).fold(0.0, |max: f64, i| max.max((expected[i] - found[i]).abs()));
            ensure(change <= 1e-9 * gradient, || format!("a gradient of hinge {e} changed by {change:.3e}"))?;
        }
    }
    Ok(())
}

/// The compliance is positive definite, of each triangle and assembled over the interior edges.
pub(super) fn compliance_is_positive_definite(c: &Candidate) -> CaseResult {
    let (material, body) = coupled_body(c)?;
    let compliance = body.compliances(&material).map_err(describe_fault)?;
    let hinges = body.strains(&material).map_err(describe_fault)?.corners;
    let hinge_of = |a: u32, b: u32| hinges.iter().position(|h| h[..2] == [a, b] || h[..2] == [b, a]);
    let mut assembled = vec![0.0; hinges.len() * hinges.len()];
    for (e, t) in compliance.corners.iter().enumerate() {
        let g = |plane: usize| compliance.plane(plane)[e];
        let own = [g(0), g(1), g(2), g(1), g(3), g(4), g(2), g(4), g(5)];
        ensure(own.iter().all(|v| v.is_finite()), || format!("triangle {e}: not finite or not written"))?;
        let shift = -1e-9 * max_abs(&own);
        ensure(is_positive_definite(&own, 3, shift), || format!("triangle {e}: {own:?} is not positive definite"))?;
        let sides = [0, 1, 2].map(|s| hinge_of(t[s], t[(s + 1) % 3]));
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            if let (Some(p), Some(q)) = (sides[i], sides[j]) {
                assembled[p * hinges.len() + q] += own[3 * i + j];
            }
        }
    }
    ensure(is_positive_definite(&assembled, hinges.len(), 0.0), || {
        "the sum over triangles is not positive definite".into()
    })?;
    Ok(())
}
