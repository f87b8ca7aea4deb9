//! The proxy (god-object): the pose of the tool that does not penetrate the surface.
//!
//! The proxy is a convex shape that stays outside of the surface (Zilles and Salisbury 1995; with a radius: Ruspini, Kolarov and Khatib 1997).
//! In a step it first moves with the surface at its contact point, then towards the hand as far as the separating planes of nearby points
//! allow. It has the orientation of the hand. Each move is at most half its length scale, so it passes through nothing. Friction and the
//! penetration of the elastic layer are computed afterwards.

use super::near::SurfacePoint;
use super::triangle_point::TrianglePoint;
use crate::shape::OrientedShape;
use pliant_solver::Vec3;

/// Coefficients of Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// Static coefficient, 1: limits the tangential force while sticking.
    pub static_coefficient: f64,
    /// Kinetic coefficient, 1: gives the tangential force while sliding.
    pub kinetic_coefficient: f64,
}

/// The contact of the proxy with a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Index of the body.
    pub body: u32,
    /// Contact point in the model as loaded, m.
    pub rest: Vec3,
    /// Normal of the surface in the rest shape, not normalised.
    pub rest_normal: Vec3,
    /// Unit contact normal, from the surface to the proxy.
    pub normal: Vec3,
    /// Contact point on the triangle with the largest force; `None` if the surface is sampled.
    pub triangle: Option<TrianglePoint>,
    /// Centre of the proxy that sticks, without the shear of the layer, minus the contact point, m.
    pub offset: Vec3,
}

/// A tool's shape that does not penetrate surfaces.
#[derive(Clone, Debug)]
pub struct Proxy {
    /// Position of the centre, m.
    pub position: Vec3,
    /// Shape, with its present orientation.
    pub shape: OrientedShape,
    /// The contact; `None` if the proxy is free and at the hand.
    pub touch: Option<Touch>,
    /// Separating planes of the points in `near`.
    planes: Vec<Plane>,
    /// Result of the last search.
    near: Vec<SurfacePoint>,
}

/// A half-space `normal . p >= offset` of allowed centres `p`.
#[derive(Clone, Copy, Debug)]
struct Plane {
    /// Unit normal of the plane, out of the surface.
    normal: Vec3,
    /// Smallest allowed `normal . p`, m.
    offset: f64,
    /// Lagrange multiplier of Hildreth's method, m.
    multiplier: f64,
    /// Index of the point in `Proxy::near`.
    near: usize,
}

/// Largest number of sweeps of Hildreth's method over the planes.
const MAX_SWEEPS: usize = 40;
/// Largest number of moves, each of at most half a length scale, in a step.
const MAX_MOVES: usize = 64;

impl Proxy {
    /// A free proxy at `position`, m.
    pub fn new(position: Vec3, shape: OrientedShape) -> Self {
        Self { position, shape, touch: None, planes: Vec::new(), near: Vec::new() }
    }

    /// Moves the proxy towards `hand` (m). `search` lists the surface points within a distance (m) of the shape at a position (m); `contact` is
    /// the present position of the last contact point (m).
    ///
    /// Returns the position of the proxy that moves with the last contact point, m, where it stays if it sticks; `None` without contact.
    ///
    /// # Errors
    /// Returns the errors of `search`.
    pub fn move_towards<E>(
        &mut self,
        hand: Vec3,
        contact: Option<Vec3>,
        mut search: impl FnMut(&OrientedShape, Vec3, f64, &mut Vec<SurfacePoint>) -> Result<(), E>,
    ) -> Result<Option<Vec3>, E> {
        let anchor = self.touch.zip(contact).map(|(t, at)| at + t.offset);
        let mut p = anchor.unwrap_or(self.position);
        let mut touch = None;
        let scale = self.shape.shape().length_scale();
        for _ in 0..MAX_MOVES {
            let ahead = hand - p;
            search(&self.shape, p, ahead.norm().min(0.5 * scale), &mut self.near)?;
            self.list_planes(p);
            let goal = self.nearest(hand);
            let (to, step) = limit(p, goal, 0.5 * scale);
            p = to;
            touch = self.touch_at(p, hand, goal);
            // The planes are those at the start of the move; after a short move they are still valid.
            if step <= 0.05 * scale {
                break;
            }
        }
        self.position = p;
        self.touch = touch;
        Ok(anchor)
    }

    /// Length scale of its shape, m: the radius of a sphere.
    pub fn radius(&self) -> f64 {
        self.shape.shape().length_scale()
    }

    /// Surface points found by the last search.
    pub fn near(&self) -> &[SurfacePoint] {
        &self.near
    }

    /// Sets the position `p` (m) and the contact.
    pub fn set_contact(&mut self, p: Vec3, touch: Touch) {
        self.position = p;
        self.touch = Some(touch);
    }

    /// Lists, for each nearby point, the half-space of centres in which the shape's tangent plane separates it from the point.
    fn list_planes(&mut self, p: Vec3) {
        self.planes.clear();
        for (i, n) in self.near.iter().enumerate() {
            if let Some(out) = self.shape.normal(n.point - p) {
                let normal = -out;
                let offset = normal.dot(&n.point) + self.shape.support(out);
                self.planes.push(Plane { normal, offset, multiplier: 0.0, near: i });
            }
        }
    }

    /// The point closest to `hand` in the intersection of the half-spaces, m, by Hildreth's method (1957).
    fn nearest(&mut self, hand: Vec3) -> Vec3 {
        let tolerance = 1e-9 * self.shape.shape().length_scale();
        let mut y = hand;
        for _ in 0..MAX_SWEEPS {
            let mut moved = 0.0_f64;
            for plane in &mut self.planes {
                let multiplier = (plane.multiplier + plane.offset - plane.normal.dot(&y)).max(0.0);
                let change = multiplier - plane.multiplier;
                plane.multiplier = multiplier;
                y += change * plane.normal;
                moved = moved.max(change.abs());
            }
            if moved <= tolerance {
                break;
            }
        }
        y
    }

    /// The contact of a proxy at `p` whose planes keep it at `goal` instead of `hand`. Its normal is the direction of their total force, its
    /// contact point the centroid of the active points, weighted by their multipliers. `None` if no plane is active.
    fn touch_at(&self, p: Vec3, hand: Vec3, goal: Vec3) -> Option<Touch> {
        let push = goal - hand;
        let length = push.norm();
        let total: f64 = self.planes.iter().map(|p| p.multiplier).sum();
        if length <= 1e-9 * self.shape.shape().length_scale() || total <= 0.0 {
            return None;
        }
        let strongest = self.planes.iter().max_by(|a, b| a.multiplier.total_cmp(&b.multiplier))?;
        let n = &self.near[strongest.near];
        let centroid = |of: fn(&SurfacePoint) -> Vec3| {
            self.planes.iter().map(|p| p.multiplier / total * of(&self.near[p.near])).sum::<Vec3>()
        };
        let point = if n.triangle.is_some() { n.point } else { centroid(|n| n.point) };
        let (rest, normal, offset) = (centroid(|n| n.rest), push / length, p - point);
        Some(Touch { body: n.body, rest, rest_normal: n.normal, normal, triangle: n.triangle, offset })
    }

    /// The active surface points and the fraction of the contact force at each.
    pub fn supports(&self) -> impl Iterator<Item = (&SurfacePoint, f64)> {
        let total: f64 = self.planes.iter().map(|p| p.multiplier).sum();
        self.planes.iter().filter(|p| p.multiplier > 0.0).map(move |p| (&self.near[p.near], p.multiplier / total))
    }
}

/// Position of the proxy with Coulomb friction, m. `anchor` is its position if it sticks, `free` without friction, both in m; `hand` pulls it and
/// `normal` is the unit contact normal. It stays at the anchor inside the friction cone; outside it slides up to the kinetic cone.
pub fn apply_friction(free: Vec3, anchor: Vec3, hand: Vec3, normal: Vec3, friction: Friction) -> Vec3 {
    let pull = hand - anchor;
    let press = -pull.dot(&normal);
    let along = pull + press * normal;
    let slide = along.norm();
    // Projects onto the tangent plane of `free`.
    let project = |p: Vec3| p + (free - p).dot(&normal) * normal;
    if press > 0.0 && slide <= friction.static_coefficient * press {
        return project(anchor);
    }
    if press > 0.0 && slide > 0.0 {
        let fraction = (1.0 - friction.kinetic_coefficient * press / slide).max(0.0);
        return project(anchor + fraction * (free - anchor));
    }
    free
}

/// Moves from `p` towards `goal` by at most `max_length`. Returns the new position and the length of the move, all in m.
fn limit(p: Vec3, goal: Vec3, max_length: f64) -> (Vec3, f64) {
    let d = goal - p;
    let length = d.norm();
    if length <= max_length { (goal, length) } else { (p + max_length / length * d, max_length) }
}
