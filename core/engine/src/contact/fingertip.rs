//! A sphere fingertip, and whether a vertex meets it.

use super::proxy::Friction;
use pliant_solver::Vec3;

/// A fingertip at the end of a step.
#[derive(Clone, Copy, Debug)]
pub struct Tip {
    /// m, centre
    pub position: Vec3,
    /// m/s
    pub velocity: Vec3,
    /// m
    pub radius: f64,
    /// On the sheet.
    pub friction: Friction,
    /// Of the speed at which a vertex meets it, what it leaves with (Newton 1687).
    pub restitution: f64,
    /// Whether it holds vertices, and is not a soft tip.
    pub holds: bool,
    /// N, what the last step did to it
    pub force: Vec3,
    /// Vertices it held in the last step.
    pub held: usize,
}

/// A place where a fingertip was pressed.
#[derive(Clone, Copy, Debug)]
pub struct Press {
    /// Which tip.
    pub tip: usize,
    /// From its centre, of unit length.
    pub direction: Vec3,
    /// N, along it
    pub size: f64,
    /// m/s, of the surface past the tip
    pub slip: Vec3,
}

/// Radii: what moves further in a step is looked for on its way.
pub(super) const SWEEP: f64 = 0.5;

/// The normal at which a vertex that is at `x` and moves with `v` meets a tip in a step, if it does: where it is inside of it when
/// the step ends, or, if it goes far against it, where it comes in on its way. One that touched before may be off by a `gap`, m.
pub(super) fn meets(tip: &Tip, (x, v): (Vec3, Vec3), dt: f64, gap: Option<f64>) -> Option<Vec3> {
    let way = (v - tip.velocity) * dt;
    let end = x - tip.position;
    let (reach, before) = (tip.radius + gap.unwrap_or(0.0), gap.is_some());
    if goes_far(tip, v, dt) {
        // Seen from the tip, as it was when the step began: |start + s way| = reach.
        let start = end + tip.velocity * dt;
        let (a, b, c) = (way.norm_squared(), start.dot(&way), start.norm_squared() - reach * reach);
        let root = b * b - a * c;
        let s = if c <= 0.0 { 0.0 } else { (-b - root.max(0.0).sqrt()) / a };
        if b < 0.0 && root >= 0.0 && s <= 1.0 {
            return Some((start + s * way).try_normalize(1e-9).unwrap_or_else(Vec3::z));
        }
    }
    // One that is held goes with the tip. Another is looked at where it is going: what leaves by itself is not held.
    let end = if before && !goes_far(tip, Vec3::zeros(), dt) { end } else { end + v * dt };
    (end.norm() <= reach).then(|| end.try_normalize(1e-9).unwrap_or_else(Vec3::z))
}

/// Whether a tip and a vertex that moves with `v` go so far against each other in a step that the vertex is looked for on its way.
pub(super) fn goes_far(tip: &Tip, v: Vec3, dt: f64) -> bool {
    let way = (v - tip.velocity) * dt;
    way.norm() > SWEEP * tip.radius
}

/// Whether a vertex that was not held and moves with `v` goes past a tip faster than friction would end in a step, by what it
/// takes to turn the vertex alone: the friction of the step before, none, is what it begins with.
pub(super) fn slips(tip: &Tip, v: Vec3, normal: Vec3, target: f64) -> bool {
    let past = v - tip.velocity;
    let slip = past - past.dot(&normal) * normal;
    let turn = (target - v.dot(&normal)).max(0.0);
    slip.norm() > tip.friction.sliding * turn
}
