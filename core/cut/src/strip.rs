//! The parts of two blades between which a strip cuts a mesh.
//!
//! A blade that turns about a place on it, as one that points to the eye of a viewer, goes back beyond that place: triangles between its ends would overlap there, and
//! reach back behind the last blade within the body.

use super::blade::Blade;
use super::mesh::CutMesh;
use pliant_mesh::geometry::Vec3;

/// Share of the way to the place about which a blade turns at which the strip ends: at the place itself it has no width.
const TO_PIVOT: f64 = 0.9;

impl CutMesh {
    /// The parts of two blades between which a strip is swept: all of them, or without what goes back if that is outside of the mesh.
    pub(super) fn swept_parts(&self, from: Blade, to: Blade) -> [Blade; 2] {
        let all = [from, to];
        let Some(pivot) = pivot(&from, &to) else { return all };
        let (low, high) = (TO_PIVOT * pivot, 1.0 - TO_PIVOT * (1.0 - pivot));
        let is_free = |part: [f64; 2]| all.iter().all(|blade| self.is_outside(&blade.part(part)));
        let kept = if is_free([low, 1.0]) {
            [0.0, low]
        } else if is_free([0.0, high]) {
            [high, 1.0]
        } else {
            return all;
        };
        all.map(|blade| blade.part(kept))
    }

    /// Whether a blade is in no part of the mesh.
    fn is_outside(&self, blade: &Blade) -> bool {
        !self.is_crossed(blade.tip, blade.heel) && !self.encloses(blade.tip)
    }
}

/// Where one blade crosses the other as they are seen along the normal of their strip, as a share of the way from tip to heel; `None` where both ends go the same way.
fn pivot(from: &Blade, to: &Blade) -> Option<f64> {
    let along = (from.heel - from.tip).try_normalize(0.0)?;
    let across = |way: Vec3| way - way.dot(&along) * along;
    let [tip, heel] = [across(to.tip - from.tip), across(to.heel - from.heel)];
    let ahead = if tip.norm() > heel.norm() { tip } else { heel };
    let [tip, heel] = [tip.dot(&ahead), heel.dot(&ahead)];
    (tip * heel < 0.0).then(|| tip / (tip - heel))
}

impl Blade {
    /// The part between two shares of the way from tip to heel.
    fn part(&self, shares: [f64; 2]) -> Self {
        let [tip, heel] = shares.map(|share| self.tip.lerp(&self.heel, share));
        Self { tip, heel }
    }
}
