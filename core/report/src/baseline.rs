//! Two reports side by side: what got worse.

use super::Row;
use std::collections::HashMap;

/// Something that got worse by more than the margin.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Regression {
    /// Which row.
    pub row: String,
    /// What of it.
    pub what: &'static str,
    /// Before.
    pub before: f64,
    /// Now.
    pub now: f64,
}

/// Errors below this are rounding on any machine.
const ROUNDING: f64 = 1e-9;
/// s, below it a duration is noise
const NOISE: f64 = 1e-5;

/// What got worse since `before`: an error or a step's median by more than `margin` (0.1 is ten per cent), a verdict, or a
/// state that was no growing one and is now. Durations count only where a step was timed (`step_seconds_median`). Rows that
/// one of the two does not have are not compared; gives how many were.
pub fn compare(before: &[Row], now: &[Row], margin: f64) -> (usize, Vec<Regression>) {
    let old: HashMap<String, &Row> = before.iter().map(|r| (r.key(), r)).collect();
    let (mut compared, mut worse) = (0, Vec::new());
    for row in now {
        let key = row.key();
        let Some(was) = old.get(&key) else { continue };
        compared += 1;
        let mut add = |what, before, now| worse.push(Regression { row: key.clone(), what, before, now });
        let lost = |r: &Row| r.error.unwrap_or(f64::INFINITY);
        if (was.error.is_some() || row.error.is_some()) && lost(row) > (lost(was) * (1.0 + margin)).max(ROUNDING) {
            add("error", lost(was), lost(row));
        }
        if was.passed == Some(true) && row.passed == Some(false) {
            add("verdict", 1.0, 0.0);
        }
        if was.state != "growing" && row.state == "growing" {
            add("stability", 0.0, 1.0);
        }
        if let (Some(was), Some(now)) = (was.step_seconds_median, row.step_seconds_median)
            && now > was * (1.0 + margin) + NOISE
        {
            add("step_seconds_median", was, now);
        }
    }
    (compared, worse)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_got_worse_beyond_the_margin_is_a_regression() {
        let row = |error, seconds, state: &str| Row {
            case: "c".into(),
            error: Some(error),
            passed: Some(error < 1e-2),
            step_seconds_median: Some(seconds),
            state: state.into(),
            ..Row::default()
        };
        let what = |now: Row| {
            let (compared, worse) = compare(&[row(1e-3, 1e-3, "stable")], &[now], 0.1);
            assert_eq!(compared, 1);
            worse.iter().map(|r| r.what).collect::<Vec<_>>()
        };
        assert!(what(row(1.05e-3, 1.05e-3, "stable")).is_empty());
        assert!(what(row(1e-4, 1e-4, "damped")).is_empty());
        assert_eq!(what(row(1.2e-3, 1e-3, "stable")), ["error"]);
        assert_eq!(what(row(2e-2, 1e-3, "stable")), ["error", "verdict"]);
        assert_eq!(what(row(1e-3, 2e-3, "stable")), ["step_seconds_median"]);
        assert_eq!(what(row(1e-3, 1e-3, "growing")), ["stability"]);
        assert_eq!(what(Row { error: None, ..row(1e-3, 1e-3, "stable") }), ["error"]);
        let other = Row { case: "d".into(), ..row(1.0, 1.0, "growing") };
        assert_eq!(compare(&[row(1e-3, 1e-3, "")], &[other], 0.1), (0, vec![]));
    }
}
