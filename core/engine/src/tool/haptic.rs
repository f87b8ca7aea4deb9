//! Touch and pull.
//!
//! Both are a spring between the hand P_t and a point P_s on the surface (Qi, Zhu and Fan 2019): the god-object slides over
//! the surface in a touch and is anchored in a pull. The force on the hand is K (P_s - P_t), the opposite is spread over a
//! disc of the body.

use super::error::ToolError;
use super::hand::Hand;
use super::knife::{CutStep, Knife, PLACES};
use crate::body::{Body, Sheet, weigh};
use crate::contact::{Friction, Layer, Near, NearSurface, Patch, PlaceLoads, Proxy, Touch, hold, normal_of};
use pliant_mesh::geometry::closest_point;
use pliant_plugin_api::abi::Ball;
use pliant_solver::{Block, NodeSprings, Vec3};

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
    /// Cuts with its blade.
    Cut,
}

/// A point of a surface that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// Of which body.
    pub body: u32,
    /// m, where it was in the model as it was handed in
    pub rest: Vec3,
    /// Normal there, in the rest shape; of no particular length
    pub normal: Vec3,
    /// m, hand from the point when it was taken, so that taking it makes no force
    pub offset: Vec3,
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
    /// Its blade, if it has one.
    pub knife: Option<Knife>,
    /// m, how far in the surface was pushed, or out it was pulled, at the contact point
    pub depth: f64,
    /// Where it presses on a body and with what share of the whole: directions from its centre, of unit length.
    pub presses: Vec<(Vec3, f64)>,
    /// Grips that were lost to too much force.
    pub slipped: u64,
    near: Vec<NearSurface>,
    /// A zero for each body.
    still: Vec<f64>,
    patch: Patch,
    loads: PlaceLoads,
    /// Cells wanted around a rest place of a body, m more than its settings say, and since when, s.
    ball: Option<(u32, Vec3, f64, f64)>,
    /// Per body: what it does to its nodes.
    springs: Vec<NodeSprings>,
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
            proxy: Proxy::new(Vec3::zeros(), radius),
            friction,
            coupling,
            mode: Mode::Idle,
            grip: None,
            knife: None,
            depth: 0.0,
            presses: Vec::new(),
            slipped: 0,
            still: vec![0.0; bodies],
            near: (0..bodies).map(|_| NearSurface::default()).collect(),
            patch: Patch::default(),
            loads: PlaceLoads::default(),
            ball: None,
            springs: (0..bodies).map(|_| NodeSprings::default()).collect(),
        }
    }

    /// What it does to the nodes of a body.
    pub fn springs(&self, body: usize) -> &NodeSprings {
        &self.springs[body]
    }

    /// The same, to change.
    pub fn springs_mut(&mut self, body: usize) -> &mut NodeSprings {
        &mut self.springs[body]
    }

    /// Where it is in contact: body, and the place in the model as it was handed in.
    pub fn contact(&self) -> Option<(u32, Vec3)> {
        let touch = self.proxy.touch.map(|t| (t.body, t.rest));
        let inside = self.knife.as_ref().and_then(|k| k.inside.as_ref()).map(|i| (i.body, i.places[0]));
        self.grip.map(|g| (g.body, g.rest)).or(touch).or(inside)
    }

    /// Moves its blade with the hand and cuts; `last` when the edit ends.
    ///
    /// # Errors
    /// What a grid says.
    pub fn cut(&mut self, hand: &Hand, bodies: &mut [Body], last: bool) -> Result<CutStep, ToolError> {
        match &mut self.knife {
            Some(knife) if hand.present && self.mode == Mode::Cut => {
                knife.cut(hand, self.coupling.stiffness, bodies, last)
            }
            _ => Ok(CutStep::default()),
        }
    }

    /// Whether it is a ball to the grid of a body, and not a point.
    pub fn is_ball(radius: f64, edge: f64) -> bool {
        radius >= edge
    }

    /// The cells of `body` that must be active for it, at `time` (s): around its contact, or where it is about to touch.
    pub fn wants(&mut self, index: usize, body: &Body, hand: &Hand, time: f64) -> Option<Ball> {
        let radius = body.carrier.radius();
        if let Some(inside) = self.knife.as_ref().and_then(|k| k.inside.as_ref()) {
            let (low, high) = (inside.places[0], inside.places[inside.places.len() - 1]);
            let span = high - low;
            self.ball = Some((inside.body, low + 0.5 * span, 0.5 * span.norm(), time));
        }
        match self.contact() {
            Some(_) if self.mode == Mode::Cut => {}
            Some((b, rest)) if b as usize == index => self.ball = Some((b, rest, 0.0, time)),
            None if hand.present && self.mode != Mode::Idle => {
                if let Some(rest) = self.approached(body, hand) {
                    self.ball = Some((index as u32, rest, 0.0, time));
                }
            }
            _ => {}
        }
        let (b, centre, more, since) = self.ball?;
        (b as usize == index && time - since <= SPRING_BACK)
            .then_some(Ball { centre: centre.into(), radius: radius + more })
    }

    /// The settled place the tool is closest to, if it may touch it soon.
    fn approached(&self, body: &Body, hand: &Hand) -> Option<Vec3> {
        let ahead = hand.position - self.proxy.position;
        let reach = GRIP_REACH * self.proxy.radius + body.carrier.edge() + ahead.norm();
        let centre = self.proxy.position;
        let mut best: Option<(f64, u32, Vec3)> = None;
        body.skin.tree.near(centre, reach, |triangle| {
            let vertices = body.model.surface.triangles[triangle as usize];
            let closest = closest_point(centre, vertices.map(|v| body.skin.settled[v as usize]));
            let d = closest.point - centre;
            let distance = d.norm();
            let nearer = best.is_none_or(|(b, t, _)| (distance, triangle) < (b, t));
            if distance <= reach && nearer {
                let rest = weigh(vertices.map(|v| body.model.surface.points[v as usize]), closest.bary);
                best = Some((distance, triangle, rest));
            }
        });
        best.map(|(.., rest)| rest)
    }

    /// The cells of `body` have changed.
    pub fn forget(&mut self, body: usize) {
        self.near[body].forget();
    }

    /// Lets go of everything, and stands at the hand.
    pub fn release(&mut self, hand: &Hand) {
        self.grip = None;
        if let Some(knife) = &mut self.knife {
            knife.lift();
        }
        self.proxy.touch = None;
        self.proxy.position = hand.position;
        self.near.iter_mut().for_each(NearSurface::leave);
        self.springs.iter_mut().for_each(NodeSprings::clear);
    }

    /// Follows the hand, and sets what it pulls at. `moved` is how far nodes of each body may have moved since last time, m.
    ///
    /// # Errors
    /// What a grid says.
    pub fn follow(&mut self, hand: &Hand, bodies: &mut [Body], moved: &[f64]) -> Result<(), ToolError> {
        self.springs.iter_mut().for_each(NodeSprings::clear);
        self.presses.clear();
        self.depth = 0.0;
        if !hand.present || self.mode == Mode::Idle {
            self.release(hand);
            return Ok(());
        }
        let contact = match self.contact() {
            Some((body, rest)) => {
                let body = &bodies[body as usize];
                Some(body.carry_one(rest)?)
            }
            None => None,
        };
        match self.mode {
            Mode::Pull(most) => self.pull(hand, bodies, moved, contact, most),
            Mode::Cut => self.press_edge(hand, bodies),
            _ => self.touch(hand, bodies, moved, contact.map(|(now, _)| now)),
        }
    }

    fn touch(
        &mut self,
        hand: &Hand,
        bodies: &mut [Body],
        moved: &[f64],
        contact: Option<Vec3>,
    ) -> Result<(), ToolError> {
        self.grip = None;
        let (near, radius) = (&mut self.near, self.proxy.radius);
        // Nodes have moved once since the last step, not once for every place the proxy looks at.
        let mut since = moved;
        let still = &self.still;
        let anchor = self.proxy.go(hand.position, contact, |centre, reach, out| {
            let moved = std::mem::replace(&mut since, still);
            search(near, bodies, moved, (centre, reach), Some(radius), out)
        })?;
        let Some(touch) = self.proxy.touch else {
            self.near.iter_mut().for_each(NearSurface::leave);
            return Ok(());
        };
        let body = &mut bodies[touch.body as usize];
        if Self::is_ball(radius, body.carrier.edge()) {
            return self.lie(body, hand, touch, anchor);
        }
        let free = self.proxy.position;
        let p = anchor.map_or(free, |anchor| hold(free, anchor, hand.position, touch.normal, self.friction));
        self.proxy.position = p;
        self.presses.extend(direction(touch.normal).map(|normal| (-normal, 1.0)));
        let (now, settled) = body.carry_one(touch.rest)?;
        self.depth = (settled - now).dot(&touch.normal);
        let pulled = self.coupling.stiffness * (hand.position - p);
        self.press_disc(body, (touch.body, touch.rest, touch.rest_normal), pulled)
    }

    /// Lies in the layer of the surface as a ball, and presses on what of it is inside.
    fn lie(&mut self, body: &mut Body, hand: &Hand, touch: Touch, anchor: Option<Vec3>) -> Result<(), ToolError> {
        let coupling = self.coupling;
        let (hand, near) = (hand.position, self.proxy.near());
        let layer = Layer { radius: self.proxy.radius, pull: coupling.stiffness, stiffness: body.layer_stiffness };
        let frictionless = |from| {
            let (p, felt) = layer.balance(near, from, hand, None);
            (p, direction(felt).unwrap_or(touch.normal))
        };
        let (p, normal) = match anchor {
            Some(anchor) if self.friction.fixed > 0.0 => {
                self.rub(&layer, anchor, hand, touch.normal).unwrap_or_else(|| frictionless(self.proxy.position))
            }
            _ => frictionless(self.proxy.position),
        };
        let mut total = 0.0;
        let [mut pushed, mut point, mut rest] = [Vec3::zeros(); 3];
        for push in layer.pushes(near, p) {
            total += push.size;
            pushed += push.force;
            point += push.size * push.point;
            rest += push.size * push.rest;
        }
        if total == 0.0 {
            self.proxy.position = p;
            return Ok(());
        }
        let pulled = coupling.stiffness * (hand - p);
        // What the pushes leave of the pull is friction's; it is shared as they are.
        let friction = pulled - pushed;
        let (scale, spring) = self.cap(pulled);
        self.loads.clear();
        for push in layer.pushes(near, p) {
            let share = push.size / total;
            self.presses.extend(direction(push.point - p).map(|towards| (towards, share)));
            let sideways = diagonal(share * coupling.stiffness);
            let stiffness = std::array::from_fn(|e| spring * (push.stiffness[e] + sideways[e]));
            let force = scale * (push.force + share * friction);
            self.loads.push(push.rest, force, stiffness, diagonal(spring * share * coupling.damping));
        }
        let touch = Touch { rest: rest / total, normal, ..touch };
        self.proxy.stand(p, point / total, touch);
        let (now, settled) = body.carry_one(touch.rest)?;
        self.depth = (settled - now).dot(&normal);
        self.loads.attach(body, &mut self.springs[touch.body as usize])
    }

    /// Where a ball rests that the surface has carried to `anchor`, and the normal there: the direction of what the layer
    /// does to it. It sticks inside the friction cone and slides up to it. `None` where the layer does not reach it.
    fn rub(&self, layer: &Layer, anchor: Vec3, hand: Vec3, normal: Vec3) -> Option<(Vec3, Vec3)> {
        let near = self.proxy.near();
        let (p, felt) = layer.balance(near, anchor, hand, Some(normal));
        let normal = direction(felt)?;
        let pull = hand - p;
        let press = -pull.dot(&normal);
        let along = pull + press * normal;
        let slide = along.norm();
        if slide <= self.friction.fixed * press {
            return Some((p, normal));
        }
        let slid = p + (1.0 - self.friction.sliding * press.max(0.0) / slide).max(0.0) * along;
        let (p, felt) = layer.balance(near, slid, hand, Some(normal));
        Some((p, direction(felt)?))
    }

    fn pull(
        &mut self,
        hand: &Hand,
        bodies: &mut [Body],
        moved: &[f64],
        contact: Option<(Vec3, Vec3)>,
        most: f64,
    ) -> Result<(), ToolError> {
        self.proxy.touch = None;
        if self.grip.is_none() {
            let mut found = Vec::new();
            let reach = GRIP_REACH * self.proxy.radius;
            search(&mut self.near, bodies, moved, (hand.position, reach), None, &mut found)?;
            let nearest = found.iter().min_by(|a, b| a.distance.total_cmp(&b.distance));
            let grip = |n: &Near| {
                let offset = hand.position - n.point;
                Grip { body: n.body, rest: n.rest, normal: n.normal, offset }
            };
            self.grip = nearest.map(grip);
        }
        let Some(grip) = self.grip else {
            self.proxy.position = hand.position;
            return Ok(());
        };
        let body = &mut bodies[grip.body as usize];
        let (now, settled) = match contact {
            Some(places) => places,
            None => body.carry_one(grip.rest)?,
        };
        self.proxy.position = now + grip.offset;
        let pull = hand.position - self.proxy.position;
        if self.coupling.stiffness * pull.norm() > most {
            self.slipped += 1;
            self.release(hand);
            return Ok(());
        }
        let out = now - settled;
        self.depth = out.norm();
        let pulled = self.coupling.stiffness * pull;
        self.press_disc(body, (grip.body, grip.rest, grip.normal), pulled)
    }

    /// Gives the body the pull of the hand along the edge inside of it.
    fn press_edge(&mut self, hand: &Hand, bodies: &mut [Body]) -> Result<(), ToolError> {
        let Some(knife) = &self.knife else { return Ok(()) };
        self.proxy.position = knife.tip;
        let Some(inside) = &knife.inside else { return Ok(()) };
        self.depth = knife.edge.length * inside.places.len() as f64 / PLACES as f64;
        let pulled = self.coupling.stiffness * (hand.position - knife.tip);
        if knife.resistance == 0.0 || pulled == Vec3::zeros() {
            return Ok(());
        }
        let ((scale, spring), share) = (self.cap(pulled), 1.0 / inside.places.len() as f64);
        let body = &mut bodies[inside.body as usize];
        self.loads.clear();
        let edge = body.carrier.edge();
        for place in &inside.places {
            let place = inside.ahead(*place, knife.heading, edge);
            let stiffness = diagonal(spring * share * self.coupling.stiffness);
            let damping = diagonal(spring * share * self.coupling.damping);
            self.loads.push(place, scale * share * pulled, stiffness, damping);
        }
        self.loads.attach(body, &mut self.springs[inside.body as usize])
    }

    /// Gives the body a force (N) over a disc around a rest place.
    fn press_disc(
        &mut self,
        body: &mut Body,
        (index, rest, normal): (u32, Vec3, Vec3),
        pulled: Vec3,
    ) -> Result<(), ToolError> {
        self.patch.sample(rest, normal, body.carrier.edge());
        let (scale, spring) = self.cap(pulled);
        self.loads.clear();
        for (place, share) in self.patch.places.iter().zip(&self.patch.shares) {
            let stiffness = diagonal(spring * share * self.coupling.stiffness);
            let damping = diagonal(spring * share * self.coupling.damping);
            self.loads.push(*place, scale * share * pulled, stiffness, damping);
        }
        self.loads.attach(body, &mut self.springs[index as usize])
    }

    /// What is left of a force under the most the hand gives, and of the spring behind it: past the most, the force is
    /// constant.
    fn cap(&self, pulled: Vec3) -> (f64, f64) {
        let size = pulled.norm();
        if size > self.coupling.most { (self.coupling.most / size, 0.0) } else { (1.0, 1.0) }
    }

    /// N, on the hand, at the end of a step: the opposite of what the bodies felt.
    pub fn reaction(&self, bodies: &[Body]) -> Vec3 {
        let each = self.springs.iter().zip(bodies).filter(|(springs, _)| !springs.is_empty());
        each.fold(Vec3::zeros(), |force, (springs, body)| {
            force - springs.total(&body.system.nodes.x, &body.system.nodes.v)
        })
    }
}

/// A block with one value along its diagonal.
fn diagonal(value: f64) -> Block {
    std::array::from_fn(|e| if e % 4 == 0 { value } else { 0.0 })
}

/// The direction of a vector that has one.
fn direction(of: Vec3) -> Option<Vec3> {
    let size = of.norm();
    (size > 0.0).then(|| of / size)
}

/// What of all bodies is within `reach` of `centre`: samples for a ball of a radius, triangles for a point.
fn search(
    near: &mut [NearSurface],
    bodies: &mut [Body],
    moved: &[f64],
    (centre, reach): (Vec3, f64),
    radius: Option<f64>,
    out: &mut Vec<Near>,
) -> Result<(), ToolError> {
    out.clear();
    for (index, body) in bodies.iter_mut().enumerate() {
        if let Some(sheet) = body.carrier.sheet() {
            // Looked for once, when a grip is taken: no list is kept.
            if radius.is_none() {
                out.extend(on_sheet(index as u32, body, sheet, centre, reach));
            }
            continue;
        }
        let (list, at) = (&mut near[index], (centre, reach, moved[index]));
        if radius.is_some_and(|r| Tool::is_ball(r, body.carrier.edge())) {
            let samples = std::sync::Arc::clone(&body.samples);
            list.samples((index as u32, body, &samples), at, out)?;
        } else {
            list.triangles((index as u32, body), at, out)?;
        }
    }
    Ok(())
}

/// The point of a sheet closest to `centre`, within `reach`.
fn on_sheet(index: u32, body: &Body, sheet: &Sheet, centre: Vec3, reach: f64) -> Option<Near> {
    let mut best: Option<Near> = None;
    for triangle in 0..body.model.surface.triangles.len() as u32 {
        let corners = sheet.nodes_of(&body.model, triangle).map(|n| body.system.nodes.x[n as usize]);
        let closest = closest_point(centre, corners);
        let d = closest.point - centre;
        let distance = d.norm();
        if distance <= best.map_or(reach, |near| near.distance) {
            let rest = body.model.surface.triangles[triangle as usize].map(|v| body.skin.settled[v as usize]);
            best = Some(Near {
                body: index,
                point: closest.point,
                rest: weigh(rest, closest.bary),
                normal: normal_of(rest),
                distance,
                area: 0.0,
            });
        }
    }
    best
}
