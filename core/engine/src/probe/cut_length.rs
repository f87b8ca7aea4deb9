//! Length of the cuts through surfaces.

use super::{Measure, Quantity, Reading};

/// Length of the cuts through surfaces, one side of two, m.
pub(super) static CUT_LENGTH: Quantity = Quantity {
    name: "cut-length",
    summary: "Length of the cuts through surfaces, one side of two, m.",
    unit: "m",
    measure: Measure::Scalar(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.session.cuts().length
}
