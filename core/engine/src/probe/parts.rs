//! Number of connected parts of a body.

use super::{Measure, Quantity, Reading};
use pliant_mesh::NO_SHELL;

/// Number of connected parts of a body, where a stitched seam connects; 1 for a body that is not simulated.
pub(super) static PARTS: Quantity = Quantity {
    name: "parts",
    summary: "Number of connected parts of a body.",
    unit: "1",
    is_costly: true,
    measure: Measure::Scalar(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    let count = |parts: Vec<u32>| parts.into_iter().filter(|part| *part != NO_SHELL).max().map_or(0, |last| last + 1);
    reading.body().map_or(1.0, |body| f64::from(count(body.parts())))
}
