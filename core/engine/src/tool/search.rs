//! What of all bodies is near a place.

use super::Tool;
use crate::body::{Body, LatticeError, Sheet, interpolate};
use crate::contact::{ProximitySearch, Query, SurfacePoint, normal_of};
use crate::shape::OrientedShape;
use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;

/// Searches the surfaces of all bodies, with a list of near cells for each.
pub struct SurfaceSearch {
    near: Vec<ProximitySearch>,
    /// A zero for each body.
    still: Vec<f64>,
}

impl SurfaceSearch {
    /// In a scene of `bodies` bodies.
    pub fn new(bodies: usize) -> Self {
        Self { near: (0..bodies).map(|_| ProximitySearch::default()).collect(), still: vec![0.0; bodies] }
    }

    /// The cells of `body` have changed.
    pub fn forget(&mut self, body: usize) {
        self.near[body].invalidate();
    }

    /// The tool touches nothing, and may come to any side of the surfaces.
    pub fn leave(&mut self) {
        self.near.iter_mut().for_each(ProximitySearch::leave);
    }

    /// A search by a tool that may be asked several times in a step, after nodes of each body have moved by at most `moved` (m).
    pub(super) fn by_tool<'a>(
        &'a mut self,
        bodies: &'a mut [Body],
        moved: &'a [f64],
    ) -> impl FnMut(&OrientedShape, Vec3, f64, &mut Vec<SurfacePoint>) -> Result<(), LatticeError> + 'a {
        let (near, still): (&mut [ProximitySearch], &[f64]) = (&mut self.near, &self.still);
        // Nodes have moved once since the last step, not once for every place the proxy looks at.
        let mut since = moved;
        move |shape, centre, margin, out| {
            let moved = std::mem::replace(&mut since, still);
            let query = Query { centre, margin, shape: Some(shape), moved: 0.0 };
            search(near, bodies, moved, query, out)
        }
    }

    /// The point of any surface nearest to `centre`, within `reach` (m).
    ///
    /// # Errors
    /// A grid that fails.
    pub fn nearest(
        &mut self,
        bodies: &mut [Body],
        moved: &[f64],
        centre: Vec3,
        reach: f64,
    ) -> Result<Option<SurfacePoint>, LatticeError> {
        let mut found = Vec::new();
        // Lists of cells hold weights for triangles or for samples of a ball: none outlives the search it was made for.
        self.near.iter_mut().for_each(ProximitySearch::invalidate);
        let searched =
            search(&mut self.near, bodies, moved, Query { centre, margin: reach, shape: None, moved: 0.0 }, &mut found);
        self.near.iter_mut().for_each(ProximitySearch::invalidate);
        searched?;
        Ok(found.into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance)))
    }
}

/// The point of any sheet nearest to `centre`, within `reach` (m).
pub(super) fn nearest_on_sheets(bodies: &[Body], centre: Vec3, reach: f64) -> Option<SurfacePoint> {
    let sheets =
        bodies.iter().enumerate().filter_map(|(index, body)| Some((index as u32, body, body.discretization.sheet()?)));
    let near = sheets.filter_map(|(index, body, sheet)| on_sheet(index, body, sheet, centre, reach));
    near.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// Lists what of all bodies is near: samples for a tool whose features are large against the grid, triangles for smaller tools and points.
fn search(
    near: &mut [ProximitySearch],
    bodies: &mut [Body],
    moved: &[f64],
    query: Query<'_>,
    out: &mut Vec<SurfacePoint>,
) -> Result<(), LatticeError> {
    out.clear();
    for (index, body) in bodies.iter_mut().enumerate() {
        if let Some(sheet) = body.discretization.sheet() {
            // Looked for once, when a grip is taken: no list is kept.
            if query.shape.is_none() {
                out.extend(on_sheet(index as u32, body, sheet, query.centre, query.margin));
            }
            continue;
        }
        let (list, query) = (&mut near[index], Query { moved: moved[index], ..query });
        if query.shape.is_some_and(|shape| Tool::meets_samples(shape, body.discretization.edge())) {
            let samples = std::sync::Arc::clone(&body.samples);
            list.samples(index as u32, body, &samples, &query, out)?;
        } else {
            list.triangles(index as u32, body, &query, out)?;
        }
    }
    Ok(())
}

/// The point of a sheet closest to `centre`, within `reach`.
fn on_sheet(index: u32, body: &Body, sheet: &Sheet, centre: Vec3, reach: f64) -> Option<SurfacePoint> {
    let mut best: Option<SurfacePoint> = None;
    for triangle in 0..body.model.surface.triangles.len() as u32 {
        let corners = sheet.nodes_of(&body.model, triangle).map(|n| body.system.nodes.x[n as usize]);
        let closest = closest_point(centre, corners);
        let d = closest.point - centre;
        let distance = d.norm();
        if distance <= best.map_or(reach, |near| near.distance) {
            let rest = body.model.surface.triangles[triangle as usize].map(|v| body.skin.settled[v as usize]);
            best = Some(SurfacePoint {
                body: index,
                point: closest.point,
                rest: interpolate(rest, closest.bary),
                normal: normal_of(rest),
                distance,
                area: 0.0,
                triangle: None,
            });
        }
    }
    best
}
