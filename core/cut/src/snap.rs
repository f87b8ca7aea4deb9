//! Snapping tolerances of intersections.

/// Tolerances below which a crossing snaps to a vertex or to the end of an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct SnapTolerances {
    /// Distance from the plane, in shortest edges of a vertex, below which the vertex counts as on the plane.
    pub on: f64,
    /// Distance from an end, in lengths of the edge or run, below which an intersection snaps to the end.
    pub ends: f64,
    /// Distance from the plane, in shortest edges of a vertex, above which the vertex never counts as on the plane.
    pub reach: f64,
    /// Distance from a side of the facet, in widths of it, above which an intersection never snaps to that side.
    pub beside: f64,
    /// Smallest angle of a piece of a triangle, degrees, unless the triangle had nearly such an angle.
    pub sharpest: f64,
}

/// Tolerances of solids, tried in order until an advance is not refused. The last ones snap almost nothing and allow any angle, because a blade that
/// stays blocked by one triangle is worse than a sliver.
pub(super) const SNAPS: [SnapTolerances; 3] = [
    SnapTolerances { on: 2e-3, ends: 2e-3, reach: 0.1, beside: 0.1, sharpest: 0.1 },
    SnapTolerances { on: 0.02, ends: 0.05, reach: 0.1, beside: 0.1, sharpest: 0.1 },
    SnapTolerances { on: 1e-7, ends: 1e-7, reach: 0.1, beside: 0.1, sharpest: 1e-4 },
];

/// Tolerances of sheets, whose triangles are elements: larger ones, so that the cut has a small step instead of a sliver.
pub(super) const SHEET_SNAPS: [SnapTolerances; 3] = [
    SnapTolerances { on: 0.05, ends: 0.1, reach: 0.2, beside: f64::INFINITY, sharpest: 2.0 },
    SnapTolerances { on: 0.02, ends: 0.05, reach: 0.1, beside: f64::INFINITY, sharpest: 1.0 },
    SnapTolerances { on: 2e-3, ends: 2e-3, reach: 0.1, beside: f64::INFINITY, sharpest: 0.1 },
];
