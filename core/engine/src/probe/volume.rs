//! Volume that a closed surface encloses.

use super::{Quantity, Reading};
use pliant_solver::Vec3;

/// Volume that a closed surface encloses, m^3, by the divergence theorem.
pub(super) static VOLUME: Quantity = Quantity {
    name: "volume",
    summary: "Volume that a closed surface encloses, m^3; meaningless for an open one.",
    unit: "m^3",
    needs_surface: true,
    is_costly: true,
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.body().map_or(0.0, |body| {
        let corners = |t: &[u32; 3]| t.map(|v| body.skin.x[v as usize]);
        let tetrahedron = |[a, b, c]: [Vec3; 3]| a.dot(&b.cross(&c)) / 6.0;
        body.model.surface.triangles.iter().map(corners).map(tetrahedron).sum()
    })
}
