//! A tool: its proxy on the surfaces, its spring to the hand, and the loads it puts on bodies.

use super::hand::Hand;
use super::search::{SurfaceSearch, nearest_on_sheets};
use crate::body::{Body, LatticeError, interpolate};
use crate::contact::{Friction, Patch, PointLoads, Proxy, inward};
use crate::edit::{Action, ActiveBall, BladeEdge, BodyPoint, CutStep, EmbeddedPoint, GRIP_REACH, Step};
use crate::shape::OrientedShape;
use nalgebra::UnitQuaternion;
use pliant_plugin_api::abi::Ball;
use pliant_solver::{Block, NodeSprings, Vec3};

/// The spring between hand and surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Stiffness, N/m.
    pub stiffness: f64,
    /// Damping, N s/m.
    pub damping: f64,
    /// Largest force it puts on a body, N.
    pub max_force: f64,
}

impl Coupling {
    /// The factor that limits a force (N) to the largest one, and the factor of its stiffness: a limited force is constant.
    pub fn cap(&self, force: Vec3) -> (f64, f64) {
        self.cap_size(force.norm())
    }

    /// The same for a force of a size (N).
    pub fn cap_size(&self, size: f64) -> (f64, f64) {
        if size > self.max_force { (self.max_force / size, 0.0) } else { (1.0, 1.0) }
    }
}

/// A tool in a scene.
pub struct Tool {
    /// Name in the scene.
    pub name: String,
    /// Where it is, as far as surfaces let it.
    pub proxy: Proxy,
    /// Friction on surfaces.
    pub friction: Friction,
    /// Spring to the hand.
    pub coupling: Coupling,
    /// Blade of a knife.
    pub blade: Option<BladeEdge>,
    /// How far the surface is pushed in, or pulled out, at the contact point, m.
    pub depth: f64,
    /// Where it presses on a body: unit vectors from its centre, each with its share of the force.
    pub presses: Vec<(Vec3, f64)>,
    /// Grips that were lost to too much force.
    pub slipped: u64,
    /// Whether the edit under way has changed a shape at rest.
    pub(crate) reshaped: bool,
    /// What the edit under way asks of the coupling, where that is more than it gives, N.
    pub(crate) wanted: Option<f64>,
    /// How its shape is turned in the axes of the hand.
    mount: UnitQuaternion<f64>,
    pub(crate) surface: SurfaceSearch,
    pub(crate) loads: PointLoads,
    /// The edit under way; `None`: it passes through everything.
    action: Option<Box<dyn Action>>,
    patch: Patch,
    /// Cells that were wanted last, and when, s.
    ball: Option<(ActiveBall, f64)>,
    /// Per body: what it does to its nodes.
    springs: Vec<NodeSprings>,
    /// Per body: how often its nodes have been numbered anew.
    numbering: Vec<u64>,
}

/// How long the cells around a contact stay free after it has ended, to spring back by themselves, s.
const SPRING_BACK: f64 = 0.25;

impl Tool {
    /// A tool of a shape for a scene of `bodies` bodies.
    pub fn new(name: String, shape: OrientedShape, friction: Friction, coupling: Coupling, bodies: usize) -> Self {
        Self {
            name,
            mount: shape.rotation(),
            proxy: Proxy::new(Vec3::zeros(), shape),
            friction,
            coupling,
            blade: None,
            depth: 0.0,
            presses: Vec::new(),
            slipped: 0,
            reshaped: false,
            wanted: None,
            surface: SurfaceSearch::new(bodies),
            loads: PointLoads::default(),
            action: None,
            patch: Patch::default(),
            ball: None,
            springs: (0..bodies).map(|_| NodeSprings::default()).collect(),
            numbering: vec![0; bodies],
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

    /// Begins an edit, or ends it with `None`.
    pub fn set_action(&mut self, action: Option<Box<dyn Action>>) {
        self.action = action;
    }

    /// Whether an edit is under way.
    pub fn is_active(&self) -> bool {
        self.action.is_some()
    }

    /// Whether it holds on to a body.
    pub fn holds(&self) -> bool {
        self.action.as_ref().is_some_and(|action| action.is_gripping())
    }

    /// Whether it meets sheets as a fingertip now.
    pub fn is_fingertip(&self) -> bool {
        self.action.as_ref().is_some_and(|action| action.is_fingertip())
    }

    /// Where it is in contact.
    pub fn contact(&self) -> Option<BodyPoint> {
        self.action.as_ref().and_then(|action| action.contact(self))
    }

    /// Has the edit under way change meshes; `last` when it ends.
    ///
    /// # Errors
    /// A grid or material that fails.
    pub fn cut(&mut self, hand: &Hand, bodies: &mut [Body], last: bool) -> Result<CutStep, LatticeError> {
        let Some(mut action) = self.action.take() else { return Ok(CutStep::default()) };
        let cut = action.cut(self, hand, bodies, last);
        self.action = Some(action);
        cut
    }

    /// Changes its shape to a sphere of `radius`, m.
    pub fn set_radius(&mut self, radius: f64) {
        self.proxy.shape = OrientedShape::sphere(radius);
    }

    /// Whether a shape meets samples of a surface on a grid with this edge, m; with smaller features it meets triangles.
    pub fn meets_samples(shape: &OrientedShape, edge: f64) -> bool {
        shape.shape().feature_size() >= edge
    }

    /// The cells of the body `index` that must be active for it, at `time` (s): around its contact, or where it is about to touch.
    pub fn wants(&mut self, index: usize, body: &Body, hand: &Hand, time: f64) -> Option<Ball> {
        if let Some(action) = &self.action {
            let approached = || {
                let rest = self.approached(body, hand).filter(|_| hand.present)?;
                Some(ActiveBall { body: index as u32, centre: rest, extra_radius: 0.0 })
            };
            let ball = match action.active_ball(self) {
                Some(ball) => Some(ball).filter(|ball| ball.body as usize == index),
                None => approached(),
            };
            let extra = action.extra_region_radius(body.discretization.edge());
            let ball = ball.map(|ball| ActiveBall { extra_radius: ball.extra_radius + extra, ..ball });
            self.ball = ball.map(|ball| (ball, time)).or(self.ball);
        }
        let (ball, since) = self.ball?;
        let ActiveBall { body: of, centre, extra_radius } = ball;
        let radius = body.discretization.radius() + extra_radius + self.proxy.shape.extent();
        let radius = radius + self.corners_reach(body).min(radius);
        (of as usize == index && time - since <= SPRING_BACK).then_some(Ball { centre: centre.into(), radius })
    }

    /// How far the corners of the coarse triangle it presses on are from there, m: they are to be simulated, up to twice the radius.
    fn corners_reach(&self, body: &Body) -> f64 {
        let Some((touch, triangle)) = self.proxy.touch.and_then(|touch| Some((touch, touch.triangle?))) else {
            return 0.0;
        };
        let corners = triangle.coarse_corners(body).into_iter().flatten();
        corners.map(|corner| (corner - touch.rest).norm()).fold(0.0, f64::max)
    }

    /// The settled place the tool is closest to, if it may touch it soon.
    fn approached(&self, body: &Body, hand: &Hand) -> Option<Vec3> {
        let ahead = hand.position - self.proxy.position;
        let shape = &self.proxy.shape;
        let margin = GRIP_REACH * shape.shape().length_scale() + body.discretization.edge() + ahead.norm();
        let beyond = if shape.shape().is_round() { 0.0 } else { shape.shape().bounding_radius() };
        let (centre, reach) = (self.proxy.position, margin + beyond);
        let mut best: Option<(f64, u32, Vec3)> = None;
        body.skin.tree.near(centre, reach, |triangle| {
            let vertices = body.model.surface.triangles[triangle as usize];
            let closest = shape.closest_on_triangle(centre, vertices.map(|v| body.skin.settled[v as usize]));
            let d = closest.point - centre;
            let distance = if shape.shape().is_round() { d.norm() } else { shape.distance(d) };
            let nearer = best.is_none_or(|(b, t, _)| (distance, triangle) < (b, t));
            if distance <= margin && nearer {
                let rest = interpolate(vertices.map(|v| body.model.surface.points[v as usize]), closest.bary);
                best = Some((distance, triangle, rest));
            }
        });
        best.map(|(.., rest)| rest)
    }

    /// The cells of `body` have changed.
    pub fn forget(&mut self, body: usize) {
        self.surface.forget(body);
        self.numbering[body] += 1;
    }

    /// A number that changes when nodes of a body are numbered anew.
    pub(crate) fn numbering(&self, body: u32) -> u64 {
        self.numbering[body as usize]
    }

    /// What [`Coupling::cap`] makes of a force of this size (N); one over the most is remembered for a warning.
    pub(crate) fn cap(&mut self, size: f64) -> (f64, f64) {
        self.wanted = (size > self.coupling.max_force).then_some(size);
        self.coupling.cap_size(size)
    }

    /// Lets go of everything, and stands at the hand.
    pub fn release(&mut self, hand: &Hand) {
        if let Some(action) = &mut self.action {
            action.release();
        }
        self.release_to_hand(hand);
    }

    /// Stands at the hand, in contact with nothing and without loads.
    pub(crate) fn release_to_hand(&mut self, hand: &Hand) {
        self.proxy.touch = None;
        self.proxy.position = hand.position;
        self.surface.leave();
        self.springs.iter_mut().for_each(NodeSprings::clear);
    }

    /// Follows the hand, and sets the loads on bodies.
    ///
    /// # Errors
    /// A grid or material that fails.
    pub fn follow(&mut self, step: &mut Step<'_>) -> Result<(), LatticeError> {
        self.springs.iter_mut().for_each(NodeSprings::clear);
        self.presses.clear();
        self.depth = 0.0;
        self.wanted = None;
        self.proxy.shape.set_rotation(step.hand.rotation * self.mount);
        if !step.hand.present || self.action.is_none() {
            self.release(step.hand);
            return Ok(());
        }
        let contact = match self.contact() {
            Some(BodyPoint { body, rest }) => {
                let (now, settled) = step.bodies[body as usize].embed_point(rest)?;
                Some(EmbeddedPoint { now, settled })
            }
            None => None,
        };
        let Some(mut action) = self.action.take() else { return Ok(()) };
        let followed = action.follow(self, step, contact);
        self.action = Some(action);
        followed
    }

    /// Moves the proxy towards the hand as far as surfaces let it; `contact` (m) is where the surface has carried the last contact
    /// point. Gives where the surface has carried the proxy, where it could stay if friction holds it.
    ///
    /// # Errors
    /// A grid that fails.
    pub(crate) fn slide_proxy(
        &mut self,
        step: &mut Step<'_>,
        contact: Option<Vec3>,
    ) -> Result<Option<Vec3>, LatticeError> {
        let search = self.surface.by_tool(step.bodies, step.moved);
        self.proxy.move_towards(step.hand.position, contact, search)
    }

    /// The place of a sheet that a fingertip lies on, within 1.1 radii of its centre.
    pub(crate) fn sheet_below(&self, bodies: &[Body]) -> Option<BodyPoint> {
        let near = nearest_on_sheets(bodies, self.proxy.position, 1.1 * self.proxy.radius());
        near.map(|near| BodyPoint { body: near.body, rest: near.rest })
    }

    /// Puts a force (N) on body number `index` over a disc around a rest place (m) with a rest normal.
    pub(crate) fn press_disc(
        &mut self,
        body: &mut Body,
        index: u32,
        rest: Vec3,
        normal: Vec3,
        pulled: Vec3,
    ) -> Result<(), LatticeError> {
        self.patch.sample(rest, normal, body.discretization.edge());
        self.press_patch(body, index, pulled)
    }

    /// Puts a force (N) on the corners of the triangles of body number `index` that the proxy presses on.
    pub(crate) fn press_corners(&mut self, body: &mut Body, index: u32, pulled: Vec3) -> Result<(), LatticeError> {
        let Patch { points, fractions } = &mut self.patch;
        points.clear();
        fractions.clear();
        let edge = body.discretization.edge();
        let is_cut = body.discretization.lattice().is_some_and(|lattice| lattice.has_cuts());
        for (near, fraction) in self.proxy.supports() {
            let Some(triangle) = near.triangle.filter(|_| near.body == index) else { continue };
            let vertices = body.model.surface.triangles[triangle.triangle as usize];
            for (v, weight) in vertices.into_iter().zip(triangle.bary.iter()) {
                let corner = body.model.surface.points[v as usize];
                points.push(if is_cut { inward(corner, near.normal, edge) } else { corner });
                fractions.push(fraction * weight);
            }
        }
        self.press_patch(body, index, pulled)
    }

    /// Puts a force (N) on the points of the patch.
    fn press_patch(&mut self, body: &mut Body, index: u32, pulled: Vec3) -> Result<(), LatticeError> {
        let (scale, spring) = self.cap(pulled.norm());
        self.loads.clear();
        for (point, fraction) in self.patch.points.iter().zip(&self.patch.fractions) {
            let stiffness = diagonal(spring * fraction * self.coupling.stiffness);
            let damping = diagonal(spring * fraction * self.coupling.damping);
            self.loads.push(*point, scale * fraction * pulled, stiffness, damping);
        }
        self.attach_loads(body, index)
    }

    /// Gives [`Tool::loads`] to the nodes of the body `index`.
    pub(crate) fn attach_loads(&mut self, body: &mut Body, index: u32) -> Result<(), LatticeError> {
        self.loads.attach(body, &mut self.springs[index as usize])
    }

    /// Whether the edit under way turns what it holds with the hand.
    pub fn turns(&self) -> bool {
        self.action.as_ref().is_some_and(|action| action.renders_torque())
    }

    /// N m, on the hand at `hand` (m), at the end of a step: the opposite of the moment the bodies felt about it. Zero unless
    /// the edit under way turns what it holds.
    pub fn reaction_torque(&self, hand: Vec3, bodies: &[Body]) -> Vec3 {
        if !self.turns() {
            return Vec3::zeros();
        }
        let each = self.springs.iter().zip(bodies).filter(|(springs, _)| !springs.is_empty());
        each.fold(Vec3::zeros(), |torque, (springs, body)| {
            torque - springs.moment(hand, &body.system.nodes.x, &body.system.nodes.v)
        })
    }

    /// Reaction on the hand, at the end of a step: the opposite of what the bodies felt, N.
    pub fn reaction(&self, bodies: &[Body]) -> Vec3 {
        let each = self.springs.iter().zip(bodies).filter(|(springs, _)| !springs.is_empty());
        each.fold(Vec3::zeros(), |force, (springs, body)| {
            force - springs.total(&body.system.nodes.x, &body.system.nodes.v)
        })
    }
}

/// A block with one value along its diagonal.
pub(crate) fn diagonal(value: f64) -> Block {
    std::array::from_fn(|e| if e % 4 == 0 { value } else { 0.0 })
}

/// The direction of a vector that has one.
pub(crate) fn direction(of: Vec3) -> Option<Vec3> {
    let size = of.norm();
    (size > 0.0).then(|| of / size)
}
