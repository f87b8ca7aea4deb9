//! What `pliant report` measures, and that it can come out bad.

mod report_accuracy;
mod report_performance;
mod report_stability;
