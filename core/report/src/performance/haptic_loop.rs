//! Lateness of the ticks of the haptic loop in real time.

use super::catalogue::HapticLoop;
use crate::context::ReportContext;
use crate::row::Row;
use crate::scene_run::{SceneRun, SceneSource};
use crate::settings::merge;
use pliant_live::{LiveSession, LiveSettings};
use std::path::Path;

/// Duration of a run, in full and in quick reports, s.
const SECONDS: (f64, f64) = (20.0, 2.0);

/// Runs a scene in real time. The row passes if 99 % of the ticks begin within the allowed lateness.
pub(super) fn haptic_loop(case: &HapticLoop, scenes: SceneSource<'_>, context: &ReportContext<'_>) -> Row {
    let threads = context.options.threads;
    let mut row = Row { case: "haptic-loop".into(), method: case.name.clone(), threads, ..Row::default() };
    row.tolerance = Some(case.allowed_lateness);
    let Some(text) = scenes(&case.scene) else { return row.with_failure(format!("no scene `{}`", case.scene)) };
    let (search, clock) = (&context.options.search, context.options.clock);
    let settings = merge([&case.settings]);
    let run = SceneRun { path: Path::new(&case.scene), text, settings, threads, search, clock, stop: context.stop() };
    let mut session = match run.open() {
        Ok((_, session)) => session,
        Err(error) => return row.with_failure(error.to_string()),
    };
    let mut live = match LiveSession::start(&mut session, LiveSettings { rate: Some(case.rate), view: None }) {
        Ok(live) => live,
        Err(error) => return row.with_failure(error.to_string()),
    };
    let seconds = if context.options.quick { SECONDS.1 } else { SECONDS.0 };
    while live.is_alive() && live.seconds() < seconds && !context.is_stopped() {
        live.step(&mut session);
    }
    let summary = live.finish();
    (row.dt, row.wall_seconds) = (1.0 / summary.rate, summary.seconds);
    let times = [("late", summary.lateness), ("period", summary.period), ("device to force", summary.latency)];
    for (what, percentiles) in times {
        let Some(p) = percentiles else { continue };
        for (share, value) in [("median", p.p50), ("p99", p.p99), ("p99.9", p.p999), ("most", p.max)] {
            row.results.insert(format!("{what}, {share} (s)"), value);
        }
    }
    row.results.insert("ticks".into(), summary.ticks as f64);
    row.results.insert("missed ticks".into(), summary.missed as f64);
    row.results.insert("share of real time kept".into(), summary.real_time_factor);
    row.error = summary.lateness.map(|p| p.p99);
    row.passed = Some(row.error.is_some_and(|e| e <= case.allowed_lateness) && !summary.panicked);
    row.note = format!("99 % of ticks begin within the error, in seconds; priority {}", summary.realtime.priority);
    row
}
