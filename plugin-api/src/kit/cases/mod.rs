//! The conformance suite: each case tests one promise of the interface and reports one sentence.

mod common;
mod contact_law;
mod contact_repeatability;
mod coupled;
mod damping;
mod derivatives;
mod device;
mod directions;
mod far_from_rest;
mod fields;
mod grid;
mod guards;
mod history;
mod invariance;
mod material;
mod matrix;
mod measure;
mod normals;
mod pages;
mod panics;
mod repeatability;
mod rest_shape;
mod single;
mod whole_lists;

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

/// Why a case does not pass. What a case needs of a plugin is had from functions that return this error, so that `?` skips the case
/// where the plugin does not have it.
enum NotPassed {
    /// See [`Verdict::Skipped`].
    Skipped(String),
    /// See [`Verdict::Failed`].
    Failed(String),
}

impl From<String> for NotPassed {
    fn from(why: String) -> Self {
        Self::Failed(why)
    }
}

/// Result of a case that has tested its promise: `Ok` is a pass.
type CaseResult = Result<(), NotPassed>;

/// The error of a case that cannot test its promise on this plugin.
fn skipped(why: impl Into<String>) -> NotPassed {
    NotPassed::Skipped(why.into())
}

/// Passes a case that has tested its promise `count` times; skips one that has not tested it at all.
fn tested(count: usize, why_not: &str) -> CaseResult {
    if count > 0 { Ok(()) } else { Err(skipped(why_not)) }
}

/// One promise of the interface, and its test.
#[derive(Clone, Copy)]
pub struct Case {
    /// Name in kebab-case, for `pliant plugin check --case`.
    pub name: &'static str,
    /// The promise, as a sentence.
    pub promise: &'static str,
    run: fn(&Candidate) -> CaseResult,
}

impl Case {
    /// Tests a plugin.
    pub fn run(&self, candidate: &Candidate) -> Verdict {
        match (self.run)(candidate) {
            Ok(()) => Verdict::Passed,
            Err(NotPassed::Skipped(why)) => Verdict::Skipped(why),
            Err(NotPassed::Failed(why)) => Verdict::Failed(why),
        }
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

/// Why no parameter was tested at the ends of its range.
const NO_EXTREMES: &str = "it has no number or choice that it takes alone";

/// Why allocations are not counted.
const UNCOUNTED: &str = "its allocations are not counted here; a Rust test with `kit::CountingAllocator` counts those of a plugin that \
     is linked in, and `make test` of a C or C++ project those of its library, on Linux with glibc";

/// A fault as a sentence.
fn describe_fault(fault: Fault) -> String {
    if fault.reason.is_empty() { fault.status.meaning().into() } else { fault.to_string() }
}

/// Fails the case with a sentence unless `holds`.
fn ensure(holds: bool, why: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(why()) }
}
