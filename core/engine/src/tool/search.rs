//! Proximity search over the surfaces of all bodies.

use super::Tool;
use crate::body::{Body, LatticeError, Sheet, interpolate};
use crate::contact::{ProximitySearch, Query, SurfacePoint, normal_of};
use crate::shape::OrientedShape;
use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;

/// Proximity search of one tool over all bodies, with a list of near cells for each.
pub struct SurfaceSearch {
    near: Vec<ProximitySearch>,
    /// Zero displacements, one for each body.
    still: Vec<f64>,
}

impl SurfaceSearch {
    /// A search in a scene with `bodies` bodies.
    pub fn new(bodies: usize) -> Self {
        Self { near: (0..bodies).map(|_| ProximitySearch::default()).collect(), still: vec![0.0; bodies] }
    }

    /// Adapts to another number of bodies.
    pub fn resize(&mut self, bodies: usize) {
        self.near.resize_with(bodies, ProximitySearch::default);
        self.still.resize(bodies, 0.0);
    }

    /// Invalidates the list of cells of `body`, as after a change of its cells.
    pub fn invalidate(&mut self, body: usize) {
        self.near[body].invalidate();
    }

    /// Ends all contacts, so that the tool may next touch either side of a surface.
    pub fn leave(&mut self) {
        self.near.iter_mut().for_each(ProximitySearch::leave);
    }

    /// Returns a search for a tool's proxy that may be called several times in a step, after nodes of each body have moved by at most `moved`
    /// (m).
    pub(super) fn by_tool<'a>(
        &'a mut self,
        bodies: &'a mut [Body],
        moved: &'a [f64],
    ) -> impl FnMut(&OrientedShape, Vec3, f64, &mut Vec<SurfacePoint>) -> Result<(), LatticeError> + 'a {
        let (near, still): (&mut [ProximitySearch], &[f64]) = (&mut self.near, &self.still);
        // The displacement since the last step counts for the first call only.
        let (mut since, mut is_repeated) = (moved, false);
        move |shape, centre, margin, out| {
            let moved = std::mem::replace(&mut since, still);
            let is_repeated = std::mem::replace(&mut is_repeated, true);
            let query = Query { centre, margin, shape: Some(shape), moved: 0.0, is_repeated };
            search(near, bodies, moved, query, out)
        }
    }

    /// The surface point closest to `centre` within `reach` (both in m), of all bodies.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn nearest(
        &mut self,
        bodies: &mut [Body],
        moved: &[f64],
        centre: Vec3,
        reach: f64,
    ) -> Result<Option<SurfacePoint>, LatticeError> {
        let mut found = Vec::new();
        // The lists of cells are for the proxy's kind of search (triangles or samples), so they are invalidated before and after this one.
        self.near.iter_mut().for_each(ProximitySearch::invalidate);
        let query = Query { centre, margin: reach, shape: None, moved: 0.0, is_repeated: false };
        let searched = search(&mut self.near, bodies, moved, query, &mut found);
        self.near.iter_mut().for_each(ProximitySearch::invalidate);
        searched?;
        Ok(found.into_iter().min_by(|a, b| a.distance.total_cmp(&b.distance)))
    }
}

/// The point of a sheet closest to `centre` within `reach` (both in m), of all sheets.
pub(super) fn nearest_on_sheets(bodies: &[Body], centre: Vec3, reach: f64) -> Option<SurfacePoint> {
    let sheets =
        bodies.iter().enumerate().filter_map(|(index, body)| Some((index as u32, body, body.discretization.sheet()?)));
    let near = sheets.filter_map(|(index, body, sheet)| on_sheet(index, body, sheet, centre, reach));
    near.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

/// Adds the near points of all bodies to `out`: samples for a tool whose features are large compared with the cells, triangles for smaller tools
/// and for points.
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
            // Sheets are searched only when a grip begins, so there is no list.
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

/// The point of a sheet closest to `centre` within `reach`, both in m.
fn on_sheet(index: u32, body: &Body, sheet: &Sheet, centre: Vec3, reach: f64) -> Option<SurfacePoint> {
    let mut best: Option<SurfacePoint> = None;
    for triangle in (0..body.model.surface.triangles.len() as u32).filter(|t| !body.failed_triangles.contains(*t)) {
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
                layer_factor: 1.0,
                triangle: None,
                sample: 0,
            });
        }
    }
    best
}
