//! Crumbs: parts of a closed body that are too small to be of any use.
//!
//! Where the walls of two cuts cross at a small angle, strips that wander by a hair's breadth separate a few triangles from the rest.

use super::mesh::CutMesh;
use super::record::OPEN;
use std::collections::HashSet;

/// Most triangles of a crumb: a bound of what is looked at.
const MAX_TRIANGLES: usize = 512;
/// Share of its body's volume above which no part is a crumb: the parts of a small body are small.
const MAX_SHARE: f64 = 1e-2;

impl CutMesh {
    /// Volume of a crumb that the open step has separated or changed, m^3: a part of less volume than `least` (m^3), and than a hundredth of its body.
    pub(super) fn crumb(&self, least: f64) -> Option<f64> {
        let first = self.changed().1 as u32;
        let mut seen = HashSet::new();
        // A step separates nothing without new walls.
        let mut walls = (first..self.surface.triangles.len() as u32).filter(|triangle| self.is_cap(*triangle));
        walls.find_map(|wall| {
            let volume = self.small_part(wall, &mut seen)?;
            let body = self.bodies.get(self.body[wall as usize] as usize)?;
            (volume < least.min(MAX_SHARE * body.volume)).then_some(volume)
        })
    }

    /// Volume of the part of a triangle, m^3; `None` if it has many triangles, or any of those that were `seen` before.
    fn small_part(&self, seed: u32, seen: &mut HashSet<u32>) -> Option<f64> {
        if self.body[seed as usize] == OPEN || seen.contains(&seed) {
            return None;
        }
        let (mut members, mut at) = (vec![seed], 0);
        let mut own = HashSet::from([seed]);
        let mut is_small = true;
        while at < members.len() && is_small {
            for other in (3 * members[at]..3 * members[at] + 3).map(|half| self.link_of(half) / 3) {
                is_small &= !seen.contains(&other);
                if own.insert(other) {
                    members.push(other);
                }
            }
            at += 1;
            is_small &= members.len() <= MAX_TRIANGLES;
        }
        seen.extend(own);
        let origin = self.corners_of(seed)[0];
        let cone = |triangle: u32| (self.corners_of(triangle)[0] - origin).dot(&self.cross(triangle)) / 6.0;
        is_small.then(|| members.into_iter().map(cone).sum::<f64>().abs())
    }
}
