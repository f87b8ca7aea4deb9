//! The list of what a tip may reach soon, renewed only when tip or body have moved so far that it may miss something.

use crate::shape::Shape;
use pliant_solver::Vec3;

/// Length scales around a tip within which things are listed.
const MARGIN: f64 = 0.5;

/// Indices of what is near a tip.
pub(super) struct Reach {
    /// Vertices or triangles, rising.
    pub list: Vec<u32>,
    /// Motion that the list still allows, m.
    slack: f64,
    centre: Vec3,
}

impl Default for Reach {
    fn default() -> Self {
        Self { list: Vec::new(), slack: -1.0, centre: Vec3::zeros() }
    }
}

impl Reach {
    /// Declares the list outdated: the mesh has changed.
    pub fn forget(&mut self) {
        self.slack = -1.0;
    }

    /// Empties the list if it may miss something near a tip at `centre`, after the mesh has moved by `moved` and before the tip moves by
    /// `travel` (all in m). Returns how far from the centre it must be filled, m, or `None` if it still holds.
    pub fn renew(&mut self, centre: Vec3, shape: &dyn Shape, moved: f64, travel: f64) -> Option<f64> {
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
