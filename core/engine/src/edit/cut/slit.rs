//! A blade in the slit of an earlier cut: it goes along there and cuts nothing.
//!
//! Two cuts a hair's breadth apart are no use to anyone: where their walls meet, crumbs are left. So a blade that goes along with an earlier cut, closer to it than what
//! the lattice can tell apart, is in that one's slit. Where it comes into the slit and where it leaves it, a strip through the wall joins both cuts, so that no
//! neck is left between them.

use super::middle::Middle;
use pliant_cut::{Blade, CapPoint, CutMesh};
use pliant_solver::Vec3;

/// Where a blade is, on its way from another one.
pub enum Surroundings {
    /// In the slit of an earlier cut, all of it that is in the body.
    Slit(Slit),
    /// In material, at least in part.
    Material,
    /// In no body.
    Air,
}

/// What a blade comes from.
#[derive(Clone, Copy)]
pub enum Origin {
    /// The slit of an earlier cut.
    Slit,
    /// Outside of the body, or the beginning of the stroke.
    Air,
    /// A cut of its own, whose end is in the body.
    Material,
}

/// A blade in a slit.
#[derive(Clone, Copy)]
pub struct Slit {
    /// The blade, moved onto the walls of the cut.
    pub blade: Blade,
    /// The blade before in the same slit, or else this one.
    pub behind: Blade,
    /// Mean position of the walls beside it, m.
    pub place: Vec3,
    /// The place on blades by which their motion is told.
    middle: Middle,
    /// Mean unit normal of the walls.
    normal: Vec3,
    /// Largest distance of a point of the moved blade from the walls, m.
    spread: f64,
}

/// Largest distance from a cut at which a blade is in its slit, in cell edges, and least cosine between the normals of its strip and of the walls: of a blade that is in
/// it already, of one that comes from outside of the body, and of one that is in a cut of its own. The way of a blade in the rest shape wanders by some tenths of a
/// cell, for the material gives way to it: a blade stays in its slit whatever it is turned by, and the same line is found again by its direction. Slices that are
/// thinner are no use to a lattice. In a cut of its own it goes on: lines that cross at more than 0.2 rad are left to the mesh.
const LIMITS: [[f64; 2]; 3] = [[0.4, 0.0], [0.3, 0.9], [0.1, 0.98]];
/// Distance from a wall's triangles, along them, up to which a point is beside them and not beyond the end of the cut, in cell edges:
/// walls have small triangles that are askew.
const BESIDE: f64 = 0.02;
/// The same distance where an earlier cut ends at the original surface, in cell edges: nothing is left to cut beyond it.
const BESIDE_AT_SKIN: f64 = 0.15;
/// What is added to it per height above the walls: the original surface may be slanted against them by up to 72 degrees.
const BESIDE_PER_HEIGHT: f64 = 3.0;
/// Distance between points of the blade, in cell edges.
const SPACING: f64 = 0.5;
/// Number of points along and across the gap between two cuts that meet head on, each way.
const GAP_POINTS: usize = 32;
/// Most points of a blade.
const MAX_POINTS: usize = 1024;

impl Surroundings {
    /// Where the blade `to` is, which has come from `from` and that `origin`, in the rest shape of a body with this `middle` and cells of `edge` (m).
    pub fn of(mesh: &CutMesh, origin: Origin, [from, to]: [&Blade; 2], middle: Middle, edge: f64) -> Self {
        let [reach, least_cosine] = LIMITS[origin as usize];
        let reach = reach * edge;
        let along = to.heel - to.tip;
        let Some(strip_normal) = along.cross(&middle.way(from, to)).try_normalize(0.0) else {
            return Self::Material;
        };
        // What is just ahead of the end of a cut of its own is beside the walls of that.
        let cuts = matches!(origin, Origin::Material);
        if cuts && middle.way(from, to).norm() <= 2.0 * BESIDE * edge {
            return Self::Material;
        }
        let count = ((along.norm() / (SPACING * edge)).ceil() as usize).clamp(2, MAX_POINTS);
        let mut walls: Vec<(Vec3, CapPoint)> = Vec::new();
        for i in 0..=count {
            let point = to.tip.lerp(&to.heel, i as f64 / count as f64);
            if let Some(wall) = mesh.nearest_cap(point, reach) {
                let offset = point - wall.position;
                let height = offset.dot(&wall.normal);
                let slide = offset - height * wall.normal;
                let beside = if wall.is_at_skin && !cuts {
                    BESIDE_AT_SKIN * edge + BESIDE_PER_HEIGHT * height.abs()
                } else {
                    BESIDE * edge
                };
                let is_beside = slide.norm() <= beside;
                if is_beside && wall.normal.dot(&strip_normal).abs() >= least_cosine {
                    walls.push((offset, wall));
                    continue;
                }
            }
            if mesh.encloses(point) {
                return Self::Material;
            }
        }
        // The two walls of a slit face each other.
        let turned = |wall: &CapPoint| wall.normal.dot(&walls[0].1.normal).signum() * wall.normal;
        let Some(normal) = walls.iter().map(|(_, wall)| turned(wall)).sum::<Vec3>().try_normalize(0.0) else {
            return Self::Air;
        };
        let heights: Vec<f64> = walls.iter().map(|(offset, _)| offset.dot(&normal)).collect();
        let mean = heights.iter().sum::<f64>() / heights.len() as f64;
        let spread = heights.iter().fold(0.0_f64, |spread, height| spread.max((height - mean).abs()));
        let blade = to.moved(-mean * normal);
        let place = walls.iter().map(|(_, wall)| wall.position).sum::<Vec3>() / walls.len() as f64;
        Self::Slit(Slit { blade, behind: blade, place, middle, normal, spread })
    }
}

impl Slit {
    /// The blades up to which a cut of `mesh` that ends at `from` is led through the walls, to a `distance` (m) from them. A cut that meets the slit head on passes
    /// its end first and crosses it a `stride` (m) farther, unless both are joined already.
    pub fn way_in(&self, mesh: &CutMesh, from: &Blade, distance: f64, stride: f64) -> Vec<Blade> {
        let aside = self.side(from) * (distance + self.spread) * self.normal;
        let beyond = self.blade.moved(-aside);
        if self.height(from).abs() > 2.0 * aside.norm() {
            return vec![beyond];
        }
        if self.is_joined(mesh, from, 2.0 * aside) {
            return Vec::new();
        }
        let onward = self.middle.way(from, &self.blade).try_normalize(0.0).unwrap_or_default();
        vec![self.blade.moved(aside), beyond.moved(stride * onward)]
    }

    /// Whether there is a gap between a blade and the slit that another cut leads through all along, no farther than `aside` (m) from the straight way.
    fn is_joined(&self, mesh: &CutMesh, from: &Blade, aside: Vec3) -> bool {
        let mut has_gap = false;
        let is_cut = (0..GAP_POINTS.pow(2)).all(|i| {
            let [on, along] = [i / GAP_POINTS, i % GAP_POINTS].map(|i| (i as f64 + 0.5) / GAP_POINTS as f64);
            let blade = Blade { tip: from.tip.lerp(&self.blade.tip, on), heel: from.heel.lerp(&self.blade.heel, on) };
            let point = blade.tip.lerp(&blade.heel, along) - self.height(&blade) * self.normal;
            if !mesh.encloses(point) || mesh.nearest_cap(point, 0.1 * aside.norm()).is_some() {
                return true;
            }
            has_gap = true;
            mesh.is_crossed(point - aside, point + aside)
        });
        has_gap && is_cut
    }

    /// A strip through the slit, which begins on one side at the blade before and ends on the side of `to`, both at a `distance` (m) from its walls.
    pub fn strip_through(&self, to: &Blade, distance: f64) -> [Blade; 2] {
        let aside = self.side(to) * (distance + self.spread) * self.normal;
        [self.behind.moved(-aside), self.blade.moved(aside)]
    }

    /// The side of the slit that a blade is on, 1 or -1.
    fn side(&self, blade: &Blade) -> f64 {
        if self.height(blade) < 0.0 { -1.0 } else { 1.0 }
    }

    /// Height of a blade above the walls, m.
    fn height(&self, blade: &Blade) -> f64 {
        self.middle.way(&self.blade, blade).dot(&self.normal)
    }
}
