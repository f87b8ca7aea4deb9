//! The god-object: where the tool is, as far as the surface lets it.
//!
//! The proxy is a ball that stays outside of the surface (Zilles and Salisbury 1995; with a radius: Ruspini, Kolarov and
//! Khatib 1997). It rides on the triangle it touches, so a surface that moves carries it, then goes towards the hand as far
//! as the planes of the near triangles allow, and sticks or slides by its friction cone. Each move is at most half its
//! radius, so nothing is passed through.

use super::near::Near;
use crate::step::{V3, axpy, dot};

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
    /// Of which body.
    pub body: u32,
    /// Which triangle.
    pub triangle: u32,
    /// Where on it.
    pub bary: V3,
    /// Unit, from the surface to the proxy.
    pub normal: V3,
    /// m, proxy from the contact point
    pub offset: V3,
    /// Whether friction holds it.
    pub sticking: bool,
}

/// A ball that the surface keeps out.
#[derive(Clone, Debug)]
pub struct Proxy {
    /// m
    pub position: V3,
    /// m
    pub radius: f64,
    /// `None`: free, and at the hand.
    pub touch: Option<Touch>,
    planes: Vec<Plane>,
    near: Vec<Near>,
}

#[derive(Clone, Copy, Debug)]
struct Plane {
    normal: V3,
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
    /// Free, at `position`.
    pub fn new(position: V3, radius: f64) -> Self {
        Self { position, radius, touch: None, planes: Vec::new(), near: Vec::new() }
    }

    /// How far from the proxy triangles matter, for one call of `search`, m.
    pub fn reach(&self) -> f64 {
        2.0 * self.radius
    }

    /// Goes towards `hand`. `search` gives the triangles within [`Proxy::reach`] of a place; `contact` is where the surface
    /// has carried the last contact point.
    ///
    /// # Errors
    /// What `search` says.
    pub fn go<E>(
        &mut self,
        hand: V3,
        friction: Friction,
        contact: Option<V3>,
        mut search: impl FnMut(V3, &mut Vec<Near>) -> Result<(), E>,
    ) -> Result<(), E> {
        let ridden = self.touch.zip(contact).map(|(t, at)| axpy(at, 1.0, t.offset));
        let mut p = ridden.unwrap_or(self.position);
        let mut touch = None;
        for _ in 0..MOVES {
            search(p, &mut self.near)?;
            self.list_planes(p);
            let goal = self.nearest(hand);
            let (to, step) = limit(p, goal, 0.5 * self.radius);
            p = to;
            touch = self.contact(hand, goal);
            // The planes were those at the start of the move; after a short one they are still the right ones.
            if step <= 0.05 * self.radius {
                break;
            }
        }
        if let (Some(touch), Some(anchor)) = (&mut touch, ridden) {
            p = hold(p, anchor, hand, touch, friction);
        }
        self.position = p;
        self.touch = touch.map(|t| self.settle(t, p));
        Ok(())
    }

    /// The half-spaces that keep the ball off each near triangle, about `p`.
    fn list_planes(&mut self, p: V3) {
        self.planes.clear();
        for (i, n) in self.near.iter().enumerate() {
            if n.distance > 1e-12 {
                let normal = axpy(p, -1.0, n.closest.point).map(|c| c / n.distance);
                let at = dot(normal, n.closest.point) + self.radius;
                self.planes.push(Plane { normal, at, force: 0.0, near: i });
            }
        }
    }

    /// The point nearest to `hand` in all half-spaces, by Hildreth's method (1957): each plane pushes as hard as it must.
    fn nearest(&mut self, hand: V3) -> V3 {
        let mut y = hand;
        for _ in 0..SWEEPS {
            let mut moved = 0.0_f64;
            for plane in &mut self.planes {
                let force = (plane.force + plane.at - dot(plane.normal, y)).max(0.0);
                let change = force - plane.force;
                plane.force = force;
                y = axpy(y, change, plane.normal);
                moved = moved.max(change.abs());
            }
            if moved <= 1e-9 * self.radius {
                break;
            }
        }
        y
    }

    /// The touch, if any plane pushes: its normal is the direction of the push, its place that of the plane that pushes most.
    fn contact(&self, hand: V3, goal: V3) -> Option<Touch> {
        let push = axpy(goal, -1.0, hand);
        let length = dot(push, push).sqrt();
        if length <= 1e-9 * self.radius {
            return None;
        }
        let normal = push.map(|c| c / length);
        let strongest = self.planes.iter().filter(|p| p.force > 0.0).max_by(|a, b| a.force.total_cmp(&b.force))?;
        let n = &self.near[strongest.near];
        let offset = axpy(goal, -1.0, n.closest.point);
        Some(Touch { body: n.body, triangle: n.triangle, bary: n.closest.bary, normal, offset, sticking: false })
    }

    /// The touch with its contact point brought under the proxy's final place.
    fn settle(&self, touch: Touch, p: V3) -> Touch {
        let Some(n) = self.near.iter().find(|n| (n.body, n.triangle) == (touch.body, touch.triangle)) else {
            return touch;
        };
        let closest = super::closest_point(p, n.corners);
        Touch { bary: closest.bary, offset: axpy(p, -1.0, closest.point), ..touch }
    }
}

/// Where friction leaves the proxy, which stood at `anchor` and would slide to `free`.
fn hold(free: V3, anchor: V3, hand: V3, touch: &mut Touch, friction: Friction) -> V3 {
    let pull = axpy(hand, -1.0, anchor);
    let press = -dot(pull, touch.normal);
    let along = axpy(pull, press, touch.normal);
    let slide = dot(along, along).sqrt();
    let held = |p: V3| {
        // Back onto the surface the slide was computed on.
        let lift = dot(axpy(free, -1.0, p), touch.normal);
        axpy(p, lift, touch.normal)
    };
    if press > 0.0 && slide <= friction.fixed * press {
        touch.sticking = true;
        return held(anchor);
    }
    if press > 0.0 && slide > 0.0 {
        let share = (1.0 - friction.sliding * press / slide).max(0.0);
        return held(axpy(anchor, share, axpy(free, -1.0, anchor)));
    }
    free
}

/// From `p` towards `goal`, at most `most`; gives the step's length too.
fn limit(p: V3, goal: V3, most: f64) -> (V3, f64) {
    let d = axpy(goal, -1.0, p);
    let length = dot(d, d).sqrt();
    if length <= most { (goal, length) } else { (axpy(p, most / length, d), most) }
}
