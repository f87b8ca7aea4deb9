//! Intersection of a blade with a sheet.
//!
//! A sheet may be far from its rest shape and rotated relative to it, and a blade intersects it in one point. The blade is therefore mapped to
//! the rest shape with the triangle it intersects: by the intersection point and by the rotation of the triangle.

use crate::body::{Body, Sheet, interpolate};
use nalgebra::Matrix3;
use pliant_cut::Blade;
use pliant_mesh::geometry::closest_point;
use pliant_solver::Vec3;

/// A blade on or near a sheet.
pub struct SheetIntersection {
    /// The part of the blade near the sheet, in the rest shape.
    pub blade: Blade,
    /// Intersection point, or the point of the sheet closest to the blade, in the settled surface, m.
    pub point: Vec3,
    /// Whether the blade intersects the sheet.
    pub intersects: bool,
    /// Whether the blade is in the gap of a cut: it intersects no triangle, but the sheet is there in the rest shape.
    pub in_gap: bool,
    /// Rotation from the rest shape to the current shape.
    pub rotation: Matrix3<f64>,
}

/// Distance up to which a blade counts as near the sheet, in mean edges.
const REACH: f64 = 4.0;
/// Length of the blade that is kept on either side of the sheet if the blade is steep, in mean edges.
const HALF_LENGTH: f64 = 2.0;
/// Sine of the angle between blade and sheet above which the blade is steep.
const STEEP: f64 = 0.5;
/// Number of points along the blade at which its distance from a triangle is computed.
const SAMPLES: usize = 9;

impl SheetIntersection {
    /// Finds a blade from `tip` to `heel` on the sheet, which last intersected it at the point `last` of the settled surface (all in m); `None`
    /// far from the sheet.
    pub fn find(tip: Vec3, heel: Vec3, body: &Body, sheet: &Sheet, last: Option<Vec3>) -> Option<Self> {
        let way = heel - tip;
        let (triangle, along, bary, intersects) = intersected_triangle(tip, way, body, sheet, last)
            .map(|(t, s, bary)| (t, s, bary, true))
            .or_else(|| closest_triangle(tip, way, body, sheet).map(|(t, s, bary)| (t, s, bary, false)))?;
        let vertices = body.model.surface.triangles[triangle as usize];
        let rest = vertices.map(|v| body.model.surface.points[v as usize]);
        let now = sheet.nodes_of(&body.model, triangle).map(|n| body.system.nodes.x[n as usize]);
        let rotation = rotation(rest, now)?;
        let (from, to) = (interpolate(now, bary), interpolate(rest, bary));
        let to_rest = |p: Vec3| -> Vec3 { to + rotation.transpose() * (p - from) };
        let length = way.norm();
        let normal = rotation * normal_of(rest);
        let steep = (way / length).dot(&normal).abs() > STEEP;
        let half_length = if steep { HALF_LENGTH * sheet.edge() / length } else { f64::INFINITY };
        let end = |s: f64| to_rest(tip + s.clamp(0.0, 1.0) * way);
        let blade = Blade { tip: end(along - half_length), heel: end(along + half_length) };
        let point = interpolate(vertices.map(|v| body.skin.settled[v as usize]), bary);
        let in_gap = !intersects && body.cut.as_ref().is_some_and(|mesh| mesh.is_crossed(blade.tip, blade.heel));
        Some(Self { blade, point, intersects, in_gap, rotation })
    }
}

/// Rotation of a triangle from the rest shape to the current shape: the polar factor of its deformation gradient in the plane, with the
/// rotation of its plane. `None` for a degenerate triangle.
fn rotation(rest: [Vec3; 3], now: [Vec3; 3]) -> Option<Matrix3<f64>> {
    let frame = |[a, b, c]: [Vec3; 3]| {
        let [a, b, c] = [a, b, c];
        let first = (b - a).try_normalize(0.0)?;
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
        let second = normal.cross(&first);
        let flat = [[(b - a).dot(&first), 0.0], [(c - a).dot(&first), (c - a).dot(&second)]];
        Some((Matrix3::from_columns(&[first, second, normal]), flat))
    };
    let ((from, u), (to, w)) = (frame(rest)?, frame(now)?);
    // The rotation closest to the plane deformation gradient F = W U^-1.
    let (f11, f12) = (w[0][0] / u[0][0], (w[1][0] - w[0][0] / u[0][0] * u[1][0]) / u[1][1]);
    let f22 = w[1][1] / u[1][1];
    let size = ((f11 + f22) * (f11 + f22) + f12 * f12).sqrt();
    let (c, s) = ((f11 + f22) / size, -f12 / size);
    Some(to * Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0) * from.transpose())
}

/// Unit normal of a triangle.
fn normal_of([a, b, c]: [Vec3; 3]) -> Vec3 {
    let [a, b, c] = [a, b, c];
    (b - a).cross(&(c - a)).normalize()
}

/// The triangle that a segment intersects, the parameter along the segment (0 to 1) and the barycentric coordinates. Of several triangles it is
/// the one closest to the last intersection, or to the tip if there is none.
fn intersected_triangle(
    tip: Vec3,
    way: Vec3,
    body: &Body,
    sheet: &Sheet,
    last: Option<Vec3>,
) -> Option<(u32, f64, Vec3)> {
    let mut best: Option<(f64, u32, f64, Vec3)> = None;
    for t in 0..body.model.surface.triangles.len() as u32 {
        let corners = sheet.nodes_of(&body.model, t).map(|n| body.system.nodes.x[n as usize]);
        let Some((s, bary)) = pliant_mesh::geometry::meet(corners, tip, way).filter(|(s, _)| *s <= 1.0) else {
            continue;
        };
        let away = last.map_or(s, |last| {
            let point =
                interpolate(body.model.surface.triangles[t as usize].map(|v| body.skin.settled[v as usize]), bary);
            let d = point - last;
            d.norm_squared()
        });
        if best.is_none_or(|(least, ..)| away < least) {
            best = Some((away, t, s, bary));
        }
    }
    best.map(|(_, t, s, bary)| (t, s, bary))
}

/// The triangle closest to a segment, as [`intersected_triangle`] returns it; `None` if all are beyond the reach.
fn closest_triangle(tip: Vec3, way: Vec3, body: &Body, sheet: &Sheet) -> Option<(u32, f64, Vec3)> {
    let reach = REACH * sheet.edge();
    let length = way.norm_squared();
    let mut best: Option<(f64, u32, f64, Vec3)> = None;
    for t in 0..body.model.surface.triangles.len() as u32 {
        let corners = sheet.nodes_of(&body.model, t).map(|n| body.system.nodes.x[n as usize]);
        let size = |a: Vec3, b: Vec3| (a - b).norm();
        let from_tip = corners[0] - tip;
        let foot = tip + (from_tip.dot(&way) / length).clamp(0.0, 1.0) * way;
        let own = size(corners[0], corners[1]).max(size(corners[0], corners[2]));
        if size(foot, corners[0]) > best.map_or(reach, |(least, ..)| least) + own + length.sqrt() / SAMPLES as f64 {
            continue;
        }
        for i in 0..SAMPLES {
            let s = i as f64 / (SAMPLES - 1) as f64;
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
