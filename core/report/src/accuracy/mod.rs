//! Cases with known answers: every method at every resolution, with error, order of convergence and cost.

mod catalogue;
mod page;
mod run;

pub use catalogue::AccuracyCatalogue;
pub use run::accuracy;
