//! A tool: its proxy on surfaces, its virtual coupling to the hand, and its loads on bodies.

use super::hand::Hand;
use super::search::{SurfaceSearch, nearest_on_sheets};
use crate::body::{Body, LatticeError, interpolate};
use crate::contact::{Friction, LayerLaw, Patch, PointLoads, Proxy, depth_on_side, inward};
use crate::edit::{Action, ActiveBall, BladeEdge, BodyPoint, CutStep, EdgeInside, GRIP_REACH, Step, StitchRequest};
use crate::shape::OrientedShape;
use nalgebra::UnitQuaternion;
use pliant_plugin_api::abi::Ball;
use pliant_solver::{Block, NodeSprings, Vec3};

/// The virtual coupling: spring and damper between hand and proxy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Stiffness of the coupling between hand and proxy, N/m.
    pub stiffness: f64,
    /// Damping, N s/m.
    pub damping: f64,
    /// Largest force on a body, N.
    pub max_force: f64,
}

impl Coupling {
    /// Factor, at most 1, that limits a force of this magnitude (N) to the largest one.
    pub fn cap(&self, size: f64) -> f64 {
        if size > self.max_force { self.max_force / size } else { 1.0 }
    }
}

/// Depth of the contact patch in a body with cuts, in cell edges: the patch is flat, and where it is on a cut surface that is not, it would press on what
/// lies on the other side.
const PATCH_DEPTH: f64 = 0.125;

/// A tool in a scene.
pub struct Tool {
    /// Name in the scene.
    pub name: String,
    /// Its proxy on surfaces.
    pub proxy: Proxy,
    /// Coefficients of friction on surfaces.
    pub friction: Friction,
    /// Virtual coupling to the hand.
    pub coupling: Coupling,
    /// Its contact law on solids, if the scene gives one.
    pub law: Option<LayerLaw>,
    /// Its blade, if it is a knife.
    pub blade: Option<BladeEdge>,
    /// Displacement of the surface at the contact point, inwards or outwards, m.
    pub depth: f64,
    /// Contact directions: unit vectors from its centre, each with its fraction of the contact force.
    pub contact_directions: Vec<(Vec3, f64)>,
    /// Number of grips lost because the force exceeded the limit.
    pub slipped: u64,
    /// Whether the active edit has changed the rest shape, pins or parameters of a body.
    pub(crate) changed_body: bool,
    /// Body and parameter that the active edit would paint and that the material does not let vary.
    pub(crate) refused_param: Option<(u32, String)>,
    /// Force of the coupling before it was limited to [`Coupling::max_force`], N; `None` if it is within the limit.
    pub(crate) force_over_limit: Option<f64>,
    /// Stiffness of the coupling that a body met last, relative to its own: less than 1 where the body's elastic layer is softer.
    pub(crate) coupling_factor: f64,
    /// Rotation from axes of the shape to axes of the hand.
    mount: UnitQuaternion<f64>,
    pub(crate) surface: SurfaceSearch,
    pub(crate) loads: PointLoads,
    /// The active edit; without one the tool touches nothing.
    action: Option<Box<dyn Action>>,
    patch: Patch,
    /// The last requested ball of cells for each body, and the time of the request, s.
    ball: Option<(ActiveBall, f64)>,
    /// Loads on the nodes of each body (b).
    springs: Vec<NodeSprings>,
    /// Version of the node numbering of each body (b).
    numbering: Vec<u64>,
}

/// Time for which the cells around a contact stay simulated after it has ended, so that they return to rest elastically, s.
const SPRING_BACK: f64 = 0.25;

impl Tool {
    /// A tool with this shape in a scene with `bodies` bodies.
    pub fn new(name: String, shape: OrientedShape, friction: Friction, coupling: Coupling, bodies: usize) -> Self {
        Self {
            name,
            mount: shape.rotation(),
            proxy: Proxy::new(Vec3::zeros(), shape),
            friction,
            coupling,
            law: None,
            blade: None,
            depth: 0.0,
            contact_directions: Vec::new(),
            slipped: 0,
            changed_body: false,
            refused_param: None,
            force_over_limit: None,
            coupling_factor: 1.0,
            surface: SurfaceSearch::new(bodies),
            loads: PointLoads::default(),
            action: None,
            patch: Patch::default(),
            ball: None,
            springs: (0..bodies).map(|_| NodeSprings::default()).collect(),
            numbering: vec![0; bodies],
        }
    }

    /// Adapts to another number of bodies.
    pub(crate) fn resize_bodies(&mut self, bodies: usize) {
        self.surface.resize(bodies);
        self.springs.resize_with(bodies, NodeSprings::default);
        self.numbering.resize(bodies, 0);
    }

    /// Its loads on the nodes of a body.
    pub fn springs(&self, body: usize) -> &NodeSprings {
        &self.springs[body]
    }

    /// Mutable access to its loads on the nodes of a body.
    pub fn springs_mut(&mut self, body: usize) -> &mut NodeSprings {
        &mut self.springs[body]
    }

    /// Sets the active edit; `None` ends it.
    pub fn set_action(&mut self, action: Option<Box<dyn Action>>) {
        self.action = action;
    }

    /// Whether an edit is active.
    pub fn is_active(&self) -> bool {
        self.action.is_some()
    }

    /// Whether it grips a body.
    pub fn is_gripping(&self) -> bool {
        self.action.as_ref().is_some_and(|action| action.is_gripping())
    }

    /// The point of the rest shape (m) where it grips body number `index`; `None` if it grips none.
    pub(crate) fn grip_on(&self, index: usize) -> Option<Vec3> {
        let at = self.contact().filter(|_| self.is_gripping())?;
        (at.body as usize == index).then_some(at.rest)
    }

    /// Whether it is in contact with sheets as a fingertip, in the active edit.
    pub fn is_fingertip(&self) -> bool {
        self.action.as_ref().is_some_and(|action| action.is_fingertip())
    }

    /// Its contact point; `None` without contact.
    pub fn contact(&self) -> Option<BodyPoint> {
        self.action.as_ref().and_then(|action| action.contact(self))
    }

    /// The part of its blade that is inside of a body, in the active edit.
    pub(crate) fn edge_inside(&self) -> Option<EdgeInside> {
        self.action.as_ref().and_then(|action| action.edge_inside())
    }

    /// Cuts with the active edit; `last` is set if it ends with this step.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn cut(&mut self, hand: &Hand, bodies: &mut [Body], last: bool) -> Result<CutStep, LatticeError> {
        let Some(mut action) = self.action.take() else { return Ok(CutStep::default()) };
        let cut = action.cut(self, hand, bodies, last);
        self.action = Some(action);
        cut
    }

    /// Changes its shape to a sphere of this radius, m.
    pub fn set_radius(&mut self, radius: f64) {
        self.proxy.shape = OrientedShape::sphere(radius);
    }

    /// Whether contact of a shape uses samples of the surface, for cells with this edge (m); shapes with smaller features use triangles.
    pub fn meets_samples(shape: &OrientedShape, edge: f64) -> bool {
        shape.shape().feature_size() >= edge
    }

    /// The ball of cells of the body `index` that must be simulated for this tool at `time` (s): around its contact, or where it is about to touch.
    /// `None` if the tool needs no cells of this body.
    pub fn required_ball(&mut self, index: usize, body: &Body, hand: &Hand, time: f64) -> Option<Ball> {
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
        let radius = body.discretization.radius() + extra_radius + self.proxy.shape.extra_region_radius();
        let radius = radius + self.corners_reach(body).min(radius);
        (of as usize == index && time - since <= SPRING_BACK).then_some(Ball { centre: centre.into(), radius })
    }

    /// Largest distance from the contact to the corners of a coarse triangle it presses on, m: cells there must be simulated. 0 without such a
    /// triangle.
    fn corners_reach(&self, body: &Body) -> f64 {
        let Some((touch, triangle)) = self.proxy.touch.and_then(|touch| Some((touch, touch.triangle?))) else {
            return 0.0;
        };
        let corners = triangle.coarse_corners(body).into_iter().flatten();
        corners.map(|corner| (corner - touch.rest).norm()).fold(0.0, f64::max)
    }

    /// The point of the settled surface closest to the tool, m, if it may touch it soon.
    fn approached(&self, body: &Body, hand: &Hand) -> Option<Vec3> {
        let ahead = hand.position - self.proxy.position;
        let shape = &self.proxy.shape;
        let margin = GRIP_REACH * shape.shape().length_scale() + body.discretization.edge() + ahead.norm();
        let beyond = if shape.shape().is_round() { 0.0 } else { shape.shape().bounding_radius() };
        let centre = self.proxy.position;
        let mut best: Option<(f64, u32, Vec3)> = None;
        body.skin.tree.near_within(centre, margin + beyond, |triangle| {
            if body.failed_triangles.contains(triangle) {
                return best.map_or(margin, |(distance, ..)| distance) + beyond;
            }
            let vertices = body.model.surface.triangles[triangle as usize];
            let closest = shape.closest_on_triangle(centre, vertices.map(|v| body.skin.settled[v as usize]));
            let d = closest.point - centre;
            let distance = if shape.shape().is_round() { d.norm() } else { shape.distance(d) };
            let nearer = best.is_none_or(|(b, t, _)| (distance, triangle) < (b, t));
            if distance <= margin && nearer {
                let rest = interpolate(vertices.map(|v| body.model.surface.points[v as usize]), closest.bary);
                best = Some((distance, triangle, rest));
            }
            best.map_or(margin, |(distance, ..)| distance) + beyond
        });
        best.map(|(.., rest)| rest)
    }

    /// Invalidates everything that depends on the cells and nodes of `body`.
    pub fn invalidate(&mut self, body: usize) {
        self.surface.invalidate(body);
        self.numbering[body] += 1;
    }

    /// Version of the node numbering of a body; it changes with every renumbering.
    pub(crate) fn numbering(&self, body: u32) -> u64 {
        self.numbering[body as usize]
    }

    /// The points that the active edit requests to be tied in this step.
    pub fn stitch_request(&self, bodies: &[Body]) -> Option<StitchRequest> {
        self.action.as_ref().and_then(|action| action.stitch_request(bodies))
    }

    /// [`Coupling::cap`] of a force of this magnitude (N); a force above the limit is recorded for a warning.
    pub(crate) fn cap(&mut self, size: f64) -> f64 {
        self.force_over_limit = (size > self.coupling.max_force).then_some(size);
        self.coupling.cap(size)
    }

    /// Ends all contacts and grips and moves the proxy to the hand.
    pub fn release(&mut self, hand: &Hand) {
        if let Some(action) = &mut self.action {
            action.release();
        }
        self.release_to_hand(hand);
    }

    /// Moves the proxy to the hand, without contact and loads.
    pub(crate) fn release_to_hand(&mut self, hand: &Hand) {
        self.proxy.touch = None;
        self.proxy.position = hand.position;
        self.coupling_factor = 1.0;
        self.surface.leave();
        self.law.iter_mut().for_each(LayerLaw::leave);
        self.springs.iter_mut().for_each(NodeSprings::clear);
    }

    /// Follows the hand with the active edit and sets the loads on bodies.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn follow(&mut self, step: &mut Step<'_>) -> Result<(), LatticeError> {
        self.springs.iter_mut().for_each(NodeSprings::clear);
        self.contact_directions.clear();
        self.depth = 0.0;
        self.force_over_limit = None;
        self.proxy.shape.set_rotation(step.hand.rotation * self.mount);
        if !step.hand.present || self.action.is_none() {
            self.release(step.hand);
            return Ok(());
        }
        let contact = match self.contact() {
            Some(BodyPoint { body, rest }) => Some(step.bodies[body as usize].embed_point(rest)?),
            None => None,
        };
        let Some(mut action) = self.action.take() else { return Ok(()) };
        let followed = action.follow(self, step, contact);
        self.action = Some(action);
        followed
    }

    /// Moves the proxy towards the hand as far as surfaces allow; `contact` is the present position of the last contact point, m. Returns the
    /// position of the proxy if it sticks, m; `None` without contact.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(crate) fn slide_proxy(
        &mut self,
        step: &mut Step<'_>,
        contact: Option<Vec3>,
    ) -> Result<Option<Vec3>, LatticeError> {
        let search = self.surface.by_tool(step.bodies, step.moved);
        self.proxy.move_towards(step.hand.position, contact, search)
    }

    /// The sheet point closest to a fingertip, within 1.1 radii of its centre.
    pub(crate) fn sheet_below(&self, bodies: &[Body]) -> Option<BodyPoint> {
        let near = nearest_on_sheets(bodies, self.proxy.position, 1.1 * self.proxy.radius());
        near.map(|near| BodyPoint { body: near.body, rest: near.rest })
    }

    /// Applies a force (N) to body number `index` over a disc around a rest position (m) with a rest normal (any length).
    pub(crate) fn press_disc(
        &mut self,
        body: &mut Body,
        index: u32,
        rest: Vec3,
        normal: Vec3,
        force: Vec3,
    ) -> Result<(), LatticeError> {
        let (edge, lattice) = (body.discretization.edge(), body.discretization.lattice());
        let is_cut = lattice.is_some_and(|lattice| lattice.has_cuts());
        let centre = if is_cut { inward(rest, normal, PATCH_DEPTH * edge) } else { rest };
        self.patch.sample(centre, normal, edge);
        self.press_patch(body, index, rest, force)
    }

    /// Applies a force (N) to the corners of the triangles of body number `index` that the proxy presses on, around the rest position `rest` (m).
    pub(crate) fn press_corners(
        &mut self,
        body: &mut Body,
        index: u32,
        rest: Vec3,
        force: Vec3,
    ) -> Result<(), LatticeError> {
        let Patch { points, fractions } = &mut self.patch;
        points.clear();
        fractions.clear();
        let edge = body.discretization.edge();
        let is_cut = body.discretization.lattice().is_some_and(|lattice| lattice.has_cuts());
        for (near, fraction) in self.proxy.supports() {
            let Some(triangle) = near.triangle.filter(|_| near.body == index) else { continue };
            let vertices = body.model.surface.triangles[triangle.triangle as usize];
            let depth = depth_on_side(&body.model, triangle.triangle);
            for (v, weight) in vertices.into_iter().zip(triangle.bary.iter()) {
                let corner = body.model.surface.points[v as usize];
                points.push(if is_cut { inward(corner, near.normal, depth * edge) } else { corner });
                fractions.push(fraction * weight);
            }
        }
        self.press_patch(body, index, rest, force)
    }

    /// Applies the force of the coupling (N) to the points of the contact patch, which is around the rest position `rest` (m).
    fn press_patch(&mut self, body: &mut Body, index: u32, rest: Vec3, force: Vec3) -> Result<(), LatticeError> {
        self.loads.clear();
        for (point, fraction) in self.patch.points.iter().zip(&self.patch.fractions) {
            let [stiffness, damping] = [self.coupling.stiffness, self.coupling.damping].map(|k| diagonal(fraction * k));
            self.loads.push(*point, *fraction * force, stiffness, damping);
        }
        self.attach_loads(body, index)?;
        self.limit_springs(body, index, rest, force.norm())
    }

    /// Limits its springs on the nodes of body number `index`, whose forces have the total magnitude `size` (N), to the coupling's largest force and to the
    /// stiffness of the elastic layer at the rest position `rest` (m): a solid that meets a stiffer spring overshoots within a step.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub(crate) fn limit_springs(&mut self, body: &Body, index: u32, rest: Vec3, size: f64) -> Result<(), LatticeError> {
        let springs = &mut self.springs[index as usize];
        let stiffest = springs.max_stiffness();
        if body.discretization.lattice().is_some() && stiffest > 0.0 {
            let layer = body.layer_stiffness_at(rest)? * body.discretization.edge().powi(2);
            self.coupling_factor = (layer / stiffest).min(1.0);
        }
        let felt = self.coupling_factor;
        // Force, stiffness and damping are scaled alike, so the anchor of the springs stays: a constant force would accelerate the surface past it within
        // the step.
        let scale = self.cap(felt * size);
        self.springs[index as usize].scale(felt * scale);
        Ok(())
    }

    /// Distributes [`Tool::loads`] to the nodes of the body `index`.
    pub(crate) fn attach_loads(&mut self, body: &mut Body, index: u32) -> Result<(), LatticeError> {
        self.loads.attach(body, &mut self.springs[index as usize])
    }

    /// Whether the active edit rotates the gripped region with the hand, so that the device gets a torque.
    pub fn renders_torque(&self) -> bool {
        self.action.as_ref().is_some_and(|action| action.renders_torque())
    }

    /// Reaction torque on the hand at `hand` (m) at the end of a step, N m: the negative moment about it of the forces on bodies. Zero unless the
    /// active edit renders torque.
    pub fn reaction_torque(&self, hand: Vec3, bodies: &[Body]) -> Vec3 {
        if !self.renders_torque() {
            return Vec3::zeros();
        }
        let each = self.springs.iter().zip(bodies).filter(|(springs, _)| !springs.is_empty());
        each.fold(Vec3::zeros(), |torque, (springs, body)| {
            torque - springs.moment(hand, &body.system.nodes.x, &body.system.nodes.v)
        })
    }

    /// Reaction force on the hand at the end of a step, N: the negative sum of the forces on bodies.
    pub fn reaction(&self, bodies: &[Body]) -> Vec3 {
        let each = self.springs.iter().zip(bodies).filter(|(springs, _)| !springs.is_empty());
        each.fold(Vec3::zeros(), |force, (springs, body)| {
            force - springs.total(&body.system.nodes.x, &body.system.nodes.v)
        })
    }
}

/// A multiple of the identity block.
pub(crate) fn diagonal(value: f64) -> Block {
    std::array::from_fn(|e| if e % 4 == 0 { value } else { 0.0 })
}

/// Unit vector along a vector; `None` for a zero vector.
pub(crate) fn direction(of: Vec3) -> Option<Vec3> {
    let size = of.norm();
    (size > 0.0).then(|| of / size)
}
