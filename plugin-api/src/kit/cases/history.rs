//! Cases for what an update of the history must keep: plasticity and friction take energy away, and do not know where a body is.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::super::tested_material::MaterialUnderTest;
use super::invariance::rigid_motion;
use super::material::{deform, test_body};
use super::{CaseResult, describe_fault, ensure, tested};
use crate::abi;

/// Parts of the range of a number at which a material is tested, besides its default: one that yields only beyond a strain does so at the
/// least of them.
const PARTS: [f64; 4] = [0.0, 0.01, 0.1, 1.0];
/// Stretches of the test body, one after the other, and jitter in cell edges: loading, more of it, and back beyond rest.
const STATES: [(f64, f64); 4] = [(1.03, 0.03), (1.2, 0.2), (0.9, 0.1), (1.0, 0.15)];
/// Energy that counts as none, over that of the state: rounding in a sum over the elements.
const ROUNDING: f64 = 1e-9;

/// Instances with a history: with defaults, and with each parameter alone at other values.
fn instances(c: &Candidate) -> Result<Vec<TestInstance>, String> {
    let mut settings: Vec<Vec<(usize, f64)>> = vec![Vec::new()];
    for (index, p) in c.params().iter().enumerate() {
        match p.kind {
            abi::PARAM_NUMBER => settings.extend(PARTS.map(|part| vec![(index, p.min + part * (p.max - p.min))])),
            abi::PARAM_CHOICE => settings.extend((0..Candidate::choices(p).len()).map(|i| vec![(index, i as f64)])),
            _ => {}
        }
    }
    let mut found = Vec::new();
    for setting in settings {
        // A plugin may refuse a combination with the other defaults.
        let Ok(material) = c.open(&setting) else { continue };
        let requests = material.element_requests().map_err(describe_fault)?;
        if requests.iter().any(|r| r.flags & abi::HAS_HISTORY != 0) {
            found.push(material);
        }
    }
    Ok(found)
}

/// Energy of a body with its energy of normals, J.
fn energy(material: &TestInstance, body: &Body) -> Result<f64, String> {
    let normals = if body.has(abi::WANTS_NORMALS) {
        let normals = body.normals(&body.tilts(material).map_err(describe_fault)?.corners);
        body.normals_energy(material, &normals).map_err(describe_fault)?
    } else {
        0.0
    };
    Ok(normals + body.energy(material).map_err(describe_fault)?)
}

/// Whether two bodies have the history, to the bit.
fn have_same_history(a: &Body, b: &Body) -> bool {
    a.histories().eq(b.histories())
}

/// Runs `check` in every state of every instance with a history, with the body before and after its history was updated. Skipped where
/// no history ever changes.
fn for_each_state(c: &Candidate, check: impl Fn(&TestInstance, &Body, &Body) -> Result<(), String>) -> CaseResult {
    let mut changes = 0;
    for material in instances(c)? {
        let rest = test_body(&material)?;
        let mut body = rest.clone();
        for (stretch, jitter) in STATES {
            body.x.clone_from(&rest.x);
            deform(&mut body, stretch, jitter);
            let mut next = body.clone();
            next.advance(&material).map_err(describe_fault)?;
            check(&material, &body, &next)?;
            changes += usize::from(!have_same_history(&body, &next));
            body = next;
        }
    }
    tested(changes, "no parameter alone gives it a history that changes")
}

pub(super) fn advance_dissipates(c: &Candidate) -> CaseResult {
    for material in instances(c)? {
        let mut rest = test_body(&material)?;
        let before = rest.clone();
        rest.advance(&material).map_err(describe_fault)?;
        ensure(have_same_history(&before, &rest), || "a step at rest changed the history".into())?;
    }
    for_each_state(c, |material, body, next| {
        let (before, after) = (energy(material, body)?, energy(material, next)?);
        ensure(after <= before + ROUNDING * before.abs(), || {
            format!("at fixed positions the elastic energy grew from {before:.9e} J to {after:.9e} J")
        })
    })
}

/// Stretches of the test body under which elements may fail, one after the other, and jitter in cell edges.
const FAILING: [(f64, f64); 4] = [(1.1, 0.1), (1.5, 0.3), (3.0, 0.5), (1.0, 0.2)];

pub(super) fn failure_follows_from_history(c: &Candidate) -> CaseResult {
    let mut failures = 0;
    for material in instances(c)? {
        let rest = test_body(&material)?;
        if !rest.has(abi::CAN_FAIL) {
            continue;
        }
        let failed = |body: &Body| body.failed(&material).map_err(describe_fault);
        let mut body = rest.clone();
        for (stretch, jitter) in FAILING {
            body.x.clone_from(&rest.x);
            deform(&mut body, stretch, jitter);
            body.advance(&material).map_err(describe_fault)?;
            let expected = failed(&body)?;
            failures += expected.iter().flatten().filter(|failed| **failed != 0).count();
            ensure(expected.iter().flatten().all(|failed| *failed <= 1), || "a value other than 0 and 1".into())?;
            // As after an undo, which puts the history back first and positions later.
            let mut moved = body.clone();
            deform(&mut moved, 2.0, 0.9);
            moved.v.iter_mut().zip(&rest.x).for_each(|(v, x)| *v = x.map(|c| 1e3 * c - 5.0));
            let found = failed(&moved)?;
            ensure(found == expected, || {
                let count = |all: &[Vec<u8>]| all.iter().flatten().filter(|failed| **failed != 0).count();
                let (before, after) = (count(&expected), count(&found));
                format!("with the same history and other positions {after} elements have failed instead of {before}")
            })?;
        }
        let fresh = failed(&rest)?;
        ensure(fresh.iter().flatten().all(|failed| *failed == 0), || "an element without a history has failed".into())?;
        let mut moved = rest.clone();
        deform(&mut moved, 3.0, 0.5);
        let fresh = failed(&moved)?;
        ensure(fresh.iter().flatten().all(|failed| *failed == 0), || "an element without a history has failed".into())?;
    }
    tested(failures, "no element of it fails")
}

pub(super) fn advance_is_objective(c: &Candidate) -> CaseResult {
    for_each_state(c, |material, body, next| {
        let mut moved = body.clone();
        moved.x.iter_mut().for_each(|x| *x = rigid_motion(*x));
        moved.advance(material).map_err(describe_fault)?;
        // Back where the other is, so that the energies differ by their histories alone.
        moved.x.clone_from(&next.x);
        let (expected, found) = (energy(material, next)?, energy(material, &moved)?);
        let scale = energy(material, body)?.abs();
        ensure((expected - found).abs() <= 1e-7 * scale, || {
            format!("after a rigid motion the history leads to {found:.9e} J instead of {expected:.9e} J")
        })
    })
}
