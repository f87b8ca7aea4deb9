//! Where a blade meets a sheet.
//!
//! A sheet may be far from its rest shape and turned against it, and a blade crosses it in one place. So the blade is brought
//! back with the triangle there: by where it meets it, and by how the triangle has turned.

use crate::body::{Body, Sheet, interpolate};
use nalgebra::Matrix3;
use pliant_cut::Blade;
use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;

/// Where a blade is on a sheet.
pub struct Meeting {
    /// The blade in the rest shape, as much of it as is near.
    pub blade: Blade,
    /// m, settled place where it goes through, or the one closest to it
    pub place: Vec3,
    /// Whether it goes through.
    pub through: bool,
    /// In a gap that a cut has opened: where it is in the rest shape, there is the sheet.
    pub in_gap: bool,
    /// From the rest shape to now.
    pub turn: Matrix3<f64>,
}

/// Edges away from it up to which a blade is looked at with the sheet.
const REACH: f64 = 4.0;
/// Edges on either side of the sheet that a blade across it is looked at.
const AROUND: f64 = 2.0;
/// Sine of the angle to the sheet from which a blade is across it.
const ACROSS: f64 = 0.5;
/// Places along the blade from which the closest one is sought.
const PLACES: usize = 9;

impl Meeting {
    /// Of a blade from `tip` to `heel`, m, that was at the settled place `last`; `None` far from the sheet.
    pub fn find(tip: Vec3, heel: Vec3, body: &Body, sheet: &Sheet, last: Option<Vec3>) -> Option<Self> {
        let way = heel - tip;
        let (triangle, along, bary, through) = pierced(tip, way, body, sheet, last)
            .map(|(t, s, bary)| (t, s, bary, true))
            .or_else(|| closest(tip, way, body, sheet).map(|(t, s, bary)| (t, s, bary, false)))?;
        let vertices = body.model.surface.triangles[triangle as usize];
        let rest = vertices.map(|v| body.model.surface.points[v as usize]);
        let now = sheet.nodes_of(&body.model, triangle).map(|n| body.system.nodes.x[n as usize]);
        let turn = turn(rest, now)?;
        let (from, to) = (interpolate(now, bary), interpolate(rest, bary));
        let back = |p: Vec3| -> Vec3 { to + turn.transpose() * (p - from) };
        let length = way.norm();
        let normal = turn * normal_of(rest);
        let across = (way / length).dot(&normal).abs() > ACROSS;
        let around = if across { AROUND * sheet.edge() / length } else { f64::INFINITY };
        let end = |s: f64| back(tip + s.clamp(0.0, 1.0) * way);
        let blade = Blade { tip: end(along - around), heel: end(along + around) };
        let place = interpolate(vertices.map(|v| body.skin.settled[v as usize]), bary);
        let in_gap = !through && body.cut.as_ref().is_some_and(|mesh| mesh.is_crossed(blade.tip, blade.heel));
        Some(Self { blade, place, through, in_gap, turn })
    }
}

/// Turns a triangle of the rest shape to where it is now; `None` where it has no area.
fn turn(rest: [Vec3; 3], now: [Vec3; 3]) -> Option<Matrix3<f64>> {
    let frame = |[a, b, c]: [Vec3; 3]| {
        let [a, b, c] = [a, b, c];
        let first = (b - a).try_normalize(0.0)?;
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        let second = normal.cross(&first);
        let flat = [[(b - a).dot(&first), 0.0], [(c - a).dot(&first), (c - a).dot(&second)]];
        Some((Matrix3::from_columns(&[first, second, normal]), flat))
    };
    let ((from, u), (to, w)) = (frame(rest)?, frame(now)?);
    // Of the deformation in the plane, F = W U^-1, the rotation closest to it.
    let (f11, f12) = (w[0][0] / u[0][0], (w[1][0] - w[0][0] / u[0][0] * u[1][0]) / u[1][1]);
    let f22 = w[1][1] / u[1][1];
    let size = ((f11 + f22) * (f11 + f22) + f12 * f12).sqrt();
    let (c, s) = ((f11 + f22) / size, -f12 / size);
    Some(to * Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0) * from.transpose())
}

fn normal_of([a, b, c]: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = [a, b, c];
    (b - a).cross(&(c - a)).normalize()
}

/// The triangle a segment goes through, where along it and with which weights: of several the one closest to where the blade
/// was, or to its tip.
fn pierced(tip: Vec3, way: Vec3, body: &Body, sheet: &Sheet, last: Option<Vec3>) -> Option<(u32, f64, Vec3)> {
    let mut best: Option<(f64, u32, f64, Vec3)> = None;
    for t in 0..body.model.surface.triangles.len() as u32 {
        let corners = sheet.nodes_of(&body.model, t).map(|n| body.system.nodes.x[n as usize]);
        let Some((s, bary)) = pliant_mesh::geometry::meet(corners, tip, way).filter(|(s, _)| *s <= 1.0) else {
            continue;
        };
        let away = last.map_or(s, |last| {
            let place =
                interpolate(body.model.surface.triangles[t as usize].map(|v| body.skin.settled[v as usize]), bary);
            let d = place - last;
            d.norm_squared()
        });
        if best.is_none_or(|(least, ..)| away < least) {
            best = Some((away, t, s, bary));
        }
    }
    best.map(|(_, t, s, bary)| (t, s, bary))
}

/// The triangle closest to a segment, if one is near.
fn closest(tip: Vec3, way: Vec3, body: &Body, sheet: &Sheet) -> Option<(u32, f64, Vec3)> {
    let reach = REACH * sheet.edge();
    let length = way.norm_squared();
    let mut best: Option<(f64, u32, f64, Vec3)> = None;
    for t in 0..body.model.surface.triangles.len() as u32 {
        let corners = sheet.nodes_of(&body.model, t).map(|n| body.system.nodes.x[n as usize]);
        let size = |a: Vec3, b: Vec3| (a - b).norm();
        let from_tip = corners[0] - tip;
        let foot = tip + (from_tip.dot(&way) / length).clamp(0.0, 1.0) * way;
        let own = size(corners[0], corners[1]).max(size(corners[0], corners[2]));
        if size(foot, corners[0]) > best.map_or(reach, |(least, ..)| least) + own + length.sqrt() / PLACES as f64 {
            continue;
        }
        for i in 0..PLACES {
            let s = i as f64 / (PLACES - 1) as f64;
            let at = tip + s * way;
            let near = closest_point(at, corners);
            let away = size(near.point, at);
            if away <= best.map_or(reach, |(least, ..)| least) {
                best = Some((away, t, s, near.bary));
            }
        }
    }
    best.map(|(_, t, s, bary)| (t, s, bary))
}
