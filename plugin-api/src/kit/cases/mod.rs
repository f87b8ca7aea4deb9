//! The conformance suite: each case tests one promise of the interface and reports one sentence.

mod common;
mod contact_law;
mod contact_repeatability;
mod coupled;
mod derivatives;
mod device;
mod directions;
mod far_from_rest;
mod fields;
mod grid;
mod history;
mod invariance;
mod material;
mod matrix;
mod normals;
mod repeatability;
mod single;

use super::candidate::{Candidate, Kind};
use crate::fault::Fault;
use crate::instance::Role;

/// Result of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The plugin keeps the promise.
    Passed,
    /// The promise cannot be tested here; says why.
    Skipped(String),
    /// The plugin breaks the promise; says where and by how much.
    Failed(String),
}

/// One promise of the interface, and its test.
#[derive(Clone, Copy)]
pub struct Case {
    /// Name in kebab-case, for `pliant plugin check --case`.
    pub name: &'static str,
    /// The promise, as a sentence.
    pub promise: &'static str,
    run: fn(&Candidate) -> Result<Verdict, String>,
}

impl Case {
    /// Tests a plugin.
    pub fn run(&self, candidate: &Candidate) -> Verdict {
        (self.run)(candidate).unwrap_or_else(Verdict::Failed)
    }
}

/// The cases for plugins of a kind: those for every plugin, then those of the kind.
pub fn cases(kind: Kind) -> Vec<Case> {
    let own = match kind {
        Kind::Material => material::CASES,
        Kind::Grid => grid::CASES,
        Kind::Device => device::CASES,
        Kind::ContactLaw => contact_law::CASES,
    };
    common::CASES.iter().chain(own).copied().collect()
}

/// Runs every case on a plugin that is linked in: `kit::check::<AsMaterial<Spring>>()` in a test.
///
/// # Panics
/// If a case fails, with a sentence for each.
pub fn check<R: Role>() {
    let candidate = Candidate::of::<R>();
    let kind = candidate.kind().expect("a kind of this version");
    let failed: Vec<String> = cases(kind)
        .iter()
        .filter_map(|case| match case.run(&candidate) {
            Verdict::Failed(why) => Some(format!("{}: {}: {why}", case.name, case.promise)),
            Verdict::Passed | Verdict::Skipped(_) => None,
        })
        .collect();
    assert!(failed.is_empty(), "\n{}\n", failed.join("\n"));
}

/// A fault as a sentence.
fn describe_fault(fault: Fault) -> String {
    if fault.reason.is_empty() { fault.status.meaning().into() } else { fault.to_string() }
}

/// Fails the case with a sentence unless `holds`.
fn ensure(holds: bool, why: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(why()) }
}
