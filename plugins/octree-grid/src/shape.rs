//! The surface, checked and counted in cells of the finest level: what classification reads.

use crate::lattice::Lattice;
use crate::vector::Vector;
use pliant_plugin_api::{Fault, SurfaceView};

/// Corners counted in cells, and triangles over them.
pub(crate) struct Shape<'a> {
    pub(crate) corners: Vec<Vector>,
    pub(crate) triangles: &'a [[u32; 3]],
}

impl<'a> Shape<'a> {
    pub(crate) fn new(surface: &SurfaceView<'a>, lattice: &Lattice) -> Self {
        let corners = surface.points.iter().map(|&p| lattice.in_cells(p)).collect();
        Self { corners, triangles: surface.triangles }
    }
}

/// Which points triangles use.
///
/// # Errors
/// A surface without triangles, a point that is not finite, a triangle of points there are not.
pub(crate) fn used(surface: &SurfaceView<'_>) -> Result<Vec<bool>, Fault> {
    let (points, triangles) = (surface.points, surface.triangles);
    if triangles.is_empty() {
        return Err(Fault::bad_argument(format!("surface of {} points has no triangles", points.len())));
    }
    if let Some(at) = points.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        return Err(Fault::bad_argument(format!("point {at} is not finite: {:?}", points[at])));
    }
    let mut used = vec![false; points.len()];
    for (at, &point) in triangles.as_flattened().iter().enumerate() {
        let Some(used) = used.get_mut(point as usize) else {
            let (triangle, count) = (at / 3, points.len());
            return Err(Fault::bad_argument(format!("triangle {triangle} uses point {point} of {count} points")));
        };
        *used = true;
    }
    Ok(used)
}
