//! Elastic energy of all bodies.

use super::{Quantity, Reading};

/// Elastic energy of all bodies, J.
pub(super) static ELASTIC_ENERGY: Quantity = Quantity {
    name: "elastic-energy",
    summary: "Elastic energy of all bodies, J.",
    unit: "J",
    needs_energy: true,
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.frame.elastic_energy
}
