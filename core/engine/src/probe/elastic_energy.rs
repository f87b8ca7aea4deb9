//! Elastic energy of all bodies.

use super::{Measure, Quantity, Reading};

/// Elastic energy of all bodies, J.
pub(super) static ELASTIC_ENERGY: Quantity = Quantity {
    name: "elastic-energy",
    summary: "Elastic energy of all bodies, J.",
    unit: "J",
    needs_energy: true,
    measure: Measure::Scalar(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.frame.elastic_energy
}
