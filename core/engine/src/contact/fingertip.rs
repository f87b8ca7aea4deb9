//! A sphere fingertip, and whether a vertex meets it.

use super::proxy::Friction;
use nalgebra::Vector3;
use pliant_solver::{V3, axpy, dot};

/// A fingertip at the end of a step.
#[derive(Clone, Copy, Debug)]
pub struct Tip {
    /// m, centre
    pub position: V3,
    /// m/s
    pub velocity: V3,
    /// m
    pub radius: f64,
    /// On the sheet.
    pub friction: Friction,
    /// Of the speed at which a vertex meets it, what it leaves with (Newton 1687).
    pub restitution: f64,
    /// Whether it holds vertices, and is not a soft tip.
    pub holds: bool,
    /// N, what the last step did to it
    pub force: V3,
    /// Vertices it held in the last step.
    pub held: usize,
}

/// A place where a fingertip was pressed.
#[derive(Clone, Copy, Debug)]
pub struct Press {
    /// Which tip.
    pub tip: usize,
    /// From its centre, of unit length.
    pub direction: V3,
    /// N, along it
    pub size: f64,
    /// m/s, of the surface past the tip
    pub slip: V3,
}

/// Radii: what moves further in a step is looked for on its way.
pub(super) const SWEEP: f64 = 0.5;

/// The normal at which a vertex that is at `x` and moves with `v` meets a tip in a step, if it does: where it is inside of it when
/// the step ends, or, if it goes far against it, where it comes in on its way. One that touched before may be off by a `gap`, m.
pub(super) fn meets(tip: &Tip, (x, v): (V3, V3), dt: f64, gap: Option<f64>) -> Option<V3> {
    let way = Vector3::from(axpy(v, -1.0, tip.velocity)) * dt;
    let end = Vector3::from(axpy(x, -1.0, tip.position));
    let (reach, before) = (tip.radius + gap.unwrap_or(0.0), gap.is_some());
    if goes_far(tip, v, dt) {
        // Seen from the tip, as it was when the step began: |start + s way| = reach.
        let start = end + Vector3::from(tip.velocity) * dt;
        let (a, b, c) = (way.norm_squared(), start.dot(&way), start.norm_squared() - reach * reach);
        let root = b * b - a * c;
        let s = if c <= 0.0 { 0.0 } else { (-b - root.max(0.0).sqrt()) / a };
        if b < 0.0 && root >= 0.0 && s <= 1.0 {
            return Some((start + s * way).try_normalize(1e-9).unwrap_or_else(Vector3::z).into());
        }
    }
    // One that is held goes with the tip. Another is looked at where it is going: what leaves by itself is not held.
    let end = if before && !goes_far(tip, [0.0; 3], dt) { end } else { end + Vector3::from(v) * dt };
    (end.norm() <= reach).then(|| end.try_normalize(1e-9).unwrap_or_else(Vector3::z).into())
}

/// Whether a tip and a vertex that moves with `v` go so far against each other in a step that the vertex is looked for on its way.
pub(super) fn goes_far(tip: &Tip, v: V3, dt: f64) -> bool {
    let way = axpy(v, -1.0, tip.velocity).map(|c| c * dt);
    dot(way, way).sqrt() > SWEEP * tip.radius
}

/// Whether a vertex that was not held and moves with `v` goes past a tip faster than friction would end in a step, by what it
/// takes to turn the vertex alone: the friction of the step before, none, is what it begins with.
pub(super) fn slips(tip: &Tip, v: V3, normal: V3, target: f64) -> bool {
    let past = axpy(v, -1.0, tip.velocity);
    let slip = axpy(past, -dot(past, normal), normal);
    let turn = (target - dot(v, normal)).max(0.0);
    dot(slip, slip).sqrt() > tip.friction.sliding * turn
}
