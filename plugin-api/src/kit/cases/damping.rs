//! Cases for damping at high velocities and of rigid motions.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::invariance::ensure_objective;
use super::material::{default_body, deform, max_component, set_moving};
use super::matrix::{max_abs, relative_difference};
use super::{CaseResult, NotPassed, describe_fault, ensure, skipped};
use crate::abi;
use crate::material::TangentScale;

/// Largest difference that is rounding, over the largest value: forces with and without damping are subtracted.
const ROUNDING: f64 = 1e-7;
/// Speeds of nodes, m/s: of a slow hand, and of what a body may reach before it is stopped.
const SPEEDS: [f64; 3] = [1e-2, 10.0, 1e3];

/// A material with damping and a deformed body; skips one without.
fn damped_body(c: &Candidate) -> Result<(TestInstance, Body), NotPassed> {
    let (material, mut body) = default_body(c)?;
    if !body.has(abi::HAS_DAMPING) {
        return Err(skipped("it does not declare damping with its defaults"));
    }
    deform(&mut body, 1.05, 0.05);
    Ok((material, body))
}

/// What velocities add to the forces of a body, N (n x 3).
fn damping_forces(material: &TestInstance, body: &Body) -> Result<Vec<f64>, String> {
    let mut still = body.clone();
    still.v.fill([0.0; 3]);
    let (moving, still) =
        (body.forces(material).map_err(describe_fault)?, still.forces(material).map_err(describe_fault)?);
    Ok(moving.iter().flatten().zip(still.iter().flatten()).map(|(m, s)| m - s).collect())
}

/// At any speed the force of damping is `-C v`, with the same matrix.
pub(super) fn is_linear(c: &Candidate) -> CaseResult {
    let (material, body) = damped_body(c)?;
    let elastic = max_component(&body.forces(&material).map_err(describe_fault)?);
    let matrix_of =
        |body: &Body| body.tangent(&material, TangentScale { stiffness: 0.0, damping: 1.0 }).map_err(describe_fault);
    let matrix = matrix_of(&body)?;
    for speed in SPEEDS {
        let mut moving = body.clone();
        set_moving(&mut moving);
        moving.v.iter_mut().for_each(|v| *v = v.map(|c| speed * c));
        let off = relative_difference(&matrix, &matrix_of(&moving)?);
        ensure(off <= ROUNDING, || {
            format!(
                "nodes at {speed} m/s: the damping matrix differs from that at rest by {off:.2e} of its largest entry"
            )
        })?;
        let v: Vec<f64> = moving.v.iter().flatten().copied().collect();
        let found = damping_forces(&material, &moving)?;
        let tolerance = ROUNDING * (max_abs(&found) + elastic);
        for (row, (entries, force)) in matrix.chunks_exact(v.len()).zip(&found).enumerate() {
            let expected = -entries.iter().zip(&v).map(|(c, v)| c * v).sum::<f64>();
            // NaN, of a force that is not finite, is never within.
            ensure((force - expected).abs() <= tolerance, || {
                let (node, axis) = (row / 3, row % 3);
                format!(
                    "nodes at {speed} m/s: node {node}, axis {axis}: a damping force of {force:.6e} N, and -C v is {expected:.6e} N"
                )
            })?;
        }
    }
    Ok(())
}

/// A body that moves as a whole, or turns, is not damped, however it is deformed.
pub(super) fn spares_rigid_motions(c: &Candidate) -> CaseResult {
    let (material, body) = damped_body(c)?;
    ensure_objective(c)?;
    let mut moving = body.clone();
    set_moving(&mut moving);
    let scale = max_abs(&damping_forces(&material, &moving)?);
    let elastic = max_component(&body.forces(&material).map_err(describe_fault)?);
    ensure(scale > 0.0, || "random velocities are not damped".into())?;
    // Around the origin, so that nodes have speeds of up to about a metre per second, as those of the random velocities.
    let turn = [20.0, -35.0, 30.0];
    let turning =
        |x: &[f64; 3]| [0, 1, 2].map(|i| turn[(i + 1) % 3] * x[(i + 2) % 3] - turn[(i + 2) % 3] * x[(i + 1) % 3]);
    let motions: [(&str, Vec<[f64; 3]>); 2] =
        [("moves as a whole", vec![[0.6, -0.7, 0.4]; body.x.len()]), ("turns", body.x.iter().map(turning).collect())];
    for (what, velocities) in motions {
        moving.v = velocities;
        let force = max_abs(&damping_forces(&material, &moving)?);
        ensure(force <= ROUNDING * (scale + elastic), || {
            format!("a body that {what} is damped by {force:.3e} N, one with random velocities by {scale:.3e} N")
        })?;
    }
    Ok(())
}
