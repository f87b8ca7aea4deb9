//! The case that puts arrays next to guard pages: what a call touches there ends the process, whether it changes a result or not.

use super::super::body::{AtPage, INPUTS, OUTPUT, PLANES, Surroundings};
use super::super::candidate::Candidate;
use super::super::protected_memory::Edge;
use super::guards::{call_name, calls, moving_body};
use super::{CaseResult, skipped};

/// Each array of each call lies at a page once with its first value, and once with its last.
pub(super) fn are_left_alone(c: &Candidate) -> CaseResult {
    let memory = c.protected_memory().ok_or_else(|| {
        skipped("it needs a process that may crash: `pliant plugin check` runs it, on systems with protected memory")
    })?;
    let (material, body) = moving_body(c)?;
    let counts = body.set_counts();
    for (set, function) in calls(&body) {
        let middle = counts[set] / 3..counts[set].div_ceil(2);
        for range in [0..counts[set], middle].into_iter().filter(|range| !range.is_empty()) {
            for array in INPUTS.into_iter().chain(PLANES).chain([OUTPUT]) {
                for (edge, place) in [(Edge::First, "before its first value"), (Edge::Last, "behind its last value")] {
                    let name = call_name(&body, set, function, &range);
                    memory.announce(&format!("{name} touched `{array}` {place}"));
                    body.guarded_call(
                        &material,
                        set,
                        function,
                        range.clone(),
                        Surroundings::Page(AtPage { array, memory, edge }),
                    );
                }
            }
        }
    }
    Ok(())
}
