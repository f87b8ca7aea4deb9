//! Stability reports: maps of states, step limits, energy and momentum balances, extreme values, and the coupling of a hand.

mod catalogue;
mod conservation;
mod coupling;
mod energy;
mod extreme;
mod graded_mesh;
mod limit;
mod map;
mod map_run;
mod page;
mod run;
mod state;
mod task;

pub use catalogue::StabilityCatalogue;
pub use run::stability;
