//! Cases that compare energy, forces and matrices with finite differences of each other.
//!
//! Each case also requires that both sides differ in their last bits: an implementation that computes one from the other by
//! differences would pass otherwise.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::super::random::Random;
use super::material::{default_body, deform, max_component, set_moving, test_body};
use super::matrix::{is_positive_definite, is_symmetric, max_abs, relative_difference};
use super::{CaseResult, describe_fault, ensure, skipped};
use crate::abi;
use crate::material::TangentScale;

const STIFFNESS: TangentScale = TangentScale { stiffness: 1.0, damping: 0.0 };
const DAMPING: TangentScale = TangentScale { stiffness: 0.0, damping: 1.0 };
/// Step of finite differences over positions, m.
const STEP: f64 = 1e-7;
/// Step of finite differences over velocities, m/s.
const VELOCITY_STEP: f64 = 1e-3;

/// The force is minus the derivative of the energy in a moderately deformed state.
pub(super) fn force_is_energy_gradient(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    deform(&mut body, 1.1, 0.08);
    let is_bit_identical = ensure_energy_gradient(&material, &body, 1e-5)?;
    ensure(!is_bit_identical, || {
        "force and finite difference are identical to the last bit: one is made of the other".into()
    })?;
    Ok(())
}

/// Requires that the force is minus the derivative of the energy, in six directions of the whole body and for 18 single components. `tolerance` is
/// relative to the largest component of the force. Returns whether both are identical to the last bit.
pub(super) fn ensure_energy_gradient(material: &TestInstance, body: &Body, tolerance: f64) -> Result<bool, String> {
    const BODY_DIRECTIONS: usize = 6;
    let force = body.forces(material).map_err(describe_fault)?;
    let scale = max_component(&force);
    ensure(scale > 0.0, || "no force in a deformed state".into())?;
    let (mut random, mut bit_identical) = (Random(1), true);
    for trial in 0..24 {
        let mut direction = vec![[0.0; 3]; body.x.len()];
        if trial < BODY_DIRECTIONS {
            direction.iter_mut().for_each(|d| *d = random.vector());
        } else {
            direction[trial * 7 % body.x.len()][trial % 3] = 1.0;
        }
        let energy_at = |step: f64| -> Result<f64, String> {
            let mut moved = body.clone();
            for (x, d) in moved.x.iter_mut().zip(&direction) {
                (0..3).for_each(|i| x[i] += step * d[i]);
            }
            moved.energy(material).map_err(describe_fault)
        };
        // The difference is of fourth order, so that the step can be long and few digits cancel.
        let h = 100.0 * STEP;
        let slope =
            (8.0 * (energy_at(h)? - energy_at(-h)?) - (energy_at(2.0 * h)? - energy_at(-2.0 * h)?)) / (12.0 * h);
        let along: f64 = force.iter().flatten().zip(direction.iter().flatten()).map(|(f, d)| f * d).sum();
        bit_identical &= along == -slope;
        let components = if trial < BODY_DIRECTIONS { body.x.len() as f64 } else { 1.0 };
        let tolerance = tolerance * scale * components.sqrt();
        ensure((along + slope).abs() <= tolerance, || {
            format!("force {along:.6e} N, finite difference of the energy {slope:.6e} N")
        })?;
    }
    Ok(bit_identical)
}

/// What the forces are differentiated by.
#[derive(Clone, Copy)]
enum Variable {
    Position,
    Velocity,
}

/// `-df/dx` or `-df/dv` (3n x 3n) by central differences.
fn force_differences(material: &TestInstance, body: &Body, variable: Variable) -> Result<Vec<f64>, String> {
    let width = 3 * body.x.len();
    let mut dense = vec![0.0; width * width];
    for column in 0..width {
        let forces_at = |step: f64| -> Result<Vec<[f64; 3]>, String> {
            let mut moved = body.clone();
            let field = match variable {
                Variable::Position => &mut moved.x,
                Variable::Velocity => &mut moved.v,
            };
            field[column / 3][column % 3] += step;
            moved.forces(material).map_err(describe_fault)
        };
        let step = match variable {
            Variable::Position => STEP,
            Variable::Velocity => VELOCITY_STEP,
        };
        let (plus, minus) = (forces_at(step)?, forces_at(-step)?);
        for row in 0..width {
            dense[row * width + column] = (minus[row / 3][row % 3] - plus[row / 3][row % 3]) / (2.0 * step);
        }
    }
    Ok(dense)
}

/// The stiffness is minus the derivative of the force at rest; deformed, it is symmetric and nowhere softer.
pub(super) fn stiffness_is_force_gradient(c: &Candidate) -> CaseResult {
    let (material, body) = default_body(c)?;
    // Fibres that carry tension alone have no derivative at rest.
    let mut rest = body.clone();
    rest.set_directions(&material, |_| [0.0; 3]).map_err(describe_fault)?;
    let width = 3 * rest.x.len();
    let k = rest.tangent(&material, STIFFNESS).map_err(describe_fault)?;
    let difference = force_differences(&material, &rest, Variable::Position)?;
    ensure(max_abs(&k) > 0.0, || "no stiffness at rest".into())?;
    ensure(k != difference, || "stiffness and finite difference are identical to the last bit".into())?;
    let error = relative_difference(&k, &difference);
    ensure(error <= 1e-5, || format!("at rest it is off by {error:.2e} of its largest entry"))?;
    let mut body = body;
    deform(&mut body, 0.97, 0.08);
    let k = body.tangent(&material, STIFFNESS).map_err(describe_fault)?;
    ensure(is_symmetric(&k, width), || "it is not symmetric".into())?;
    let difference = force_differences(&material, &body, Variable::Position)?;
    let excess: Vec<f64> = k.iter().zip(&difference).map(|(k, d)| k - d).collect();
    ensure(is_positive_definite(&excess, width, 1e-5 * max_abs(&k)), || {
        "in a deformed state it is softer than the derivative of the force".into()
    })?;
    ensure_exact_tangent_is_force_gradient(c, |_, _| Ok(()))?;
    Ok(())
}

/// Requires that a material with a choice `exact` of a parameter `tangent` gives the derivative of the force of a deformed body, which `prepare` may
/// change at rest.
pub(super) fn ensure_exact_tangent_is_force_gradient(
    c: &Candidate,
    prepare: impl Fn(&TestInstance, &mut Body) -> Result<(), String>,
) -> Result<(), String> {
    let params = c.params();
    let exact = params.iter().enumerate().find_map(|(index, p)| {
        let choice = Candidate::choices(p).iter().position(|choice| *choice == "exact")?;
        (p.kind == abi::PARAM_CHOICE && Candidate::key(p) == "tangent").then_some((index, choice as f64))
    });
    let Some(setting) = exact else { return Ok(()) };
    let material = c.open(&[setting]).map_err(describe_fault)?;
    let mut body = test_body(&material)?;
    prepare(&material, &mut body)?;
    deform(&mut body, 0.97, 0.08);
    let k = body.tangent(&material, STIFFNESS).map_err(describe_fault)?;
    let error = relative_difference(&k, &force_differences(&material, &body, Variable::Position)?);
    ensure(error <= 1e-5, || format!("with `tangent` exact it is off by {error:.2e} of its largest entry"))
}

/// The matrix of both factors is the sum of those of each.
pub(super) fn tangent_is_linear(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    deform(&mut body, 1.05, 0.05);
    set_moving(&mut body);
    let tangent =
        |stiffness, damping| body.tangent(&material, TangentScale { stiffness, damping }).map_err(describe_fault);
    let (k, d) = (tangent(1.0, 0.0)?, tangent(0.0, 1.0)?);
    // Factors of the size of a step, whose square is that of a stiffness, and of damping alone.
    for (a, b) in [(0.7, 0.3), (1e-6, 1e-3), (2.0, 1e-3)] {
        let both = tangent(a, b)?;
        let sum: Vec<f64> = k.iter().zip(&d).map(|(k, d)| a * k + b * d).collect();
        ensure(max_abs(&both) > 0.0, || format!("with factors {a} and {b} it is zero"))?;
        let error = relative_difference(&both, &sum);
        ensure(error <= 1e-9, || {
            format!(
                "with factors {a} of stiffness and {b} of damping it is off the sum of both by {error:.2e} of its largest entry"
            )
        })?;
    }
    Ok(())
}

/// Damping is symmetric, positive semi-definite, and minus the derivative of the force by the velocity.
pub(super) fn damping_dissipates(c: &Candidate) -> CaseResult {
    let (material, mut body) = default_body(c)?;
    let width = 3 * body.x.len();
    deform(&mut body, 1.05, 0.05);
    let still = body.forces(&material).map_err(describe_fault)?;
    set_moving(&mut body);
    let moving = body.forces(&material).map_err(describe_fault)?;
    if !body.has(abi::HAS_DAMPING) {
        ensure(still == moving, || "it does not declare damping, and its force depends on velocity".into())?;
        return Err(skipped("it does not declare damping with its defaults"));
    }
    let damping = body.tangent(&material, DAMPING).map_err(describe_fault)?;
    let difference = force_differences(&material, &body, Variable::Velocity)?;
    ensure(max_abs(&damping) > 0.0, || "it declares damping, and its damping matrix is zero".into())?;
    ensure(damping != difference, || "damping and finite difference are identical to the last bit".into())?;
    ensure(is_symmetric(&damping, width), || "it is not symmetric".into())?;
    let error = relative_difference(&damping, &difference);
    ensure(error <= 1e-6, || format!("it is off the derivative of the force by {error:.2e} of its largest entry"))?;
    ensure(is_positive_definite(&damping, width, 1e-9 * max_abs(&damping)), || {
        "it is not positive semi-definite: some motion gains energy".into()
    })?;
    let power: f64 = (0..width).map(|d| (moving[d / 3][d % 3] - still[d / 3][d % 3]) * body.v[d / 3][d % 3]).sum();
    ensure(power < 0.0, || format!("a moving body gains {power:.3e} W"))?;
    Ok(())
}
