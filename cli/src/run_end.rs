//! What `run`, `run --live` and `replay` have in common: telling how it went.

use crate::outcome::{Failure, Outcome};
use crate::output::{count, format_seconds, note, print_json};
use pliant_engine::session::{EventKind, Warning};
use pliant_live::{LiveSummary, Percentiles};
use pliant_record::{CutSummary, ProbeResult, Summary};
use std::path::Path;

/// Number of events that are printed in full.
const EVENTS_PRINTED: usize = 6;

/// The outcome of a run whose results are written.
pub fn run_outcome(summary: &Summary) -> Outcome {
    match summary {
        s if s.interrupted => Outcome::Stopped,
        s if s.plugin_failed() => Outcome::Plugin,
        s if !s.passed() => Outcome::CheckFailed,
        _ => Outcome::Done,
    }
}

/// The outcome of a run if warnings are errors (`strict`). A stopped run or a failed plugin keeps its outcome.
pub fn strict_outcome(outcome: Outcome, summary: &Summary, strict: bool) -> Outcome {
    match outcome {
        Outcome::Done | Outcome::CheckFailed if strict && !summary.warnings.is_empty() => Outcome::Input,
        Outcome::Done | Outcome::CheckFailed | Outcome::Input | Outcome::Plugin | Outcome::Stopped => outcome,
    }
}

/// The failure of a scene whose warnings are errors.
pub fn strict_failure(warnings: &[Warning]) -> Failure {
    let lines: Vec<String> = warnings.iter().map(Warning::to_string).collect();
    Failure::input(format!("{} (`--strict`):\n{}", count(warnings.len() as u64, "warning"), lines.join("\n")))
}

/// Prints the summary of a run whose results are in `folder`: as JSON if asked for, else for people. If `quiet`, people read only what makes the
/// exit code another than 0.
pub fn print_summary(summary: &Summary, folder: &Path, json: bool, quiet: bool) -> Result<(), Failure> {
    if json {
        print_json(summary)?;
    } else if quiet {
        note_failures(summary);
    } else {
        note_summary(summary, folder);
    }
    Ok(())
}

/// Prints the checks that failed, why bodies were frozen, and how often a device was lost.
fn note_failures(summary: &Summary) {
    summary.probes.iter().filter(|probe| probe.passed == Some(false)).for_each(note_probe);
    for body in &summary.bodies {
        if let Some(reason) = &body.frozen {
            note(&format!("body {} was frozen: {reason}", body.name));
        }
    }
    if let Some(number) = summary.event_counts.get(&EventKind::DeviceLost) {
        note_event_count(&EventKind::DeviceLost, *number);
    }
}

/// Prints the summary for people.
fn note_summary(summary: &Summary, folder: &Path) {
    let choices = &summary.choices;
    let substeps = match choices.substeps {
        1 => String::new(),
        more => format!(" with {more} substeps"),
    };
    note(&format!(
        "{} of {} with {}{substeps}, at most {} and {} active",
        count(summary.steps, "step"),
        format_seconds(summary.dt),
        choices.integrator,
        count(summary.most_nodes as u64, "node"),
        count(summary.most_elements as u64, "element"),
    ));
    if let Some(s) = &summary.step_seconds {
        let [p50, p99, max, all] = [s.p50, s.p99, s.max, summary.wall_seconds].map(format_seconds);
        note(&format!("median step time {p50} (99 % within {p99}, longest {max}); whole run {all}"));
    }
    if let Some(cut) = &summary.cut {
        let (CutSummary { advances, area, length, .. }, seconds) = (cut, &cut.seconds);
        let [p50, max] = [seconds.p50, seconds.max].map(format_seconds);
        note(&format!(
            "cut: {area:.3e} m^2 of surface and {length:.3e} m of edge in {}, median {p50} (longest {max})",
            count(*advances as u64, "advance")
        ));
    }
    if let Some(live) = &summary.live {
        note_live(live);
    }
    let contact = format_seconds(summary.contact_steps as f64 * summary.dt);
    note(&format!("in contact for {contact}, largest force {:.4} N", summary.largest_force));
    summary.probes.iter().for_each(note_probe);
    summary.event_counts.iter().for_each(|(kind, number)| note_event_count(kind, *number));
    for event in summary.events.iter().take(EVENTS_PRINTED) {
        note(&format!("  at {:.4} s: {}", event.time, event.text));
    }
    if summary.events.len() > EVENTS_PRINTED {
        note("  the others are in summary.json");
    }
    if let Some(growth) = summary.growth {
        note(&format!("the energy grew by a factor of {growth:.4} a step"));
    }
    let folder = if summary.interrupted { folder.join("interrupted") } else { folder.to_path_buf() };
    let state = if summary.interrupted { "stopped; results so far are in" } else { "results are in" };
    note(&format!("{state} {}", folder.display()));
}

/// Prints how often there was an event of a kind.
fn note_event_count(kind: &EventKind, number: u64) {
    let kind = serde_json::to_string(kind).unwrap_or_default();
    note(&format!("event {}: {}", kind.trim_matches('"'), count(number, "time")));
}

/// Prints the result of a probe for people.
fn note_probe(probe: &ProbeResult) {
    let verdict = match (probe.expected, probe.error, probe.passed) {
        (Some(expected), Some(error), Some(passed)) => {
            let word = if passed { "ok" } else { "FAILED" };
            let tolerance = probe.tolerance.unwrap_or_default();
            format!(", expected {expected:.6e}: error {error:.2e}, allowed {tolerance:.0e}: {word}")
        }
        _ => String::new(),
    };
    note(&format!("probe {}: {:.6e} at {:.4} s{verdict}", probe.name, probe.value, probe.time));
}

/// Prints timing and force safety of a live run for people.
fn note_live(live: &LiveSummary) {
    note(&format!(
        "live for {}: {} at {} Hz, {} missed; priority {}",
        format_seconds(live.seconds),
        count(live.ticks, "tick"),
        live.rate,
        live.missed,
        live.realtime.priority
    ));
    note(&format!("  timer {}; memory {}", live.realtime.timer, live.realtime.memory));
    if let Some(usage) = live.thread_usage {
        let [running, waiting, steal] = [usage.running, usage.waiting, usage.steal_time].map(format_seconds);
        note(&format!(
            "  the haptic thread ran for {running}, was ready without a processor for {waiting}, was preempted {}, had {}; {steal} of \
             all processors went to other virtual machines",
            count(usage.preemptions, "time"),
            count(usage.page_faults, "page fault"),
        ));
    }
    note_percentiles("  period", live.period);
    note_percentiles("  lateness", live.lateness);
    note_percentiles("  device to force", live.latency);
    note_percentiles("  age of contacts", live.contact_age);
    let (factor, lost) = (100.0 * live.real_time_factor, format_seconds(live.lost_time));
    note(&format!("the simulation kept {factor:.1} % of real time and fell {lost} behind"));
    if live.watchdog_trips > 0 {
        note(&format!("the watchdog stopped the devices {}", count(live.watchdog_trips, "time")));
    }
    for hand in &live.hands {
        for (cause, number) in hand.safety_counts.iter().filter(|(_, number)| **number > 0) {
            note(&format!("hand of tool `{}`: {cause}, {}", hand.tool, count(*number, "time")));
        }
        if hand.dropped_samples + hand.speed_limited_samples > 0 {
            note(&format!(
                "hand of tool `{}`: {} dropped, {} followed at the speed limit",
                hand.tool,
                count(hand.dropped_samples, "sample"),
                hand.speed_limited_samples
            ));
        }
    }
}

/// Prints percentiles of a time for people, if there are any.
fn note_percentiles(what: &str, percentiles: Option<Percentiles>) {
    if let Some(p) = percentiles {
        let [p50, p99, p999, max] = [p.p50, p.p99, p.p999, p.max].map(format_seconds);
        note(&format!("{what}: median {p50} (99 % within {p99}, 99.9 % within {p999}, longest {max})"));
    }
}
