//! The conformance suite: one promise a case, one sentence a case.

mod border;
mod coupled;
mod derivatives;
mod device;
mod grid;
mod invariance;
mod linear;
mod material;
mod normals;
mod repeat;
mod single;

use super::candidate::{Candidate, Kind};
use crate::fault::Fault;
use crate::instance::Role;

/// How a case ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The promise holds.
    Passed,
    /// It cannot be looked at here, and why.
    Skipped(String),
    /// It does not hold, and where.
    Failed(String),
}

/// One promise.
#[derive(Clone, Copy)]
pub struct Case {
    /// Kebab-case.
    pub name: &'static str,
    /// What is promised.
    pub promise: &'static str,
    run: fn(&Candidate) -> Result<Verdict, String>,
}

impl Case {
    /// Holds a plugin against it.
    pub fn run(&self, candidate: &Candidate) -> Verdict {
        (self.run)(candidate).unwrap_or_else(Verdict::Failed)
    }
}

/// The cases for plugins of a kind: those of the border, then its own.
pub fn cases(kind: Kind) -> Vec<Case> {
    let own = match kind {
        Kind::Material => material::CASES,
        Kind::Grid => grid::CASES,
        Kind::Device => device::CASES,
    };
    border::CASES.iter().chain(own).copied().collect()
}

/// Holds a plugin that is linked in against every case: `kit::check::<AsMaterial<Spring>>()` in a test.
///
/// # Panics
/// If a promise does not hold, with a sentence for each.
pub fn check<R: Role>() {
    let candidate = Candidate::of::<R>();
    let kind = candidate.kind().expect("a kind of this version");
    let failed: Vec<String> = cases(kind)
        .iter()
        .filter_map(|case| match case.run(&candidate) {
            Verdict::Failed(why) => Some(format!("{}: {}: {why}", case.name, case.promise)),
            _ => None,
        })
        .collect();
    assert!(failed.is_empty(), "\n{}\n", failed.join("\n"));
}

/// What a plugin says, as a sentence.
fn told(fault: Fault) -> String {
    if fault.reason.is_empty() { fault.status.meaning().into() } else { fault.to_string() }
}

/// Passed, or failed with a sentence.
fn judge(holds: bool, why: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(why()) }
}
