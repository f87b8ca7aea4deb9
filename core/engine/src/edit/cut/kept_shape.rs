//! Where a blade is in the rest shape of a solid whose shape was changed by edits and kept.

use super::middle::ball_around;
use crate::body::{Body, Lattice, LatticeError, NearestTriangle, interpolate, nearest_triangle};
use pliant_cut::Blade;
use pliant_mesh::geometry::meet;
use pliant_plugin_api::abi::Ball;
use pliant_solver::Vec3;

/// A solid that edits have left in another shape than that of its file.
pub struct KeptShape<'a> {
    body: &'a Body,
    lattice: &'a Lattice,
}

/// A point of the settled shape, on or beside a blade.
#[derive(Clone, Copy)]
struct NearPoint {
    /// Where on the blade it is nearest to, as a share of the way from tip to heel.
    share: f64,
    /// Distance from the blade, m.
    distance: f64,
    /// Displacement from the rest shape of the file, m.
    displacement: Vec3,
}

/// Number of places along a blade from which the nearest point of the skin is found.
const PLACES: usize = 17;
/// Largest distance of such a point from its place, in cell edges: with the weights below, farther ones count less than a thousandth of what the blade goes through.
const REACH: f64 = 8.0;
/// Distance from a blade at which a point has half the weight of one on it, in cell edges.
const HALF_WEIGHT: f64 = 0.25;
/// Spread of points along a blade below which they do not tell how it turns, in cell edges.
const LEAST_SPREAD: f64 = 0.1;
/// Iterations from a place of the settled shape to the rest shape, inside of the body.
const ITERATIONS: usize = 8;
/// Largest last change of them, in cell edges.
const TOLERANCE: f64 = 0.05;

impl<'a> KeptShape<'a> {
    /// The shape of a body; `None` if it is that of the file.
    pub fn of(body: &'a Body, lattice: &'a Lattice) -> Option<Self> {
        lattice.has_rest_offsets().then_some(Self { body, lattice })
    }

    /// The straight blade in the rest shape that is closest to a blade in the settled shape, end for end.
    ///
    /// A straight blade in the settled shape is curved in the rest shape. This one subtracts a displacement that is linear along the blade, fitted to those of the skin where the blade
    /// goes through it and beside it, with weights that fall with the square of the distance (moving least squares, Lancaster and Salkauskas 1981). So it changes
    /// steadily as the blade enters a part of the body or leaves it.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn at_rest(&self, blade: &Blade) -> Result<Blade, LatticeError> {
        let mut points = self.crossings(blade);
        points.extend(self.beside(blade, PLACES, REACH * self.lattice.edge()));
        if points.is_empty() {
            points.extend(self.beside(blade, 1, f64::INFINITY));
        }
        for (share, end) in [(0.0, blade.tip), (1.0, blade.heel)] {
            let inside = self.displacement_inside(end)?;
            points.extend(inside.map(|displacement| NearPoint { share, distance: 0.0, displacement }));
        }
        let (way, edge) = (blade.heel - blade.tip, self.lattice.edge());
        let weight = |point: &NearPoint| 1.0 / (point.distance.powi(2) + (HALF_WEIGHT * edge).powi(2));
        let all: f64 = points.iter().map(weight).sum();
        if all == 0.0 {
            return Ok(*blade);
        }
        let middle = points.iter().map(|p| weight(p) * p.share).sum::<f64>() / all;
        let mean = points.iter().map(|p| weight(p) * p.displacement).sum::<Vec3>() / all;
        let spread: f64 = points.iter().map(|p| weight(p) * (p.share - middle).powi(2)).sum();
        let least = all * (LEAST_SPREAD * edge).powi(2) / way.norm_squared();
        let slope = points.iter().map(|p| weight(p) * (p.share - middle) * p.displacement).sum::<Vec3>();
        let displacement = |share: f64| mean + (share - middle) / (spread + least) * slope;
        Ok(Blade { tip: blade.tip - displacement(0.0), heel: blade.heel - displacement(1.0) })
    }

    /// A blade without what is far beside the body: how one turns that is much longer than the body says little of its ends.
    pub fn shortened(&self, blade: &Blade) -> Blade {
        let [tip, heel] = self.range(blade).map(|share| blade.tip.lerp(&blade.heel, share));
        Blade { tip, heel }
    }

    /// The part of a blade that is in the ball around the body, as shares of its length; all of it where none is.
    fn range(&self, blade: &Blade) -> [f64; 2] {
        let Ball { centre, radius } = ball_around(self.lattice);
        let way = blade.heel - blade.tip;
        let middle = (Vec3::from(centre) - blade.tip).dot(&way) / way.norm_squared();
        let reach = radius / way.norm();
        let (from, to) = ((middle - reach).max(0.0), (middle + reach).min(1.0));
        if from < to { [from, to] } else { [0.0, 1.0] }
    }

    /// Where a blade goes through the skin of the settled shape.
    fn crossings(&self, blade: &Blade) -> Vec<NearPoint> {
        let (skin, triangles) = (&self.body.skin, &self.body.model.surface.triangles);
        let way = blade.heel - blade.tip;
        let mut found = Vec::new();
        skin.tree.along(blade.tip, blade.heel, |triangle| {
            if self.body.cut.as_ref().is_some_and(|mesh| mesh.is_cap(triangle)) {
                return;
            }
            let corners = triangles[triangle as usize].map(|v| skin.settled[v as usize]);
            if let Some((share, bary)) = meet(corners, blade.tip, way).filter(|(share, _)| *share <= 1.0) {
                found.push(NearPoint { share, distance: 0.0, displacement: self.displacement_of(triangle, bary) });
            }
        });
        // Sums must not depend on the order of the tree.
        found.sort_by(|a, b| a.share.total_cmp(&b.share));
        found
    }

    /// Points of the skin that are nearest to places along a blade, up to a distance from them (m).
    fn beside(&self, blade: &Blade, places: usize, reach: f64) -> impl Iterator<Item = NearPoint> {
        let (way, [from, to]) = (blade.heel - blade.tip, self.range(blade));
        (0..places).filter_map(move |i| {
            let place = blade.tip + (from + (to - from) * (i as f64 + 0.5) / places as f64) * way;
            let (point, displacement) = self.nearest(place, reach)?;
            let share = ((point - blade.tip).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            Some(NearPoint { share, distance: (blade.tip + share * way - point).norm(), displacement })
        })
    }

    /// The point of the skin nearest to a place of the settled shape, and its displacement, m; `None` if it is farther than `reach` (m).
    fn nearest(&self, place: Vec3, reach: f64) -> Option<(Vec3, Vec3)> {
        let (skin, model) = (&self.body.skin, &self.body.model);
        let NearestTriangle { triangle, bary } =
            nearest_triangle(&skin.tree, model, &skin.settled, place, self.lattice.edge(), reach)?;
        let corners = model.surface.triangles[triangle as usize].map(|v| skin.settled[v as usize]);
        Some((interpolate(corners, bary), self.displacement_of(triangle, bary)))
    }

    /// Displacement of a point of a triangle, m.
    fn displacement_of(&self, triangle: u32, bary: Vec3) -> Vec3 {
        let corners = self.body.model.surface.triangles[triangle as usize];
        let (settled, rest) = (&self.body.skin.settled, &self.body.model.surface.points);
        interpolate(corners.map(|v| settled[v as usize] - rest[v as usize]), bary)
    }

    /// Displacement of the material at a place of the settled shape (m), m; `None` outside of the body and of its active cells.
    fn displacement_inside(&self, place: Vec3) -> Result<Option<Vec3>, LatticeError> {
        let Some(mesh) = &self.body.cut else { return Ok(None) };
        let (mut moved, mut gap) =
            (self.nearest(place, REACH * self.lattice.edge()).map_or_else(Vec3::zeros, |(_, by)| by), f64::INFINITY);
        for _ in 0..ITERATIONS {
            if self.lattice.cell_of(place - moved)?.is_none() {
                return Ok(None);
            }
            let next = self.lattice.rest_offset_at(place - moved)?;
            (gap, moved) = ((next - moved).amax(), next);
        }
        Ok((gap <= TOLERANCE * self.lattice.edge() && mesh.encloses(place - moved)).then_some(moved))
    }
}
