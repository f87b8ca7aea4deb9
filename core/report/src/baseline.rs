//! Comparison of two reports: regressions.

use crate::row::Row;
use std::collections::HashMap;

/// A regression: a result that is worse by more than the margin.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Regression {
    /// Key of the row.
    pub row: String,
    /// The quantity: `error`, `verdict`, `stability` or `step_seconds_median`.
    pub what: &'static str,
    /// Value in the older report.
    pub before: f64,
    /// Value in the newer report.
    pub now: f64,
}

/// Errors below this are rounding.
const ROUNDING: f64 = 1e-9;
/// Differences of durations below this are noise, s.
const NOISE: f64 = 1e-5;

/// Result of a comparison with an older report.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Number of rows that both reports have.
    pub compared: usize,
    /// Figures that are worse than those of the baseline by more than the tolerance.
    pub regressions: Vec<Regression>,
}

/// Finds regressions since `before`: an error or median step time that is larger by more than `margin` (0.1 is 10 %), a row that fails its criterion and did not
/// before, or a state that is `growing` and was not before. Durations are compared only where steps were timed (`step_seconds_median`). Rows that only one of
/// the reports has are ignored.
pub fn compare(before: &[Row], now: &[Row], margin: f64) -> Comparison {
    let old: HashMap<String, &Row> = before.iter().map(|r| (r.key(), r)).collect();
    let (mut compared, mut regressions) = (0, Vec::new());
    for row in now {
        let key = row.key();
        let Some(was) = old.get(&key) else { continue };
        compared += 1;
        let mut add = |what, before, now| regressions.push(Regression { row: key.clone(), what, before, now });
        // A row that had an error value and has none now has failed to run.
        let error_of = |r: &Row| r.error.unwrap_or(f64::INFINITY);
        if (was.error.is_some() || row.error.is_some())
            && error_of(row) > (error_of(was) * (1.0 + margin)).max(ROUNDING)
        {
            add("error", error_of(was), error_of(row));
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
    Comparison { compared, regressions }
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
            let comparison = compare(&[row(1e-3, 1e-3, "stable")], &[now], 0.1);
            assert_eq!(comparison.compared, 1);
            comparison.regressions.iter().map(|r| r.what).collect::<Vec<_>>()
        };
        assert!(what(row(1.05e-3, 1.05e-3, "stable")).is_empty());
        assert!(what(row(1e-4, 1e-4, "damped")).is_empty());
        assert_eq!(what(row(1.2e-3, 1e-3, "stable")), ["error"]);
        assert_eq!(what(row(2e-2, 1e-3, "stable")), ["error", "verdict"]);
        assert_eq!(what(row(1e-3, 2e-3, "stable")), ["step_seconds_median"]);
        assert_eq!(what(row(1e-3, 1e-3, "growing")), ["stability"]);
        assert_eq!(what(Row { error: None, ..row(1e-3, 1e-3, "stable") }), ["error"]);
        let other = Row { case: "d".into(), ..row(1.0, 1.0, "growing") };
        let none = Comparison { compared: 0, regressions: vec![] };
        assert_eq!(compare(&[row(1e-3, 1e-3, "")], &[other], 0.1), none);
    }
}
