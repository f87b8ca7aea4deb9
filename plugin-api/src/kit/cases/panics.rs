//! The case for panics: a call in a state no simulation should reach ends with a status.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::material::{default_body, deform, set_moving};
use super::{CaseResult, describe_fault, ensure};
use crate::abi::{self, Status};
use crate::fault::Fault;
use crate::material::TangentScale;

/// Extreme states: name, what positions are multiplied by, jitter in cell edges, and what velocities of up to 1 m/s are multiplied by.
const STATES: [(&str, f64, f64, f64); 6] = [
    ("drawn out to a hundred times its size", 100.0, 5.0, 1.0),
    ("drawn out to 1e12 times its size", 1e12, 1e9, 1.0),
    ("collapsed into a point", 0.0, 0.0, 1.0),
    ("with velocities of 1e12 m/s", 1.05, 0.05, 1e12),
    ("at positions that are not a number", f64::NAN, 0.0, 1.0),
    ("at infinite positions", f64::INFINITY, 0.0, 1.0),
];

/// A call by the name of its function, and its result.
type Called = (&'static str, Result<(), Fault>);

/// Runs every function of a step on a body.
fn call_all(material: &TestInstance, body: &Body) -> Vec<Called> {
    let both = TangentScale { stiffness: 1.0, damping: 0.5 };
    let mut called = vec![
        ("forces", body.forces(material).map(drop)),
        ("energy", body.energy(material).map(drop)),
        ("tangent", body.blocks(material, both, usize::MAX).map(drop)),
        ("single_tangent", body.single_blocks(material, both, usize::MAX).map(drop)),
        ("advance", body.next_histories(material, usize::MAX).map(drop)),
    ];
    if body.has(abi::CAN_FAIL) {
        let mut next = body.clone();
        // What `advance` says is above.
        let _ = next.advance(material);
        called.push(("failed", next.failed(material).map(drop)));
    }
    if body.has(abi::IS_COUPLED) {
        called.push(("strain", body.strains(material).map(drop)));
    }
    if body.has(abi::WANTS_NORMALS)
        && let Ok(tilts) = body.tilts(material)
    {
        let normals = body.normals(&tilts.corners);
        called.push(("energy of normals", body.normals_energy(material, &normals).map(drop)));
        called.push(("forces of normals", body.normals_forces(material, &normals).map(drop)));
    }
    called
}

/// No function of a step panics, whatever the state is.
pub(super) fn no_call_panics(c: &Candidate) -> CaseResult {
    for (state, stretch, jitter, speed) in STATES {
        let (material, mut body) = default_body(c)?;
        deform(&mut body, stretch, jitter);
        set_moving(&mut body);
        body.v.iter_mut().for_each(|v| *v = v.map(|c| speed * c));
        for (function, result) in call_all(&material, &body) {
            if let Err(fault) = result {
                let panicked = fault.status == Status::PANICKED;
                ensure(!panicked, || format!("`{function}` of a body {state}: {}", describe_fault(fault)))?;
            }
        }
    }
    Ok(())
}
