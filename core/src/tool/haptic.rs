//! Touch and pull.
//!
//! Both are a spring between the hand P_t and a point P_s on the surface (Qi, Zhu and Fan 2019): the god-object slides over
//! the surface in a touch and is anchored in a pull. The force on the hand is K (P_s - P_t), the opposite is spread over a
//! disc of the body.

use super::hand::Hand;
use crate::body::{Body, LatticeError};
use crate::contact::{Friction, Near, NearTriangles, Patch, Proxy, Touch, closest_point};
use crate::step::{Attachment, Block, V3, axpy, dot};
use pliant_plugin_api::abi::Ball;

/// What can fail while a tool moves.
pub type ToolError = LatticeError;

/// The spring between hand and surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// N/m
    pub stiffness: f64,
    /// N s/m
    pub damping: f64,
    /// N, the most it gives to the body
    pub most: f64,
}

/// What the tool is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Mode {
    /// Nothing: it passes through everything.
    #[default]
    Idle,
    /// Slides on surfaces.
    Touch,
    /// Holds on to a point, until the force is over this, N.
    Pull(f64),
}

/// A point of a surface that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// Of which body.
    pub body: u32,
    /// Which triangle.
    pub triangle: u32,
    /// Where on it.
    pub bary: V3,
    /// m, hand from the point when it was taken, so that taking it makes no force
    pub offset: V3,
}

/// A tool in a scene.
pub struct Tool {
    /// As the scene calls it.
    pub name: String,
    /// Where it is.
    pub proxy: Proxy,
    /// On surfaces.
    pub friction: Friction,
    /// To the hand.
    pub coupling: Coupling,
    /// What it is doing.
    pub mode: Mode,
    /// What it holds.
    pub grip: Option<Grip>,
    /// m, how far in the surface was pushed, or out it was pulled, at the contact point
    pub depth: f64,
    /// Grips that were lost to too much force.
    pub slipped: u64,
    near: Vec<NearTriangles>,
    /// A zero for each body.
    still: Vec<f64>,
    patch: Patch,
    ball: Option<(u32, V3, f64)>,
    /// Per body: what it pulls at. Empty of nodes where it does not.
    attachments: Vec<Attachment>,
}

/// s, how long the cells around a contact stay free after it has ended, to spring back by themselves.
const SPRING_BACK: f64 = 0.25;
/// Radii of the tool within which a pull finds its point.
const GRIP_REACH: f64 = 3.0;

impl Tool {
    /// A tool of `radius` (m) for a scene of `bodies`.
    pub fn new(name: String, radius: f64, friction: Friction, coupling: Coupling, bodies: usize) -> Self {
        Self {
            name,
            proxy: Proxy::new([0.0; 3], radius),
            friction,
            coupling,
            mode: Mode::Idle,
            grip: None,
            depth: 0.0,
            slipped: 0,
            still: vec![0.0; bodies],
            near: (0..bodies).map(|_| NearTriangles::default()).collect(),
            patch: Patch::default(),
            ball: None,
            attachments: vec![Attachment::default(); bodies],
        }
    }

    /// What it pulls at in a body.
    pub fn attachment(&self, body: usize) -> &Attachment {
        &self.attachments[body]
    }

    /// Where it is in contact: body, triangle and weights.
    pub fn contact(&self) -> Option<(u32, u32, V3)> {
        let touch = self.proxy.touch.map(|t| (t.body, t.triangle, t.bary));
        self.grip.map(|g| (g.body, g.triangle, g.bary)).or(touch)
    }

    /// The cells of `body` that must be active for it, at `time` (s): around its contact, or where it is about to touch.
    pub fn wants(&mut self, index: usize, body: &Body, hand: &Hand, time: f64) -> Option<Ball> {
        let radius = body.lattice.settings.radius;
        let reference = |triangle: u32, bary: V3| {
            let corners =
                body.model.surface.triangles[triangle as usize].map(|v| body.model.surface.points[v as usize]);
            crate::body::weigh(corners, bary)
        };
        if let Some((b, triangle, bary)) = self.contact()
            && b as usize == index
        {
            self.ball = Some((b, reference(triangle, bary), time));
        } else if hand.present
            && self.mode != Mode::Idle
            && self.contact().is_none()
            && let Some((triangle, bary)) = self.approached(body, hand)
        {
            self.ball = Some((index as u32, reference(triangle, bary), time));
        }
        let (b, centre, since) = self.ball?;
        (b as usize == index && time - since <= SPRING_BACK).then_some(Ball { centre, radius })
    }

    /// The settled triangle the tool is closest to, if it may touch it soon.
    fn approached(&self, body: &Body, hand: &Hand) -> Option<(u32, V3)> {
        let ahead = axpy(hand.position, -1.0, self.proxy.position);
        let reach = GRIP_REACH * self.proxy.radius + body.lattice.edge() + dot(ahead, ahead).sqrt();
        let centre = self.proxy.position;
        let mut best: Option<(f64, u32, V3)> = None;
        body.skin.tree.near(centre, reach, |triangle| {
            let corners = body.model.surface.triangles[triangle as usize].map(|v| body.skin.settled[v as usize]);
            let closest = closest_point(centre, corners);
            let d = axpy(closest.point, -1.0, centre);
            let distance = dot(d, d).sqrt();
            let nearer = best.is_none_or(|(b, t, _)| (distance, triangle) < (b, t));
            if distance <= reach && nearer {
                best = Some((distance, triangle, closest.bary));
            }
        });
        best.map(|(_, triangle, bary)| (triangle, bary))
    }

    /// The cells of `body` have changed.
    pub fn forget(&mut self, body: usize) {
        self.near[body].forget();
    }

    /// Lets go of everything, and stands at the hand.
    pub fn release(&mut self, hand: &Hand) {
        self.grip = None;
        self.proxy.touch = None;
        self.proxy.position = hand.position;
        self.attachments.iter_mut().for_each(Attachment::clear);
    }

    /// Follows the hand, and sets what it pulls at. `moved` is how far nodes of each body may have moved since last time, m.
    ///
    /// # Errors
    /// What a grid says.
    pub fn follow(&mut self, hand: &Hand, bodies: &mut [Body], moved: &[f64]) -> Result<(), ToolError> {
        self.attachments.iter_mut().for_each(Attachment::clear);
        self.depth = 0.0;
        if !hand.present || self.mode == Mode::Idle {
            self.release(hand);
            return Ok(());
        }
        let contact = match self.contact() {
            Some((body, triangle, bary)) => Some(surface_point(&mut bodies[body as usize], triangle, bary)?),
            None => None,
        };
        match self.mode {
            Mode::Pull(most) => self.pull(hand, bodies, moved, contact, most),
            _ => self.touch(hand, bodies, moved, contact),
        }
    }

    fn search(
        near: &mut [NearTriangles],
        bodies: &mut [Body],
        moved: &[f64],
        (centre, reach): (V3, f64),
        out: &mut Vec<Near>,
    ) -> Result<(), ToolError> {
        out.clear();
        for (index, body) in bodies.iter_mut().enumerate() {
            let list = &mut near[index];
            let (nodes, model) = (&body.system.nodes, &body.model);
            list.search((centre, reach, moved[index]), &mut body.lattice, nodes, model, &mut body.skin)?;
            out.extend(list.found.iter().map(|n| Near { body: index as u32, ..*n }));
        }
        Ok(())
    }

    fn touch(&mut self, hand: &Hand, bodies: &mut [Body], moved: &[f64], contact: Option<V3>) -> Result<(), ToolError> {
        self.grip = None;
        let (near, reach) = (&mut self.near, self.proxy.reach());
        // Nodes have moved once since the last step, not once for every place the proxy looks at.
        let mut since = moved;
        let still = &self.still;
        self.proxy.go(hand.position, self.friction, contact, |centre, out| {
            Self::search(near, bodies, std::mem::replace(&mut since, still), (centre, reach), out)
        })?;
        let Some(touch) = self.proxy.touch else { return Ok(()) };
        let body = &mut bodies[touch.body as usize];
        self.depth = pushed_in(body, &touch);
        let along = if touch.sticking { 1.0 } else { 0.0 };
        let pull = axpy(hand.position, -1.0, self.proxy.position);
        let place = (touch.body, touch.triangle, touch.bary);
        self.press(body, place, pull, direction_stiffness(touch.normal, along))
    }

    fn pull(
        &mut self,
        hand: &Hand,
        bodies: &mut [Body],
        moved: &[f64],
        contact: Option<V3>,
        most: f64,
    ) -> Result<(), ToolError> {
        self.proxy.touch = None;
        if self.grip.is_none() {
            let mut found = Vec::new();
            let reach = GRIP_REACH * self.proxy.radius;
            Self::search(&mut self.near, bodies, moved, (hand.position, reach), &mut found)?;
            let nearest = found.iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
            self.grip = nearest.map(|n| Grip {
                body: n.body,
                triangle: n.triangle,
                bary: n.closest.bary,
                offset: axpy(hand.position, -1.0, n.closest.point),
            });
        }
        let Some(grip) = self.grip else {
            self.proxy.position = hand.position;
            return Ok(());
        };
        let body = &mut bodies[grip.body as usize];
        let point = match contact {
            Some(point) => point,
            None => surface_point(body, grip.triangle, grip.bary)?,
        };
        self.proxy.position = axpy(point, 1.0, grip.offset);
        let pull = axpy(hand.position, -1.0, self.proxy.position);
        if self.coupling.stiffness * dot(pull, pull).sqrt() > most {
            self.slipped += 1;
            self.release(hand);
            return Ok(());
        }
        let corners = body.model.surface.triangles[grip.triangle as usize].map(|v| body.skin.settled[v as usize]);
        let out = axpy(point, -1.0, crate::body::weigh(corners, grip.bary));
        self.depth = dot(out, out).sqrt();
        self.press(body, (grip.body, grip.triangle, grip.bary), pull, direction_stiffness([0.0; 3], 1.0))
    }

    /// Attaches the coupling, stretched by `pull` (m), to the disc around the contact.
    fn press(
        &mut self,
        body: &mut Body,
        (index, triangle, bary): (u32, u32, V3),
        pull: V3,
        shape: Block,
    ) -> Result<(), ToolError> {
        let edge = body.lattice.edge();
        let radius = Patch::radius(self.proxy.radius, self.depth, edge);
        self.patch.sample(&body.model, triangle, bary, radius, edge);
        let out = &mut self.attachments[index as usize];
        let nodes = body.system.nodes.len();
        if !self.patch.attach(&mut body.lattice, nodes, out)? {
            return Ok(());
        }
        let coupling = self.coupling;
        let stretch = dot(pull, pull).sqrt();
        let force = coupling.stiffness * stretch;
        out.force = pull.map(|p| coupling.stiffness * p);
        if force > coupling.most {
            // The hand gives no more: a constant force, without a spring behind it.
            out.force = pull.map(|p| p * coupling.most / stretch);
        } else {
            out.stiffness = shape.map(|s| coupling.stiffness * s);
            out.damping = shape.map(|s| coupling.damping * s);
        }
        out.anchor = out.gather(&body.system.nodes.x);
        Ok(())
    }

    /// N, on the hand, at the end of a step: the opposite of what the bodies felt.
    pub fn reaction(&self, bodies: &[Body]) -> V3 {
        let mut force = [0.0; 3];
        for (attachment, body) in self.attachments.iter().zip(bodies) {
            if !attachment.nodes.is_empty() {
                let nodes = &body.system.nodes;
                force = axpy(force, -1.0, attachment.load(&nodes.x, Some(&nodes.v)));
            }
        }
        force
    }

    /// Rest places and shares of the disc pressed on, for an embedding that is not linear.
    pub fn patch(&self) -> &Patch {
        &self.patch
    }
}

/// `n n' + along (I - n n')`
fn direction_stiffness(n: V3, along: f64) -> Block {
    std::array::from_fn(|e| {
        let (r, c) = (e / 3, e % 3);
        (1.0 - along) * n[r] * n[c] + if r == c { along } else { 0.0 }
    })
}

/// A point of a triangle, with its corners brought up to date.
fn surface_point(body: &mut Body, triangle: u32, bary: V3) -> Result<V3, ToolError> {
    for v in body.model.surface.triangles[triangle as usize] {
        let cell = body.skin.cell[v as usize];
        if cell != crate::body::NOT_CARRIED {
            body.lattice.embed(cell, &body.system.nodes, &body.model, &mut body.skin)?;
        }
    }
    Ok(body.skin.point(&body.model, triangle, bary))
}

/// m, how far the contact point has gone in, along the contact normal.
fn pushed_in(body: &Body, touch: &Touch) -> f64 {
    let corners = body.model.surface.triangles[touch.triangle as usize].map(|v| body.skin.settled[v as usize]);
    let settled = crate::body::weigh(corners, touch.bary);
    let now = body.skin.point(&body.model, touch.triangle, touch.bary);
    dot(axpy(settled, -1.0, now), touch.normal)
}
