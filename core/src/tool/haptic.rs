//! Touch and pull.
//!
//! Both are a spring between the hand P_t and a point P_s on the surface (Qi, Zhu and Fan 2019): the god-object slides over
//! the surface in a touch and is anchored in a pull. The force on the hand is K (P_s - P_t), the opposite is spread over a
//! disc of the body.

use super::hand::Hand;
use crate::body::{Body, LatticeError, weigh};
use crate::contact::{Friction, Layer, Near, NearTriangles, Patch, PlaceLoads, Proxy, closest_point, hold};
use crate::step::{Block, NodeSprings, V3, axpy, dot};
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
    layer: Layer,
    loads: PlaceLoads,
    ball: Option<(u32, V3, f64)>,
    /// Per body: what it does to its nodes.
    springs: Vec<NodeSprings>,
}

/// s, how long the cells around a contact stay free after it has ended, to spring back by themselves.
const SPRING_BACK: f64 = 0.25;
/// Samples of the layer that must carry a ball before its shape can be told from a point's.
const LEAST_PARTS: usize = 6;
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
            layer: Layer::default(),
            loads: PlaceLoads::default(),
            ball: None,
            springs: (0..bodies).map(|_| NodeSprings::default()).collect(),
        }
    }

    /// What it does to the nodes of a body.
    pub fn springs_mut(&mut self, body: usize) -> &mut NodeSprings {
        &mut self.springs[body]
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
            weigh(corners, bary)
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
        self.springs.iter_mut().for_each(NodeSprings::clear);
    }

    /// Follows the hand, and sets what it pulls at. `moved` is how far nodes of each body may have moved since last time, m.
    ///
    /// # Errors
    /// What a grid says.
    pub fn follow(&mut self, hand: &Hand, bodies: &mut [Body], moved: &[f64]) -> Result<(), ToolError> {
        self.springs.iter_mut().for_each(NodeSprings::clear);
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
        let anchor = self.proxy.go(hand.position, contact, |centre, out| {
            Self::search(near, bodies, std::mem::replace(&mut since, still), (centre, reach), out)
        })?;
        let Some(touch) = self.proxy.touch else { return Ok(()) };
        let body = &mut bodies[touch.body as usize];
        let (radius, edge, pull) = (self.proxy.radius, body.lattice.edge(), self.coupling.stiffness);
        let (free, near) = (self.proxy.position, self.proxy.near());
        self.layer.sample(near, free, radius, touch.normal, edge, body.layer_stiffness);
        let settle = |p, along| self.layer.balance(p, radius, hand.position, pull, along);
        let slid = |p, normal| anchor.map(|anchor| hold(p, anchor, hand.position, normal, self.friction));
        let (mut p, felt) = settle(free, None);
        let normal = direction(felt).unwrap_or(touch.normal);
        if let Some(held) = slid(p, normal) {
            (p, _) = settle(held, Some(normal));
        }
        if self.layer.pushes(p, radius).count() >= LEAST_PARTS {
            return self.press(body, touch.body, p, normal, hand.position);
        }
        let p = slid(free, touch.normal).unwrap_or(free);
        self.proxy.position = p;
        self.measure_depth(body, touch.triangle, touch.bary, touch.normal);
        let pulled = axpy(hand.position, -1.0, p).map(|c| pull * c);
        self.press_disc(body, (touch.body, touch.triangle, touch.bary), pulled)
    }

    /// Stands at `p` and gives the body what the hand pulls, over the layer the ball lies in.
    fn press(&mut self, body: &mut Body, index: u32, p: V3, normal: V3, hand: V3) -> Result<(), ToolError> {
        let pulled = axpy(hand, -1.0, p).map(|c| self.coupling.stiffness * c);
        let (mut total, mut middle) = (0.0, [0.0; 3]);
        let near = self.proxy.near();
        for push in self.layer.pushes(p, self.proxy.radius) {
            middle = axpy(middle, push.size, weigh(near[push.sample.near].corners, push.sample.bary));
            total += push.size;
        }
        self.proxy.stand(p, normal, middle.map(|c| c / total));
        if let Some(touch) = self.proxy.touch {
            self.measure_depth(body, touch.triangle, touch.bary, normal);
        }
        self.loads.clear();
        let (scale, spring) = self.cap(pulled);
        let whole = self.layer.pushes(p, self.proxy.radius).fold([0.0; 3], |sum, push| axpy(sum, 1.0, push.force));
        // What the pushes leave of the pull is friction's; it is shared as they are.
        let rest = axpy(pulled, -1.0, whole);
        let near = self.proxy.near();
        for push in self.layer.pushes(p, self.proxy.radius) {
            let share = push.size / total;
            let force = axpy(push.force, share, rest).map(|f| scale * f);
            let sideways = share * self.coupling.stiffness;
            let stiffness = std::array::from_fn(|e| spring * (push.stiffness[e] + if e % 4 == 0 { sideways } else { 0.0 }));
            let damping = diagonal(spring * share * self.coupling.damping);
            let n = &near[push.sample.near];
            for (corner, weight) in body.model.surface.triangles[n.triangle as usize].into_iter().zip(push.sample.bary) {
                let place = body.model.surface.points[corner as usize];
                let of = |block: Block| block.map(|b| weight * b);
                self.loads.push(place, force.map(|f| weight * f), of(stiffness), of(damping));
            }
        }
        self.loads.attach(&mut body.lattice, &body.system.nodes, &mut self.springs[index as usize])
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
        let out = axpy(point, -1.0, weigh(corners, grip.bary));
        self.depth = dot(out, out).sqrt();
        let pulled = pull.map(|c| self.coupling.stiffness * c);
        self.press_disc(body, (grip.body, grip.triangle, grip.bary), pulled)
    }

    /// Gives the body a force (N) over a disc around a contact.
    fn press_disc(
        &mut self,
        body: &mut Body,
        (index, triangle, bary): (u32, u32, V3),
        pulled: V3,
    ) -> Result<(), ToolError> {
        self.patch.sample(&body.model, triangle, bary, body.lattice.edge());
        let (scale, spring) = self.cap(pulled);
        self.loads.clear();
        for (place, share) in self.patch.places.iter().zip(&self.patch.shares) {
            let stiffness = diagonal(spring * share * self.coupling.stiffness);
            let damping = diagonal(spring * share * self.coupling.damping);
            self.loads.push(*place, pulled.map(|f| scale * share * f), stiffness, damping);
        }
        self.loads.attach(&mut body.lattice, &body.system.nodes, &mut self.springs[index as usize])
    }

    /// What is left of a force under the most the hand gives, and of the spring behind it: past the most, the force is
    /// constant.
    fn cap(&self, pulled: V3) -> (f64, f64) {
        let size = dot(pulled, pulled).sqrt();
        if size > self.coupling.most { (self.coupling.most / size, 0.0) } else { (1.0, 1.0) }
    }

    /// How far the contact point has gone in, against the contact normal.
    fn measure_depth(&mut self, body: &Body, triangle: u32, bary: V3, normal: V3) {
        let corners = body.model.surface.triangles[triangle as usize].map(|v| body.skin.settled[v as usize]);
        let moved = axpy(weigh(corners, bary), -1.0, body.skin.point(&body.model, triangle, bary));
        self.depth = dot(moved, normal);
    }

    /// N, on the hand, at the end of a step: the opposite of what the bodies felt.
    pub fn reaction(&self, bodies: &[Body]) -> V3 {
        let each = self.springs.iter().zip(bodies).filter(|(springs, _)| !springs.is_empty());
        each.fold([0.0; 3], |force, (springs, body)| {
            axpy(force, -1.0, springs.total(&body.system.nodes.x, &body.system.nodes.v))
        })
    }
}

/// A block with one value along its diagonal.
fn diagonal(value: f64) -> Block {
    std::array::from_fn(|e| if e % 4 == 0 { value } else { 0.0 })
}

/// The direction of a vector that has one.
fn direction(of: V3) -> Option<V3> {
    let size = dot(of, of).sqrt();
    (size > 0.0).then(|| of.map(|c| c / size))
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
