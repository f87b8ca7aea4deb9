//! A blade mapped to the rest shape of a body, where it cuts.

use super::kept_shape::KeptShape;
use super::sheet_intersection::SheetIntersection;
use crate::body::{Body, Discretization, Lattice, LatticeError};
use nalgebra::Matrix3;
use pliant_cut::Blade;
use pliant_solver::Vec3;

/// The edge of a blade where it is now.
#[derive(Clone, Copy)]
pub struct BladeLine {
    /// Position of the tip, m.
    pub tip: Vec3,
    /// Unit vector from tip to heel.
    pub along: Vec3,
    /// From tip to heel, m.
    pub length: f64,
}

/// A blade in the rest shape of a body.
pub struct RestBlade {
    /// The edge of the blade, its ends moved by the displacements of the material there, m. Of a solid whose shape was changed and
    /// kept: the straight edge closest to where the edge is at rest, without what is far beside the body.
    pub blade: Blade,
    /// Points along the edge inside of the body, from tip to heel, m (k x 3).
    pub points: Vec<Vec3>,
    /// Position of the tip, m; for a sheet, the tip minus the intersection of blade and sheet.
    pub tip: Vec3,
    /// Whether the blade is in the gap of a cut sheet; the stroke then waits until the blade intersects the sheet again.
    pub in_gap: bool,
    /// Rotation from the rest shape to the current shape.
    pub rotation: Matrix3<f64>,
}

/// Number of sample points along the edge.
pub const SAMPLES: usize = 9;
/// Distance between sample points where a blade leaves a body, in cell edges: what it is in there is shorter than the distance of the others.
const FINE_SPACING: f64 = 0.5;
/// Largest number of fine sample points.
const MAX_FINE: usize = 4096;
/// Largest last change of the fixed-point iteration, in cell edges.
const INVERSION_TOLERANCE: f64 = 0.05;
/// Fixed-point iterations from a current to a rest position.
const INVERSION_ITERATIONS: usize = 6;

impl BladeLine {
    /// The blade in the rest shape of a body, with the sample points inside of its cells or the intersection with a sheet, which was last
    /// intersected at the point `last` of the settled surface (m). Points in the gap between separated parts are inside of neither. A blade that
    /// `cuts` is looked at more closely before it counts as outside. `None` far from a sheet.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn at_rest(&self, body: &Body, last: Option<Vec3>, cuts: bool) -> Result<Option<RestBlade>, LatticeError> {
        let lattice = match &body.discretization {
            Discretization::Lattice(lattice) => lattice,
            Discretization::Sheet(sheet) => {
                let heel = self.tip + self.length * self.along;
                let Some(met) = SheetIntersection::find(self.tip, heel, body, sheet, last) else { return Ok(None) };
                let tip = self.tip - body.embed_point(met.point)?.now;
                let points = if met.intersects { vec![met.point] } else { Vec::new() };
                return Ok(Some(RestBlade {
                    blade: met.blade,
                    points,
                    tip,
                    in_gap: met.in_gap,
                    rotation: met.rotation,
                }));
            }
        };
        let mut rest = self.sample(SAMPLES, lattice, body)?;
        if cuts && rest.points.is_empty() {
            let count = (self.length / (FINE_SPACING * lattice.edge())).ceil() as usize + 1;
            if count > SAMPLES {
                rest = self.sample(count.min(MAX_FINE), lattice, body)?;
                let step = rest.points.len().div_ceil(SAMPLES).max(1);
                rest.points = rest.points.into_iter().step_by(step).collect();
            }
        }
        Ok(Some(rest))
    }

    /// The blade in the rest shape of a lattice, from `count` points along it.
    fn sample(&self, count: usize, lattice: &Lattice, body: &Body) -> Result<RestBlade, LatticeError> {
        let heel = self.tip + self.length * self.along;
        let mut points = Vec::new();
        let (mut first, mut last, mut drift) = (None, Vec3::zeros(), None);
        let kept = KeptShape::of(body, lattice);
        // Where nothing has moved from the settled shape, and where the search for the material begins.
        let line = Blade { tip: self.tip, heel };
        let start = kept.as_ref().map(|kept| kept.at_rest(&line)).transpose()?;
        for i in 0..count {
            let s = self.length * i as f64 / (count - 1) as f64;
            let now = self.tip + s * self.along;
            let settled_at = start.map_or(now, |rest| rest.tip.lerp(&rest.heel, s / self.length));
            // For a body that has moved far, the iteration starts from the mean displacement of its nodes.
            let mut moved = displacement_at(now, settled_at, lattice, body)?;
            if moved.is_none() && lattice.is_whole() {
                let drift = *drift.get_or_insert_with(|| mean_displacement(lattice, body));
                moved = displacement_at(now, now - drift, lattice, body)?;
            }
            let point = moved.map_or(settled_at, |u| now - u);
            if let Some(u) = moved {
                // What moves the material from the settled shape.
                let u = if kept.is_some() { u - lattice.rest_offset_at(point)? } else { u };
                first.get_or_insert(u);
                last = u;
            }
            if lattice.is_occupied(point)? {
                points.push(point);
            }
        }
        let settled = Blade { tip: line.tip - first.unwrap_or_default(), heel: line.heel - last };
        let blade = match (kept, start) {
            (Some(kept), Some(start)) if settled == line => kept.shortened(&start),
            (Some(kept), _) => kept.shortened(&kept.at_rest(&settled)?),
            (None, _) => settled,
        };
        Ok(RestBlade { blade, points, tip: blade.tip, in_gap: false, rotation: Matrix3::identity() })
    }
}

/// Displacement of the material that is now at the position `now`, m, by fixed-point iteration from the rest position `from` (both in m); `None`
/// if there is no material.
fn displacement_at(now: Vec3, from: Vec3, lattice: &Lattice, body: &Body) -> Result<Option<Vec3>, LatticeError> {
    let (mut point, mut moved, mut gap) = (from, None, f64::INFINITY);
    for _ in 0..INVERSION_ITERATIONS {
        let Some(u) = lattice.displacement_at(point, &body.system.nodes)? else { break };
        let before: Option<Vec3> = moved.replace(u);
        point = now - u;
        gap = before.map_or(gap, |before| (u - before).iter().fold(0.0, |g, c| g.max(c.abs())));
    }
    Ok(moved.filter(|_| gap <= INVERSION_TOLERANCE * lattice.edge()))
}

/// Mean displacement of the nodes, m.
pub fn mean_displacement(lattice: &Lattice, body: &Body) -> Vec3 {
    let (nodes, rest) = (&body.system.nodes, &lattice.region().node_rest);
    let sum: Vec3 = nodes.x.iter().zip(rest).map(|(x, rest)| x - Vec3::from(*rest)).sum();
    sum / nodes.len().max(1) as f64
}
