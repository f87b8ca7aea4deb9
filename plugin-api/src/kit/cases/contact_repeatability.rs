//! Cases for repeatability of contact laws: results do not depend on ranges, earlier calls, other instances or threads, and need no allocation.

use super::super::candidate::Candidate;
use super::super::contact_law::{STATES, TestContactLaw};
use super::super::random::Random;
use super::contact_law::{history_of, random_point, with_law};
use super::{CaseResult, UNCOUNTED, describe_fault, ensure, skipped};
use crate::abi;
use crate::contact_law::ContactPoint;
use crate::fault::Fault;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Number of points of a state.
const POINTS: usize = 48;

/// Points in contact under a law.
struct ContactState {
    points: Vec<ContactPoint>,
    /// Histories of the points, one after the other.
    histories: Vec<f64>,
}

/// Random states of points and their histories.
fn state(law: &TestContactLaw, seed: u64) -> Result<ContactState, String> {
    let mut random = Random(seed);
    let points: Vec<ContactPoint> = (0..POINTS).map(|_| random_point(&mut random)).collect();
    let histories = points.iter().map(|p| history_of(law, *p, 2)).collect::<Result<Vec<_>, _>>()?;
    Ok(ContactState { points, histories: histories.concat() })
}

/// Bits of all results in a state, computed in calls of at most `max_points` points.
fn result_bits(law: &TestContactLaw, state: &ContactState, max_points: usize) -> Result<Vec<u64>, Fault> {
    let ContactState { points, histories } = state;
    let mut bits = Vec::new();
    for t in law.tractions(points, histories, max_points)? {
        let matrices = t.tangential_by_slip.iter().chain(&t.tangential_by_slip_rate).flatten();
        let scalars = [t.normal, t.normal_by_gap, t.normal_by_gap_rate];
        bits.extend(scalars.iter().chain(&t.tangential).chain(matrices).map(|x| x.to_bits()));
    }
    let mut next = histories.clone();
    law.advance(points, &mut next, max_points)?;
    bits.extend(next.iter().map(|x| x.to_bits()));
    Ok(bits)
}

pub(super) fn arrays_are_kept_to(c: &Candidate) -> CaseResult {
    with_law(c, |mut law| {
        let state = state(&law, 3)?;
        let bits = |law: &TestContactLaw| result_bits(law, &state, 7).map_err(describe_fault);
        let plain = bits(&law)?;
        if let Some(write) = law.guards.first_write() {
            return Err(write.into());
        }
        if bits(&law)? != plain {
            return Err(skipped("results differ from call to call: see `results-are-deterministic`"));
        }
        for (array, number) in STATES.iter().flat_map(|array| [1e3, f64::NAN].map(|number| (array, number))) {
            law.guards.change(array, number);
            ensure(bits(&law)? == plain, || {
                format!("results depend on what lies around `{array}`: {number} there changes them")
            })?;
        }
        Ok(())
    })
}

pub(super) fn calls_are_bit_identical(c: &Candidate) -> CaseResult {
    with_law(c, |law| {
        let state = state(&law, 3)?;
        let one_call = result_bits(&law, &state, usize::MAX).map_err(describe_fault)?;
        for max_points in [1, 3, 7, 16, 29] {
            let several = result_bits(&law, &state, max_points).map_err(describe_fault)?;
            ensure(several == one_call, || format!("calls of {max_points} points give other bytes than one call"))?;
        }
        Ok(())
    })
}

pub(super) fn state_is_bit_identical(c: &Candidate) -> CaseResult {
    if c.descriptor().flags & abi::FLAG_DETERMINISTIC == 0 {
        return Err(skipped("it does not declare itself deterministic"));
    }
    with_law(c, |law| {
        let here = state(&law, 3)?;
        let mut other = state(&law, 5)?;
        // Deeper than the other cases go.
        other.points.iter_mut().for_each(|point| point.gap *= 50.0);
        let bits = |law: &TestContactLaw, state| result_bits(law, state, usize::MAX).map_err(describe_fault);
        let first = bits(&law, &here)?;
        let same = |when: &str| -> Result<(), String> {
            ensure(bits(&law, &here)? == first, || format!("a state gave other bytes after {when}"))
        };
        ensure(bits(&law, &other)? != first, || "two states gave the same bytes".into())?;
        same("another state was computed")?;
        for (index, p) in c.params().iter().enumerate().filter(|(_, p)| p.kind == abi::PARAM_NUMBER) {
            let value = if p.fallback == p.max { p.min } else { 0.5 * (p.fallback + p.max) };
            let Ok(Ok(second)) = c.open(&[(index, value)]).map(TestContactLaw::new) else { continue };
            let _ = bits(&second, &here);
            same(&format!("a second instance with `{}` = {value} was called", Candidate::key(p)))?;
        }
        Ok(())
    })
}

/// Two threads compute two states at the same time, over and over: each until both have done so often enough, for one that waits for a processor
/// would meet no other.
pub(super) fn threads_are_bit_identical(c: &Candidate) -> CaseResult {
    const ROUNDS: usize = 100;
    const MOST_ROUNDS: usize = 100 * ROUNDS;
    with_law(c, |law| {
        let states = [state(&law, 3)?, state(&law, 5)?];
        let alone = |own: usize| result_bits(&law, &states[own], usize::MAX).map_err(describe_fault);
        let expected = [alone(0)?, alone(1)?];
        let done = [const { AtomicUsize::new(0) }; 2];
        let again = |own: usize| {
            let is_due = |round: &usize| *round < ROUNDS || done[1 - own].load(Ordering::Relaxed) < ROUNDS;
            let all = (0..MOST_ROUNDS).take_while(is_due).try_for_each(|_| {
                let found = alone(own)?;
                done[own].fetch_add(1, Ordering::Relaxed);
                let is_same = found == expected[own];
                ensure(is_same, || "a state gave other bytes while another thread computed another state".into())
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
    })
}

pub(super) fn no_allocation(c: &Candidate) -> CaseResult {
    let allocations = c.allocation_count().ok_or_else(|| skipped(UNCOUNTED))?;
    with_law(c, |law| {
        let state = state(&law, 3)?;
        let count = |points: usize| -> Result<u64, String> {
            let (points, histories) = (&state.points[..points], &state.histories[..points * law.history_stride()]);
            let before = allocations();
            let (traction, mut next) = (law.tractions(points, histories, usize::MAX), histories.to_vec());
            traction.and_then(|_| law.advance(points, &mut next, usize::MAX)).map_err(describe_fault)?;
            Ok(allocations() - before)
        };
        count(1)?; // the first call may initialise lazily
        // The kit itself allocates as often for one point as for many: the difference is the plugin's.
        let more = count(POINTS)?.saturating_sub(count(1)?);
        ensure(more == 0, || {
            format!("`tractions` and `advance` allocated {more} times more for {POINTS} points than for one")
        })?;
        Ok(())
    })
}
