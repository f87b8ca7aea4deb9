//! Performance reports: step time against size, threads, contacts and stage, with a model of operations; savings by leaving parts out; and lateness of the
//! ticks of the haptic loop.

mod catalogue;
mod haptic_loop;
mod page;
mod run;
mod start_up;
mod timed_case;

pub use catalogue::PerformanceCatalogue;
pub use run::performance;
