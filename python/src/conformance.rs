//! The conformance suite on a law written in Python.

use super::failure::contained;
use super::law::Law;
use super::law_material::LawMaterial;
use pliant_plugin_api::AsMaterial;
use pliant_plugin_api::kit::{Candidate, Kind, Verdict, cases};
use pyo3::prelude::*;

/// A case of the suite: its name, what it promises, `passed`, `failed` or `skipped`, and why.
type CaseRow = (&'static str, &'static str, &'static str, String);

/// Runs every case of the suite for materials on a law.
#[pyfunction]
pub fn check_law(py: Python<'_>, law: &Bound<'_, Law>) -> PyResult<Vec<CaseRow>> {
    let law = law.get();
    let run = || {
        let candidate = Candidate::of::<AsMaterial<LawMaterial>>();
        let row = |case: &pliant_plugin_api::kit::Case| {
            let (verdict, why) = match case.run(&candidate) {
                Verdict::Passed => ("passed", String::new()),
                Verdict::Skipped(why) => ("skipped", why),
                Verdict::Failed(why) => ("failed", why),
            };
            (case.name, case.promise, verdict, why)
        };
        Ok(cases(Kind::Material).iter().map(row).collect())
    };
    Ok(py.detach(|| contained(|| law.under_test(run)))?)
}
