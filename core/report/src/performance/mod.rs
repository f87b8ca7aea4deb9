//! What a step costs: time against size, threads, contacts and stage, beside a model of operations; what leaving parts out saves; and how
//! late the ticks of the haptic loop begin.

mod catalogue;
mod haptic_loop;
mod page;
mod run;
mod start_up;
mod timed_case;

pub use catalogue::PerformanceCatalogue;
pub use run::performance;
