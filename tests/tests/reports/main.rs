//! What `pliant report` measures, and that it can come out bad.

mod printed_catalogues;
mod report_accuracy;
mod report_performance;
mod report_stability;
