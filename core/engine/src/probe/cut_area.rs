//! Area of the cuts inside of closed bodies.

use super::{Measure, Quantity, Reading};

/// Area of the cuts inside of closed bodies, one side of two, m^2.
pub(super) static CUT_AREA: Quantity = Quantity {
    name: "cut-area",
    summary: "Area of the cuts inside of closed bodies, one side of two, m^2.",
    unit: "m^2",
    measure: Measure::Scalar(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.session.cuts().area
}
