//! Cases for repeatability: results do not depend on ranges, earlier calls or other instances, and need no allocation.

use super::super::body::Body;
use super::super::candidate::Candidate;
use super::super::instance::TestInstance;
use super::material::{default_body, deform, set_moving, test_body};
use super::{CaseResult, UNCOUNTED, describe_fault, ensure, skipped, tested};
use crate::abi;
use crate::fault::Fault;
use crate::material::TangentScale;
use std::sync::atomic::{AtomicUsize, Ordering};

const BOTH: TangentScale = TangentScale { stiffness: 1.0, damping: 0.5 };

/// Bits of all per-node and per-element results in a state, computed in calls of at most `max_elements` elements. The energy is a
/// sum over elements, so it depends on the calls and is left out.
pub(super) fn result_bits(material: &TestInstance, body: &Body, max_elements: usize) -> Result<Vec<u64>, Fault> {
    let mut force = vec![[0.0; 3]; body.x.len()];
    body.add_forces_in_calls(material, max_elements, &mut force)?;
    let blocks = body.blocks(material, BOTH, max_elements)?;
    let single = body.single_blocks(material, BOTH, max_elements)?;
    let mut normals_forces = vec![[0.0; 6]; body.x.len()];
    if let Some(normals) = normals(material, body)? {
        body.add_normals_forces_in_calls(material, max_elements, &normals, &mut normals_forces)?;
    }
    let double = force.iter().flatten().chain(blocks.iter().flatten().flatten()).chain(normals_forces.iter().flatten());
    let histories = body.next_histories(material, max_elements)?;
    let double = double.chain(histories.iter().flatten()).map(|v| v.to_bits());
    Ok(double.chain(single.iter().flatten().flatten().map(|v| u64::from(v.to_bits()))).collect())
}

/// Unit normals of the body, if the material wants them.
fn normals(material: &TestInstance, body: &Body) -> Result<Option<Vec<[f64; 3]>>, Fault> {
    if !body.has(abi::WANTS_NORMALS) {
        return Ok(None);
    }
    Ok(Some(body.normals(&body.tilts(material)?.corners)))
}

/// An instance with its defaults, and a deformed, moving body.
fn moving_body(c: &Candidate) -> Result<(TestInstance, Body), String> {
    let (material, mut body) = default_body(c)?;
    deform(&mut body, 1.05, 0.05);
    set_moving(&mut body);
    Ok((material, body))
}

pub(super) fn calls_are_bit_identical(c: &Candidate) -> CaseResult {
    let (material, body) = moving_body(c)?;
    let one_call = result_bits(&material, &body, usize::MAX).map_err(describe_fault)?;
    for max_elements in [1, 3, 7, 16, 29] {
        let several = result_bits(&material, &body, max_elements).map_err(describe_fault)?;
        ensure(several == one_call, || format!("calls of {max_elements} elements give other bytes than one call"))?;
    }
    Ok(())
}

pub(super) fn state_is_bit_identical(c: &Candidate) -> CaseResult {
    if c.descriptor().flags & abi::FLAG_DETERMINISTIC == 0 {
        return Err(skipped("it does not declare itself deterministic"));
    }
    let (material, body) = moving_body(c)?;
    let first = result_bits(&material, &body, usize::MAX).map_err(describe_fault)?;
    let mut other = body.clone();
    deform(&mut other, 0.9, 0.2);
    for _ in 0..3 {
        let between = result_bits(&material, &other, usize::MAX).map_err(describe_fault)?;
        ensure(between != first, || "two states gave the same bytes".into())?;
        let again = result_bits(&material, &body, usize::MAX).map_err(describe_fault)?;
        ensure(again == first, || "a state gave other bytes after another state was computed".into())?;
    }
    Ok(())
}

pub(super) fn instances_are_independent(c: &Candidate) -> CaseResult {
    let (material, body) = moving_body(c)?;
    let first = result_bits(&material, &body, usize::MAX).map_err(describe_fault)?;
    let mut tried = 0;
    for (index, p) in c.params().iter().enumerate().filter(|(_, p)| p.kind == abi::PARAM_NUMBER) {
        let value = if p.fallback == p.max { p.min } else { 0.5 * (p.fallback + p.max) };
        let Ok(other) = c.open(&[(index, value)]) else { continue };
        if let Ok(mut other_body) = test_body(&other) {
            other_body.x.clone_from(&body.x);
            let _ = result_bits(&other, &other_body, usize::MAX);
        }
        tried += 1;
        let again = result_bits(&material, &body, usize::MAX).map_err(describe_fault)?;
        ensure(again == first, || {
            format!("a second instance with `{}` = {value} changed the results", Candidate::key(p))
        })?;
    }
    tested(tried, "it has no number that a second instance takes")
}

/// An instance that several threads call at the same time.
struct Called<'a>(&'a TestInstance);

// SAFETY: the interface lets a host call the functions of an instance that are made here from several threads at the same time
// (`[simulation threads]` of `pliant.h`), and the lock of the instance's last error is one for threads.
#[allow(unsafe_code, reason = "the instance is a pointer of C")]
unsafe impl Sync for Called<'_> {}

/// Two threads compute two states at the same time with one instance, or, where the host makes one call of an instance at a time, each with its own; over and over: each until both have done so often enough, for one that waits for a processor
/// would meet no other.
pub(super) fn threads_are_bit_identical(c: &Candidate) -> CaseResult {
    const ROUNDS: usize = 50;
    const MOST_ROUNDS: usize = 20 * ROUNDS;
    let (material, body) = moving_body(c)?;
    let mut other = body.clone();
    deform(&mut other, 0.9, 0.2);
    let second = match c.descriptor().flags & abi::FLAG_WHOLE_LISTS {
        0 => None,
        _ => Some(c.open(&[]).map_err(describe_fault)?),
    };
    let called = [Called(&material), Called(second.as_ref().unwrap_or(&material))];
    let bodies = [&body, &other];
    let alone = |own: usize| result_bits(called[own].0, bodies[own], usize::MAX).map_err(describe_fault);
    let expected = [alone(0)?, alone(1)?];
    if [alone(0)?, alone(1)?] != expected {
        return Err(skipped("results differ without threads too: see `results-are-deterministic`"));
    }
    let often = |own: usize| Often::of(called[own].0, bodies[own]).map_err(describe_fault);
    let expected_often = [often(0)?, often(1)?];
    let done = [const { AtomicUsize::new(0) }; 2];
    let again = |own: usize| {
        let Called(called) = &called[own];
        let is_due = |round: &usize| *round < ROUNDS || done[1 - own].load(Ordering::Relaxed) < ROUNDS;
        let all = (0..MOST_ROUNDS).take_while(is_due).try_for_each(|_| -> Result<(), String> {
            let differs =
                |what: &str| format!("{what} of a state had other bytes while another thread computed another state");
            let found = result_bits(called, bodies[own], usize::MAX).map_err(describe_fault)?;
            ensure(found == expected[own], || differs("results"))?;
            call_often(called, bodies[own], &expected_often[own], &differs)?;
            done[own].fetch_add(1, Ordering::Relaxed);
            Ok(())
        });
        done[own].store(ROUNDS, Ordering::Relaxed);
        all
    };
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().spawn_scoped(scope, || again(1));
        let thread = thread.map_err(|e| format!("a second thread cannot be started: {e}"))?;
        let here = again(0);
        let there = thread.join().map_err(|_| "a thread panicked".to_owned())?;
        here.and(there)
    })?;
    Ok(())
}

/// Results of the functions that are called again and again.
struct Often {
    /// J
    energy: f64,
    /// N (n x 3)
    force: Vec<[f64; 3]>,
}

impl Often {
    /// The results in a state.
    fn of(material: &TestInstance, body: &Body) -> Result<Self, Fault> {
        Ok(Self { energy: body.energy(material)?, force: body.forces(material)? })
    }
}

/// Calls `energy` and `forces` many times with next to nothing between two calls, so that threads are mostly inside of them. `differs` is the sentence for what is not as
/// expected.
fn call_often(
    material: &TestInstance,
    body: &Body,
    expected: &Often,
    differs: &dyn Fn(&str) -> String,
) -> Result<(), String> {
    const CALLS: usize = 40;
    let mut force = vec![[0.0; 3]; body.x.len()];
    for _ in 0..CALLS {
        force.fill([0.0; 3]);
        body.add_forces(material, &mut force).map_err(describe_fault)?;
        let same = force.iter().flatten().zip(expected.force.iter().flatten()).all(|(a, b)| a.to_bits() == b.to_bits());
        ensure(same, || differs("forces"))?;
        let energy = body.energy(material).map_err(describe_fault)?;
        ensure(energy.to_bits() == expected.energy.to_bits(), || differs("the energy"))?;
    }
    Ok(())
}

pub(super) fn no_allocation(c: &Candidate) -> CaseResult {
    let allocations = c.allocation_count().ok_or_else(|| skipped(UNCOUNTED))?;
    let (material, body) = moving_body(c)?;
    let mut force = vec![[0.0; 3]; body.x.len()];
    let mut add_forces = || body.add_forces(&material, &mut force);
    add_forces().map_err(describe_fault)?; // the first call may initialise lazily
    ensure_none("forces", count(allocations, add_forces)?)?;
    body.energy(&material).map_err(describe_fault)?;
    ensure_none("energy", count(allocations, || body.energy(&material))?)?;
    if let Some(normals) = normals(&material, &body).map_err(describe_fault)? {
        let mut out = vec![[0.0; 6]; body.x.len()];
        let calls = || {
            body.add_normals_forces_in_calls(&material, usize::MAX, &normals, &mut out)?;
            body.normals_energy(&material, &normals)
        };
        ensure_none("normals_energy and normals_forces", count(allocations, calls)?)?;
    }
    let advance = |max_elements: usize| count(allocations, || body.next_histories(&material, max_elements));
    ensure_none("advance", advance(1)?.saturating_sub(advance(usize::MAX)?))?;
    // The kit itself allocates the blocks, the same number of times for one call as for many: the difference is the plugin's.
    let tangent = |max_elements: usize| count(allocations, || body.blocks(&material, BOTH, max_elements));
    ensure_none("tangent", tangent(1)?.saturating_sub(tangent(usize::MAX)?))?;
    let single = |max_elements: usize| count(allocations, || body.single_blocks(&material, BOTH, max_elements));
    ensure_none("single_tangent", single(1)?.saturating_sub(single(usize::MAX)?))?;
    Ok(())
}

/// Allocations while `run` runs, by the count `allocations`.
fn count<T>(allocations: fn() -> u64, run: impl FnOnce() -> Result<T, Fault>) -> Result<u64, String> {
    let before = allocations();
    run().map_err(describe_fault)?;
    Ok(allocations() - before)
}

fn ensure_none(function: &str, count: u64) -> Result<(), String> {
    ensure(count == 0, || format!("`{function}` allocated {count} times"))
}
