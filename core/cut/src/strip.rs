//! The parts of two blades between which a strip cuts a mesh.
//!
//! A blade that turns about a place on it, as one that points to the eye of a viewer, goes back beyond that place: triangles between its ends would overlap there, and
//! reach back behind the last blade within the body.

use super::blade::Blade;
use super::mesh::CutMesh;
use pliant_mesh::geometry::Vec3;

/// Shares of the way to the place about which a blade turns at which a strip may end; the first is taken beyond which nothing is. The nearer to that place the
/// narrower the strip is, and the farther its two triangles are turned from each other if the blade leaves its plane.
const TO_PIVOT: [f64; 5] = [0.5, 0.6, 0.7, 0.8, 0.9];

impl CutMesh {
    /// The parts of two blades between which a strip is swept: all of them, or without what goes back if that is outside of the mesh.
    pub(super) fn swept_parts(&self, from: Blade, to: Blade) -> [Blade; 2] {
        self.mesh_side(&from, &to).unwrap_or([from, to])
    }

    /// The parts of two blades on the side of the place about which the blade turns where the mesh is; `None` if it turns about none, or the mesh is on both sides.
    pub(super) fn mesh_side(&self, from: &Blade, to: &Blade) -> Option<[Blade; 2]> {
        let (all, pivot) = ([from, to], pivot(from, to)?);
        let is_free = |part: [f64; 2]| self.is_outside(all.map(|blade| blade.part(part)));
        let kept = TO_PIVOT.iter().find_map(|share| {
            let (low, high) = (share * pivot, 1.0 - share * (1.0 - pivot));
            let is_tip_kept = is_free([low, 1.0]).then_some([0.0, low]);
            is_tip_kept.or_else(|| is_free([0.0, high]).then_some([high, 1.0]))
        });
        kept.map(|kept| all.map(|blade| blade.part(kept)))
    }

    /// Whether nothing of the mesh is at a strip between two blades.
    fn is_outside(&self, [from, to]: [Blade; 2]) -> bool {
        let mut is_free = !self.encloses(from.tip);
        for corners in [[from.tip, from.heel, to.heel], [from.tip, to.heel, to.tip]] {
            self.tree.near_facet(corners, 0.0, |_| is_free = false);
        }
        is_free
    }
}

/// The pivot, as a share of the length of a blade, for a mesh that goes up to the share `last`: with the last but one of [`TO_PIVOT`] a strip ends there, and one is to spare.
pub(super) fn pivot_beyond(last: f64) -> f64 {
    last / TO_PIVOT[TO_PIVOT.len() - 2]
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
