//! Neighbour list of a tip (Verlet list): rebuilt when the motion of tip and body has used up its margin.

use crate::shape::Shape;
use pliant_solver::Vec3;

/// Margin of the list, in length scales of the tip.
const MARGIN: f64 = 0.5;

/// Vertices or triangles near a tip.
pub(super) struct NeighbourList {
    /// Indices of the vertices or triangles, ascending.
    pub list: Vec<u32>,
    /// Motion for which the list is still valid, m; negative if it is outdated.
    slack: f64,
    /// Centre of the tip at the last call, m.
    centre: Vec3,
}

impl Default for NeighbourList {
    fn default() -> Self {
        Self { list: Vec::new(), slack: -1.0, centre: Vec3::zeros() }
    }
}

impl NeighbourList {
    /// Invalidates the list, as after a change of the mesh.
    pub fn invalidate(&mut self) {
        self.slack = -1.0;
    }

    /// Empties the list if it is outdated for a tip at `centre`, after the mesh has moved by `moved` and before the tip moves by `travel` (all in
    /// m). Returns the radius around the centre from which the caller must fill it, m, or `None` if it is still valid.
    pub fn refresh(&mut self, centre: Vec3, shape: &dyn Shape, moved: f64, travel: f64) -> Option<f64> {
        let shift = centre - self.centre;
        self.slack -= moved + shift.norm();
        self.centre = centre;
        if self.slack >= travel {
            return None;
        }
        self.slack = MARGIN * shape.length_scale() + travel;
        self.list.clear();
        Some(shape.bounding_radius() + self.slack)
    }
}
