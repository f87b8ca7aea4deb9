//! The tip of a tool on sheets, and whether a vertex meets it.

use super::proxy::Friction;
use crate::shape::OrientedShape;
use pliant_solver::Vec3;

/// The tip of a tool at the end of a step.
#[derive(Clone, Debug)]
pub struct Tip {
    /// Centre, m.
    pub position: Vec3,
    /// Velocity of the centre, m/s.
    pub velocity: Vec3,
    /// Angular velocity, rad/s; zero for a round shape.
    pub spin: Vec3,
    /// Shape, as it is turned at the end of the step.
    pub shape: OrientedShape,
    /// Friction on the sheet.
    pub friction: Friction,
    /// Share of the speed at which a vertex meets it that the vertex leaves with (Newton 1687).
    pub restitution: f64,
    /// Whether it constrains vertices; a soft tip does not.
    pub holds: bool,
    /// Force on it in the last step, N.
    pub force: Vec3,
    /// Vertices it constrained in the last step.
    pub held: usize,
}

impl Tip {
    /// Velocity of the tip at a place, m/s.
    pub fn velocity_at(&self, x: Vec3) -> Vec3 {
        if self.spin == Vec3::zeros() { self.velocity } else { self.velocity + self.spin.cross(&(x - self.position)) }
    }

    /// How far along `normal` a place has to move to be on the tangent plane of the tip with that normal, m; negative outside.
    pub(super) fn depth(&self, x: Vec3, normal: Vec3) -> f64 {
        self.shape.support(normal) - (x - self.position).dot(&normal)
    }

    /// Length that moves are compared with, m.
    pub(super) fn length_scale(&self) -> f64 {
        self.shape.shape().length_scale()
    }
}

/// A place where a fingertip was pressed.
#[derive(Clone, Copy, Debug)]
pub struct Press {
    /// Index of the tip.
    pub tip: usize,
    /// Unit vector out of the tip.
    pub direction: Vec3,
    /// Force along it, N.
    pub size: f64,
    /// Velocity of the surface relative to the tip, m/s.
    pub slip: Vec3,
}

/// Length scales: what moves further in a step is looked for on its way.
pub(super) const SWEEP: f64 = 0.5;

/// A vertex in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Position before the step, m.
    pub x: Vec3,
    /// Velocity in the step, m/s.
    pub v: Vec3,
}

/// The normal at which a vertex meets a tip in a step, if it does: where it is inside of the tip at the end of the step, or, if it moves far
/// relative to the tip, where it comes in on its way. A vertex that touched before may be off by a `gap`, m.
pub(super) fn meets(tip: &Tip, vertex: Vertex, dt: f64, gap: Option<f64>) -> Option<Vec3> {
    let Vertex { x, v } = vertex;
    let drive = tip.velocity_at(x);
    let way = (v - drive) * dt;
    let end = x - tip.position;
    let (margin, before) = (gap.unwrap_or(0.0), gap.is_some());
    let normal = |at: Vec3| tip.shape.normal(at).unwrap_or_else(Vec3::z);
    if goes_far(tip, vertex, dt) {
        // Relative to the tip, from where it was when the step began.
        let start = end + drive * dt;
        if let Some(s) = tip.shape.first_hit(start, way, margin) {
            return Some(normal(start + s * way));
        }
    }
    // A constrained vertex moves with the tip. Another is judged at its end: one that leaves by itself is not constrained.
    let end = if before && !goes_far(tip, Vertex { x, v: Vec3::zeros() }, dt) { end } else { end + v * dt };
    tip.shape.contains(end, margin).then(|| normal(end))
}

/// Whether a vertex moves so far relative to a tip in a step that it is looked for on its way.
pub(super) fn goes_far(tip: &Tip, vertex: Vertex, dt: f64) -> bool {
    let way = (vertex.v - tip.velocity_at(vertex.x)) * dt;
    way.norm() > SWEEP * tip.length_scale()
}

/// Whether a vertex that was free slides past a tip faster than friction could stop within a step, by the impulse it takes to give that vertex
/// alone the normal velocity `target`, m/s: it starts without friction.
pub(super) fn slips(tip: &Tip, vertex: Vertex, normal: Vec3, target: f64) -> bool {
    let v = vertex.v;
    let past = v - tip.velocity_at(vertex.x);
    let slip = past - past.dot(&normal) * normal;
    let turn = (target - v.dot(&normal)).max(0.0);
    slip.norm() > tip.friction.sliding * turn
}
