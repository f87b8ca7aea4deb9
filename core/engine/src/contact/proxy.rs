//! The god-object: where the tool is, as far as the surface lets it.
//!
//! The proxy is a convex shape that stays outside of the surface (Zilles and Salisbury 1995; with a radius: Ruspini, Kolarov and
//! Khatib 1997). The surface carries it at the place it touches; then it goes towards the hand as far as the separating planes of what is
//! near allow. It is turned as the hand is. Each move is at most half its length scale, so nothing is passed through. Friction, and how far
//! it sinks into the soft layer of the contact, are decided afterwards.

use super::near::Near;
use super::on_triangle::OnTriangle;
use crate::shape::OrientedShape;
use pliant_solver::Vec3;

/// Coulomb's two coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    /// To start sliding.
    pub fixed: f64,
    /// While sliding.
    pub sliding: f64,
}

/// Where the proxy touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Index of the body.
    pub body: u32,
    /// Where the point touched was in the model as it was handed in, m.
    pub rest: Vec3,
    /// Normal there, in the rest shape; of no particular length
    pub rest_normal: Vec3,
    /// Unit, from the surface to the proxy.
    pub normal: Vec3,
    /// The triangle it presses on most; `None` on samples.
    pub on: Option<OnTriangle>,
    /// m, proxy from the point that carries it: the place on that triangle, or the contact point
    pub offset: Vec3,
}

/// A shape that the surface keeps out.
#[derive(Clone, Debug)]
pub struct Proxy {
    /// Centre, m.
    pub position: Vec3,
    /// Shape, as it is turned now.
    pub shape: OrientedShape,
    /// `None`: free, and at the hand.
    pub touch: Option<Touch>,
    planes: Vec<Plane>,
    near: Vec<Near>,
}

#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: Vec3,
    /// `normal . p >= at`
    at: f64,
    force: f64,
    near: usize,
}

/// Sweeps over the planes; each is a handful of products.
const SWEEPS: usize = 40;
/// Moves of half a radius before a step gives up going further.
const MOVES: usize = 64;

impl Proxy {
    /// A free proxy at `position`, m.
    pub fn new(position: Vec3, shape: OrientedShape) -> Self {
        Self { position, shape, touch: None, planes: Vec::new(), near: Vec::new() }
    }

    /// Goes towards `hand`, m. `search` lists what of the surface is within a distance, m, of the shape at a place; `contact` is where the
    /// surface has carried the last contact point, m.
    ///
    /// Returns where the surface has carried the proxy, where it could stay if friction holds it.
    ///
    /// # Errors
    /// Those of `search`.
    pub fn go<E>(
        &mut self,
        hand: Vec3,
        contact: Option<Vec3>,
        mut search: impl FnMut(&OrientedShape, Vec3, f64, &mut Vec<Near>) -> Result<(), E>,
    ) -> Result<Option<Vec3>, E> {
        let ridden = self.touch.zip(contact).map(|(t, at)| at + t.offset);
        let mut p = ridden.unwrap_or(self.position);
        let mut touch = None;
        let scale = self.shape.shape().length_scale();
        for _ in 0..MOVES {
            let ahead = hand - p;
            search(&self.shape, p, ahead.norm().min(0.5 * scale), &mut self.near)?;
            self.list_planes(p);
            let goal = self.nearest(hand);
            let (to, step) = limit(p, goal, 0.5 * scale);
            p = to;
            touch = self.touch_at(p, hand, goal);
            // The planes were those at the start of the move; after a short one they are still the right ones.
            if step <= 0.05 * scale {
                break;
            }
        }
        self.position = p;
        self.touch = touch;
        Ok(ridden)
    }

    /// Length scale of its shape, m: the radius of a sphere.
    pub fn radius(&self) -> f64 {
        self.shape.shape().length_scale()
    }

    /// What the last search found.
    pub fn near(&self) -> &[Near] {
        &self.near
    }

    /// Stands at `p`, touching at the place `at` that was at `rest`.
    pub fn stand(&mut self, p: Vec3, at: Vec3, touch: Touch) {
        self.position = p;
        self.touch = Some(Touch { offset: p - at, ..touch });
    }

    /// Lists the half-spaces that keep a shape at `p` off each near point: the shape lies on one side of its tangent plane there.
    fn list_planes(&mut self, p: Vec3) {
        self.planes.clear();
        for (i, n) in self.near.iter().enumerate() {
            if let Some(out) = self.shape.normal(n.point - p) {
                let normal = -out;
                let at = normal.dot(&n.point) + self.shape.support(out);
                self.planes.push(Plane { normal, at, force: 0.0, near: i });
            }
        }
    }

    /// The point nearest to `hand` in all half-spaces, by Hildreth's method (1957): each plane pushes as hard as it must.
    fn nearest(&mut self, hand: Vec3) -> Vec3 {
        let tolerance = 1e-9 * self.shape.shape().length_scale();
        let mut y = hand;
        for _ in 0..SWEEPS {
            let mut moved = 0.0_f64;
            for plane in &mut self.planes {
                let force = (plane.force + plane.at - plane.normal.dot(&y)).max(0.0);
                let change = force - plane.force;
                plane.force = force;
                y += change * plane.normal;
                moved = moved.max(change.abs());
            }
            if moved <= tolerance {
                break;
            }
        }
        y
    }

    /// The touch of a proxy at `p` that the planes keep at `goal`: its normal is the direction of their push, its place the
    /// middle of the places that push, each by its force.
    fn touch_at(&self, p: Vec3, hand: Vec3, goal: Vec3) -> Option<Touch> {
        let push = goal - hand;
        let length = push.norm();
        let total: f64 = self.planes.iter().map(|p| p.force).sum();
        if length <= 1e-9 * self.shape.shape().length_scale() || total <= 0.0 {
            return None;
        }
        let strongest = self.planes.iter().max_by(|a, b| a.force.total_cmp(&b.force))?;
        let n = &self.near[strongest.near];
        let middle =
            |of: fn(&Near) -> Vec3| self.planes.iter().map(|p| p.force / total * of(&self.near[p.near])).sum::<Vec3>();
        let point = if n.on.is_some() { n.point } else { middle(|n| n.point) };
        let (rest, normal, offset) = (middle(|n| n.rest), push / length, p - point);
        Some(Touch { body: n.body, rest, rest_normal: n.normal, normal, on: n.on, offset })
    }

    /// What it presses on, each with its share of the force.
    pub fn supports(&self) -> impl Iterator<Item = (&Near, f64)> {
        let total: f64 = self.planes.iter().map(|p| p.force).sum();
        self.planes.iter().filter(|p| p.force > 0.0).map(move |p| (&self.near[p.near], p.force / total))
    }
}

/// Where friction leaves a proxy that stood at `anchor` and would slide to `free`.
pub fn hold(free: Vec3, anchor: Vec3, hand: Vec3, normal: Vec3, friction: Friction) -> Vec3 {
    let pull = hand - anchor;
    let press = -pull.dot(&normal);
    let along = pull + press * normal;
    let slide = along.norm();
    // Back onto the surface the slide was computed on.
    let level = |p: Vec3| p + (free - p).dot(&normal) * normal;
    if press > 0.0 && slide <= friction.fixed * press {
        return level(anchor);
    }
    if press > 0.0 && slide > 0.0 {
        let share = (1.0 - friction.sliding * press / slide).max(0.0);
        return level(anchor + share * (free - anchor));
    }
    free
}

/// From `p` towards `goal`, at most `most`; gives the step's length too.
fn limit(p: Vec3, goal: Vec3, most: f64) -> (Vec3, f64) {
    let d = goal - p;
    let length = d.norm();
    if length <= most { (goal, length) } else { (p + most / length * d, most) }
}
