//! Displacement of a point of the surface.

use super::{Quantity, Reading};

/// Distance of a vertex from its position in the file, m.
pub(super) static DISPLACEMENT: Quantity = Quantity {
    name: "displacement",
    summary: "Distance of the surface point nearest to `at` from its position in the file, m.",
    unit: "m",
    needs_surface: true,
    needs_place: true,
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.body().map_or(0.0, |body| {
        let vertex = reading.vertex;
        (body.skin.x[vertex] - body.model.surface.points[vertex]).norm()
    })
}
