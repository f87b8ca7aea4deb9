//! Area of a body's surface.

use super::{Measure, Quantity, Reading};
use pliant_solver::Vec3;

/// Area of the surface of a body or of a part of it, in its present shape, m^2; NaN for a part that is not there.
pub(super) static AREA: Quantity = Quantity {
    name: "area",
    summary: "Area of the surface of a body or of a part of it, m^2.",
    unit: "m^2",
    needs_surface: true,
    is_costly: true,
    reads_parts: true,
    measure: Measure::Scalar(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.sum_of_triangles(|[a, b, c]: [Vec3; 3]| 0.5 * (b - a).cross(&(c - a)).norm())
}
