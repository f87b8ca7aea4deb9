//! Volume that a closed surface encloses.

use super::{Measure, Quantity, Reading};
use pliant_solver::Vec3;

/// Volume that a closed surface, or a closed part of it, encloses, m^3, by the divergence theorem; NaN for a part that is not there.
pub(super) static VOLUME: Quantity = Quantity {
    name: "volume",
    summary: "Volume that a closed surface or a part of it encloses, m^3; meaningless for an open one.",
    unit: "m^3",
    needs_surface: true,
    is_costly: true,
    reads_parts: true,
    measure: Measure::Scalar(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.sum_of_triangles(|[a, b, c]: [Vec3; 3]| a.dot(&b.cross(&c)) / 6.0)
}
