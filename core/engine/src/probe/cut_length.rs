//! The length of edge blades have cut into surfaces.

use super::{Quantity, Reading};

/// The length of edge blades have cut into surfaces.
pub(super) static CUT_LENGTH: Quantity = Quantity {
    name: "cut-length",
    summary: "Length of edge cut into surfaces, one side of two, m.",
    unit: "m",
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.session.cuts().length
}
