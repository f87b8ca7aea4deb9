//! The area blades have cut inside of closed bodies.

use super::{Quantity, Reading};

/// The area blades have cut inside of closed bodies.
pub(super) static CUT_AREA: Quantity = Quantity {
    name: "cut-area",
    summary: "Area cut inside of closed bodies, one wall of two, m^2.",
    unit: "m^2",
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.session.cuts().area
}
