//! Where a blade is in the rest shape of a solid whose shape was changed by edits and kept.

use super::middle::ball_around;
use crate::body::{Body, Lattice, LatticeError, interpolate};
use pliant_cut::Blade;
use pliant_mesh::geometry::{Closest, closest_point, meet};
use pliant_plugin_api::abi::Ball;
use pliant_solver::Vec3;

/// A solid that edits have left in another shape than that of its file.
pub struct KeptShape<'a> {
    body: &'a Body,
    lattice: &'a Lattice,
}

/// Displacement by edits beside a place of a blade.
#[derive(Clone, Copy)]
struct Kept {
    /// Share of the way from tip to heel.
    share: f64,
    /// Distance from the blade, m.
    distance: f64,
    /// From the rest shape of the file to the settled shape, m.
    by: Vec3,
}

/// Number of places along a blade from which the nearest skin is found.
const PLACES: usize = 17;
/// Distance of the skin from a blade at which it counts half as much as where the blade goes through it, in cell edges.
const NEAR: f64 = 0.25;
/// Spread of places along a blade that does not tell how it turns, in cell edges.
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

    /// The blade in the rest shape, but for what of it is far beside the body. A straight blade is bent there. The straight one that comes nearest goes through the skin, and past it, at
    /// the same points: their displacements are fitted by a linear one, with weights that fall with the square of the distance from the blade (moving least squares, Lancaster
    /// and Salkauskas 1981), so it changes steadily as the blade goes into a part of the body and out of it.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn at_rest(&self, blade: &Blade) -> Result<Blade, LatticeError> {
        let mut kept = self.crossings(blade);
        kept.extend(self.beside(blade));
        for (share, end) in [(0.0, blade.tip), (1.0, blade.heel)] {
            kept.extend(self.displacement_inside(end)?.map(|by| Kept { share, distance: 0.0, by }));
        }
        let (way, edge) = (blade.heel - blade.tip, self.lattice.edge());
        let weight = |kept: &Kept| 1.0 / (kept.distance.powi(2) + (NEAR * edge).powi(2));
        let all: f64 = kept.iter().map(weight).sum();
        if all == 0.0 {
            return Ok(*blade);
        }
        let mean: f64 = kept.iter().map(|k| weight(k) * k.share).sum::<f64>() / all;
        let by: Vec3 = kept.iter().map(|k| weight(k) * k.by).sum::<Vec3>() / all;
        let spread: f64 = kept.iter().map(|k| weight(k) * (k.share - mean).powi(2)).sum();
        let least = all * (LEAST_SPREAD * edge).powi(2) / way.norm_squared();
        let turn: Vec3 = kept.iter().map(|k| weight(k) * (k.share - mean) * k.by).sum::<Vec3>() / (spread + least);
        let at = |share: f64| blade.tip + share * way - (by + (share - mean) * turn);
        let whole = Blade { tip: at(0.0), heel: at(1.0) };
        let [from, to] = self.range(&whole);
        Ok(Blade { tip: at(from), heel: at(to) })
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
    fn crossings(&self, blade: &Blade) -> Vec<Kept> {
        let (skin, triangles) = (&self.body.skin, &self.body.model.surface.triangles);
        let way = blade.heel - blade.tip;
        let mut found = Vec::new();
        skin.tree.along(blade.tip, blade.heel, |triangle| {
            if self.body.cut.as_ref().is_some_and(|mesh| mesh.is_cap(triangle)) {
                return;
            }
            let corners = triangles[triangle as usize].map(|v| skin.settled[v as usize]);
            if let Some((share, bary)) = meet(corners, blade.tip, way).filter(|(share, _)| *share <= 1.0) {
                found.push(Kept { share, distance: 0.0, by: self.displacement_of(triangle, bary) });
            }
        });
        // The tree's order is no order of the blade.
        found.sort_by(|a, b| a.share.total_cmp(&b.share));
        found
    }

    /// Points of the skin beside a blade, where they are nearest to it.
    fn beside(&self, blade: &Blade) -> impl Iterator<Item = Kept> {
        let (way, [from, to]) = (blade.heel - blade.tip, self.range(blade));
        (0..PLACES).filter_map(move |i| {
            let place = blade.tip + (from + (to - from) * i as f64 / (PLACES - 1) as f64) * way;
            let (point, by) = self.nearest(place)?;
            let share = ((point - blade.tip).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            Some(Kept { share, distance: (blade.tip + share * way - point).norm(), by })
        })
    }

    /// Displacement of the skin that is nearest to a place of the settled shape (m), m; zero without a surface.
    pub fn displacement_near(&self, place: Vec3) -> Vec3 {
        self.nearest(place).map_or_else(Vec3::zeros, |(_, by)| by)
    }

    /// The point of the skin nearest to a place of the settled shape, and its displacement, m.
    fn nearest(&self, place: Vec3) -> Option<(Vec3, Vec3)> {
        let (skin, triangles) = (&self.body.skin, &self.body.model.surface.triangles);
        let mut nearest: Option<(f64, u32, Closest)> = None;
        skin.tree.near_within(place, f64::INFINITY, |triangle| {
            let closest = closest_point(place, triangles[triangle as usize].map(|v| skin.settled[v as usize]));
            let distance = (closest.point - place).norm();
            if nearest.is_none_or(|(least, of, _)| (distance, triangle) < (least, of)) {
                nearest = Some((distance, triangle, closest));
            }
            nearest.map_or(f64::INFINITY, |(least, ..)| least)
        });
        nearest.map(|(_, triangle, closest)| (closest.point, self.displacement_of(triangle, closest.bary)))
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
        let (mut by, mut gap) = (self.displacement_near(place), f64::INFINITY);
        for _ in 0..ITERATIONS {
            if self.lattice.cell_of(place - by)?.is_none() {
                return Ok(None);
            }
            let next = self.lattice.rest_offset_at(place - by)?;
            (gap, by) = ((next - by).amax(), next);
        }
        Ok((gap <= TOLERANCE * self.lattice.edge() && mesh.encloses(place - by)).then_some(by))
    }
}
