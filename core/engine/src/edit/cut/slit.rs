//! A blade in the slit of an earlier cut: it goes along there and cuts nothing.
//!
//! Two cuts a hair's breadth apart are no use to anyone: where their walls meet, crumbs are left. So a blade that goes along with an earlier cut, closer to it than what
//! the lattice can tell apart, is in that one's slit. Where it comes into the slit and where it leaves it, a strip through the wall joins both cuts, so that no
//! neck is left between them.

use super::body_stroke::{midpoint, midpoint_displacement};
use pliant_cut::{Blade, CutMesh};
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
    /// Outside of the body.
    Air,
    /// A cut of its own.
    Material,
}

/// A blade in a slit.
#[derive(Clone, Copy)]
pub struct Slit {
    /// The blade, moved onto the walls of the cut.
    pub blade: Blade,
    /// The blade before in the same slit, or else this one.
    pub behind: Blade,
    /// Unit normal of the strip to the blade.
    normal: Vec3,
    /// Largest distance of a point of the moved blade from the walls, m.
    spread: f64,
}

/// Largest distance from a cut at which a blade is in its slit, in cell edges, and least cosine between the normals of its strip and of the walls: of a blade that is in
/// it already, of one that comes from outside of the body, and of one that is in a cut of its own. A blade whose path in the rest shape wanders stays; and what
/// the mesh cuts well, lines that cross and slices of more than a tenth of a cell, is left to it.
const LIMITS: [[f64; 2]; 3] = [[0.35, 0.0], [0.08, 0.95], [0.03, 0.9995]];
/// Distance from a wall's triangles, along them, up to which a point is beside them and not beyond the end of the cut, in cell edges: walls have small triangles that are askew.
const BESIDE: f64 = 0.02;
/// Distance between points of the blade, in cell edges.
const SPACING: f64 = 0.5;
/// Most points of a blade.
const MAX_POINTS: usize = 1024;

impl Surroundings {
    /// Where the blade `to` is, which has come from `from` and that `origin`, in the rest shape of a body with cells of `edge` (m).
    pub fn of(mesh: &CutMesh, origin: Origin, [from, to]: [&Blade; 2], edge: f64) -> Self {
        let [reach, least_cosine] = LIMITS[origin as usize];
        let reach = reach * edge;
        let along = to.heel - to.tip;
        let Some(normal) = along.cross(&midpoint_displacement(from, to)).try_normalize(0.0) else {
            return Self::Material;
        };
        let count = ((along.norm() / (SPACING * edge)).ceil() as usize).clamp(2, MAX_POINTS);
        let mut heights = Vec::new();
        for i in 0..=count {
            let point = to.tip.lerp(&to.heel, i as f64 / count as f64);
            if let Some((wall, wall_normal)) = mesh.nearest_cap(point, reach) {
                let offset = point - wall;
                let slide = offset - offset.dot(&wall_normal) * wall_normal;
                if slide.norm() <= BESIDE * edge && wall_normal.dot(&normal).abs() >= least_cosine {
                    heights.push(offset.dot(&normal));
                    continue;
                }
            }
            if mesh.encloses(point) {
                return Self::Material;
            }
        }
        if heights.is_empty() {
            return Self::Air;
        }
        let mean = heights.iter().sum::<f64>() / heights.len() as f64;
        let spread = heights.iter().fold(0.0_f64, |spread, height| spread.max((height - mean).abs()));
        let blade = to.moved(-mean * normal);
        Self::Slit(Slit { blade, behind: blade, normal, spread })
    }
}

impl Slit {
    /// A blade beyond the walls of the slit, by `distance` (m), as seen from another one.
    pub fn beyond(&self, from: &Blade, distance: f64) -> Blade {
        self.blade.moved(-self.side(from) * (distance + self.spread) * self.normal)
    }

    /// A strip through the slit, which begins on one side at the blade before and ends on the side of `to`, both at a `distance` (m) from its walls.
    pub fn strip_through(&self, to: &Blade, distance: f64) -> [Blade; 2] {
        let aside = self.side(to) * (distance + self.spread) * self.normal;
        [self.behind.moved(-aside), self.blade.moved(aside)]
    }

    /// The side of the slit that a blade is on, 1 or -1.
    fn side(&self, blade: &Blade) -> f64 {
        let height = (midpoint(blade) - midpoint(&self.blade)).dot(&self.normal);
        if height < 0.0 { -1.0 } else { 1.0 }
    }
}
