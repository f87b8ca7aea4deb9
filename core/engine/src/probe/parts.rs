//! Number of connected parts of a body.

use super::{Quantity, Reading};

/// Number of connected parts of a body, where a stitched seam connects; 1 for a body that is not simulated.
pub(super) static PARTS: Quantity = Quantity {
    name: "parts",
    summary: "Number of connected parts of a body.",
    unit: "1",
    is_costly: true,
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.body().map_or(1.0, |body| body.parts().into_iter().max().map_or(0.0, |last| f64::from(last) + 1.0))
}
