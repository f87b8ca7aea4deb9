//! Displacement of a point of the surface.

use super::{Measure, Quantity, Reading};
use pliant_solver::Vec3;

/// Displacement of a vertex from its position in the file, m.
pub(super) static DISPLACEMENT: Quantity = Quantity {
    name: "displacement",
    summary: "Displacement of the surface point nearest to `at` from its position in the file, m.",
    unit: "m",
    needs_surface: true,
    needs_place: true,
    measure: Measure::Vector(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> Vec3 {
    reading.body().map_or(Vec3::zeros(), |body| {
        let vertex = reading.vertex;
        body.skin.x[vertex] - body.model.surface.points[vertex]
    })
}
