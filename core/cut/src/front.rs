//! The front of a cut: how far a blade has gone forward along all of its length.
//!
//! A blade that turns about a place inside of the mesh goes forward on one side of that place and back on the other, through what it has cut already. A strip up to it would fold back over the
//! strips before it. Once the blade has left their plane, the strip would cut the surface beside them: a branch of the line of the cut.

use super::blade::Blade;
use super::mesh::CutMesh;
use super::strip::pivot_beyond;
use pliant_mesh::geometry::Vec3;

impl CutMesh {
    /// The blade up to which to cut next, from the blade `from` of the last advance, when the knife is at `to`.
    ///
    /// That is `to` as long as no part of it within the mesh has gone back against the direction `ahead`. Otherwise it is a blade that has gone as far forward as `to` at the place of `from`
    /// that is nearest to `middle` (m), and turns about a place beyond the mesh; and `from` where that place has not gone forward.
    pub fn front(&self, from: &Blade, to: &Blade, middle: Vec3, ahead: Vec3) -> Blade {
        let blade = from.heel - from.tip;
        let share_of = |x: Vec3| (x - from.tip).dot(&blade) / blade.norm_squared();
        let Some(across) = (ahead - ahead.dot(&blade) / blade.norm_squared() * blade).try_normalize(0.0) else {
            return *to;
        };
        let [tip, heel] = [to.tip - from.tip, to.heel - from.heel].map(|way| way.dot(&across));
        if tip.min(heel) >= 0.0 || self.mesh_side(from, to).is_some() {
            return *to;
        }
        let at_middle = share_of(middle).clamp(0.0, 1.0);
        let forward = tip + at_middle * (heel - tip);
        if forward <= 0.0 {
            return *from;
        }
        // Shares of the blade from tip to heel; from heel to tip where the tip has gone back.
        let oriented = |share: f64| if heel < 0.0 { share } else { 1.0 - share };
        let mut last = oriented(tip / (tip - heel));
        for corners in [[from.tip, from.heel, to.heel], [from.tip, to.heel, to.tip]] {
            self.tree.near_facet(corners, 0.0, |triangle| {
                last = self.corners_of(triangle).map(|x| oriented(share_of(x))).into_iter().fold(last, f64::max);
            });
        }
        let pivot = oriented(pivot_beyond(last));
        // In the plane of the blade and the direction: a motion aside is cut once the blade has gone forward all along.
        let moved = |share: f64| (pivot - share) / (pivot - at_middle) * forward * across;
        Blade { tip: from.tip + moved(0.0), heel: from.heel + moved(1.0) }
    }
}
