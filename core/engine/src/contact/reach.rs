//! What a tip may reach soon, listed anew only when it or the body has moved so far that the list may miss something.

use pliant_solver::Vec3;

/// Radii around a tip in which things are listed.
const MARGIN: f64 = 0.5;

/// Numbers of what is near a tip, and how much motion, m, the list still stands for.
pub(super) struct Reach {
    pub list: Vec<u32>,
    slack: f64,
    centre: Vec3,
}

impl Default for Reach {
    fn default() -> Self {
        Self { list: Vec::new(), slack: -1.0, centre: Vec3::zeros() }
    }
}

impl Reach {
    /// The list is of something that has changed.
    pub fn forget(&mut self) {
        self.slack = -1.0;
    }

    /// Empties the list if it does not stand for a tip that is now at `centre`, of `radius`, after both have moved, and for
    /// `travel` more (all in m); gives how far from the centre it must be filled.
    pub fn renew(&mut self, centre: Vec3, radius: f64, moved: f64, travel: f64) -> Option<f64> {
        let shift = centre - self.centre;
        self.slack -= moved + shift.norm();
        self.centre = centre;
        if self.slack >= travel {
            return None;
        }
        self.slack = MARGIN * radius + travel;
        self.list.clear();
        Some(radius + self.slack)
    }
}
