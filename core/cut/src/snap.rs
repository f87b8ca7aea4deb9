//! How close to the plane of a facet, and to the ends of edges, counts as on it.

/// Tolerances below which a crossing snaps to a vertex or to the end of an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct SnapTolerances {
    /// Of a vertex's shortest edge: closer to the plane than this counts as on it.
    pub on: f64,
    /// Of an edge or run: a crossing closer to an end than this becomes the end.
    pub ends: f64,
    /// Of a vertex's shortest edge: a vertex further from the plane than this never counts as on it.
    pub reach: f64,
    /// Degrees; a piece of a triangle must not be sharper, unless the triangle was nearly so.
    pub sharpest: f64,
}

/// Tolerances of solids, tried in order until one is not refused. The last snaps next to nothing and allows triangles as sharp as
/// they come: a blade that stuck for good in front of one triangle would be worse than a sharp one.
pub(super) const SNAPS: [SnapTolerances; 3] = [
    SnapTolerances { on: 2e-3, ends: 2e-3, reach: 0.1, sharpest: 0.1 },
    SnapTolerances { on: 0.02, ends: 0.05, reach: 0.1, sharpest: 0.1 },
    SnapTolerances { on: 1e-7, ends: 1e-7, reach: 0.1, sharpest: 1e-4 },
];

/// The same for a cap, whose triangles are elements: what would be a splinter is a step of the cut instead.
pub(super) const SHEET_SNAPS: [SnapTolerances; 3] = [
    SnapTolerances { on: 0.05, ends: 0.1, reach: 0.2, sharpest: 2.0 },
    SnapTolerances { on: 0.02, ends: 0.05, reach: 0.1, sharpest: 1.0 },
    SnapTolerances { on: 2e-3, ends: 2e-3, reach: 0.1, sharpest: 0.1 },
];
