//! The fingertip of a tool on sheets, and collision detection of vertices with it.

use super::proxy::Friction;
use super::tip_motion::TipResponse;
use crate::shape::OrientedShape;
use pliant_solver::Vec3;

/// A fingertip at the end of a step.
#[derive(Clone, Debug)]
pub struct Tip {
    /// Position of the centre, m.
    pub position: Vec3,
    /// Velocity of the centre, m/s.
    pub velocity: Vec3,
    /// Angular velocity, rad/s; zero for a round shape.
    pub spin: Vec3,
    /// Shape, with its orientation at the end of the step.
    pub shape: OrientedShape,
    /// Coefficients of friction between tip and sheet.
    pub friction: Friction,
    /// Coefficient of restitution, 0 to 1 (Newton 1687).
    pub restitution: f64,
    /// Whether it constrains vertices; a soft tip uses springs instead.
    pub constrains: bool,
    /// How its velocity depends on the force of the sheet within the step, if it has a mass; otherwise it moves at `velocity`.
    pub response: Option<TipResponse>,
    /// Force of the sheet at the end of the step, N, that its velocity follows from; `None` where the velocity was left as it was foreseen.
    pub implicit_force: Option<Vec3>,
    /// Force on it in the last step, N.
    pub force: Vec3,
    /// Number of vertices it constrained in the last step.
    pub constrained: usize,
}

impl Tip {
    /// Velocity of the tip, as a rigid body, at the position `x` (m), in m/s.
    pub fn velocity_at(&self, x: Vec3) -> Vec3 {
        if self.spin == Vec3::zeros() { self.velocity } else { self.velocity + self.spin.cross(&(x - self.position)) }
    }

    /// Distance along the unit vector `normal` from `x` to the tip's tangent plane with that normal, m; negative if `x` is outside of that plane.
    pub(super) fn depth(&self, x: Vec3, normal: Vec3) -> f64 {
        self.shape.support(normal) - (x - self.position).dot(&normal)
    }

    /// Length scale of the shape, m; the radius of a sphere.
    pub(super) fn length_scale(&self) -> f64 {
        self.shape.shape().length_scale()
    }
}

/// A contact point of a fingertip, for tactile arrays.
#[derive(Clone, Copy, Debug)]
pub struct Press {
    /// Index of the tip.
    pub tip: usize,
    /// Unit outward normal of the tip.
    pub direction: Vec3,
    /// Normal force, N.
    pub force: f64,
    /// Tangential velocity of the surface relative to the tip, m/s.
    pub slip: Vec3,
}

/// Displacement in a step, in length scales of the tip, above which collision detection is continuous: half a radius cannot pass a tip.
pub(super) const SWEEP: f64 = 0.5;

/// A vertex in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Position before the step, m.
    pub x: Vec3,
    /// Velocity in the step, m/s.
    pub v: Vec3,
}

/// The outward normal of the tip at which a vertex collides with it in a step of `dt` (s); `None` without a collision. A vertex collides if it is
/// inside of the tip at the end of the step or, if it moves far relative to the tip, where its path enters the tip. A vertex that was in
/// contact in the last step also collides within a distance of `gap` (m).
pub(super) fn contact_normal(tip: &Tip, vertex: Vertex, dt: f64, gap: Option<f64>) -> Option<Vec3> {
    let Vertex { x, v } = vertex;
    let drive = tip.velocity_at(x);
    let way = (v - drive) * dt;
    let end = x - tip.position;
    let (margin, before) = (gap.unwrap_or(0.0), gap.is_some());
    let normal = |at: Vec3| tip.shape.normal(at).unwrap_or_else(Vec3::z);
    if goes_far(tip, vertex, dt) {
        // Position of the vertex relative to the tip at the beginning of the step.
        let start = end + drive * dt;
        if let Some(s) = tip.shape.first_hit(start, way, margin) {
            return Some(normal(start + s * way));
        }
    }
    // A vertex in contact moves with the tip. Any other is tested at its position at the end of the step, so a separating vertex is not caught.
    let end = if before && !goes_far(tip, Vertex { x, v: Vec3::zeros() }, dt) { end } else { end + v * dt };
    tip.shape.contains(end, margin).then(|| normal(end))
}

/// Whether a vertex moves so far relative to a tip in a step of `dt` (s) that it needs continuous collision detection.
pub(super) fn goes_far(tip: &Tip, vertex: Vertex, dt: f64) -> bool {
    let way = (vertex.v - tip.velocity_at(vertex.x)) * dt;
    way.norm() > SWEEP * tip.length_scale()
}

/// Whether a vertex without previous contact starts sliding: its tangential speed exceeds what friction can stop in a step, by the impulse that
/// gives this vertex alone the normal velocity `target` (m/s).
pub(super) fn starts_sliding(tip: &Tip, vertex: Vertex, normal: Vec3, target: f64) -> bool {
    let v = vertex.v;
    let past = v - tip.velocity_at(vertex.x);
    let slip = past - past.dot(&normal) * normal;
    let turn = (target - v.dot(&normal)).max(0.0);
    slip.norm() > tip.friction.kinetic_coefficient * turn
}
