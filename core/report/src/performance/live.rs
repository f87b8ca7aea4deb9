//! The haptic loop by the wall clock: how late its ticks begin.

use super::catalogue::Haptic;
use crate::catalogue::settings;
use crate::{Row, Setup, Trial};
use pliant_live::{LiveSession, LiveSettings};
use std::path::Path;

/// Runs one scene live for a while.
pub(super) fn live(haptic: &Haptic, scenes: crate::Scenes<'_>, setup: &Setup<'_>) -> Row {
    let mut row =
        Row { case: "haptic-loop".into(), method: haptic.name.clone(), threads: setup.threads, ..Row::default() };
    // Any failure is one of what was to be met.
    row.passed = Some(false);
    row.tolerance = Some(haptic.late);
    let Some(text) = scenes(&haptic.scene) else {
        row.note = format!("no scene `{}`", haptic.scene);
        return row;
    };
    let (search, set) = (&setup.search, settings([&haptic.set]));
    let path = Path::new(&haptic.scene);
    let trial = Trial { path, text, set, threads: setup.threads, search, clock: setup.clock };
    let mut session = match trial.open() {
        Ok((_, session)) => session,
        Err(error) => {
            row.note = error.to_string();
            return row;
        }
    };
    let mut live = match LiveSession::start(&mut session, LiveSettings { rate: Some(haptic.rate), viewer: None }) {
        Ok(live) => live,
        Err(error) => {
            row.note = error.to_string();
            return row;
        }
    };
    let seconds = if setup.quick { 2.0 } else { 20.0 };
    while live.is_alive() && live.seconds() < seconds && !(setup.stopped)() {
        live.step(&mut session);
    }
    let lived = live.finish();
    (row.dt, row.wall_seconds) = (1.0 / lived.rate, lived.seconds);
    for (what, spread) in [("late", lived.lateness), ("period", lived.period), ("device to force", lived.latency)] {
        let Some(s) = spread else { continue };
        for (share, value) in [("median", s.p50), ("p99", s.p99), ("p99.9", s.p999), ("most", s.max)] {
            row.found.insert(format!("{what}, {share} (s)"), value);
        }
    }
    row.found.insert("ticks".into(), lived.ticks as f64);
    row.found.insert("missed ticks".into(), lived.missed as f64);
    row.found.insert("share of real time kept".into(), lived.real_time_factor);
    row.error = lived.lateness.map(|s| s.p99);
    row.passed = Some(row.error.is_some_and(|e| e <= haptic.late) && !lived.panicked);
    row.note = format!("99 % of ticks begin within the error, in seconds; priority {}", lived.realtime.priority);
    row
}
