//! The surface in units of cells, as classification reads it, and its validation.

use crate::lattice::Lattice;
use pliant_plugin_api::{Fault, SurfaceView};

/// A surface in units of cells of the finest level.
pub(crate) struct ScaledSurface<'a> {
    /// Positions from the origin of the lattice, in cells.
    pub(crate) points: Vec<[f64; 3]>,
    /// Indices of points.
    pub(crate) triangles: &'a [[u32; 3]],
}

impl<'a> ScaledSurface<'a> {
    pub(crate) fn new(surface: &SurfaceView<'a>, lattice: &Lattice) -> Self {
        let points = surface.points.iter().map(|&p| lattice.in_cells(p)).collect();
        Self { points, triangles: surface.triangles }
    }
}

/// Whether each point is used by a triangle.
///
/// # Errors
/// A surface without triangles, a point that is not finite, or a triangle with an index out of range.
pub(crate) fn used_points(surface: &SurfaceView<'_>) -> Result<Vec<bool>, Fault> {
    let (points, triangles) = (surface.points, surface.triangles);
    if triangles.is_empty() {
        return Err(Fault::bad_argument(format!("surface of {} points has no triangles", points.len())));
    }
    if let Some(index) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(Fault::bad_argument(format!("point {index} is not finite: {:?}", points[index])));
    }
    let mut used = vec![false; points.len()];
    for (i, &point) in triangles.as_flattened().iter().enumerate() {
        let Some(used) = used.get_mut(point as usize) else {
            let (triangle, count) = (i / 3, points.len());
            return Err(Fault::bad_argument(format!("triangle {triangle} uses point {point} of {count} points")));
        };
        *used = true;
    }
    Ok(used)
}
