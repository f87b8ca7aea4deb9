//! How far a point of the surface has moved.

use super::{Quantity, Reading};

/// How far a point of the surface has moved.
pub(super) static DISPLACEMENT: Quantity = Quantity {
    name: "displacement",
    summary: "How far the surface point nearest to `at` is from where it was in the file, m.",
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
