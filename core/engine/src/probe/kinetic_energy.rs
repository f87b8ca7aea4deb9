//! Kinetic energy of all bodies.

use super::{Measure, Quantity, Reading};

/// Kinetic energy of all bodies, J.
pub(super) static KINETIC_ENERGY: Quantity = Quantity {
    name: "kinetic-energy",
    summary: "Kinetic energy of all bodies, J.",
    unit: "J",
    needs_energy: true,
    measure: Measure::Scalar(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.frame.kinetic_energy
}
