//! Touch: the tool's proxy slides over surfaces and presses them.
//!
//! The proxy P_s stays outside of the surface while the hand P_t penetrates it. The force on the hand is K (P_s - P_t) (Qi, Zhu and Fan 2019);
//! the opposite force is distributed over the contact area of the body.

use super::touch_by_law::press_by_law;
use super::{Action, EditKind, Step};
use crate::body::{Body, EmbeddedPoint, LatticeError};
use crate::contact::{Layer, Touch as Contact, apply_friction};
use crate::plan::Edit;
use crate::tool::{Tool, diagonal, direction};
use nalgebra::Matrix3;
use pliant_solver::Vec3;

/// Touches surfaces with the tool's proxy.
pub(super) struct Touch;

impl EditKind for Touch {
    fn name(&self) -> &'static str {
        "touch"
    }

    fn summary(&self) -> &'static str {
        "Slide over surfaces and press them."
    }

    fn only_presses(&self) -> bool {
        true
    }

    fn begin(&self, _edit: &Edit, _tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        Box::new(Touching)
    }
}

/// A touch in progress. Its state is that of the tool's proxy.
pub(super) struct Touching;

impl Action for Touching {
    fn is_fingertip(&self) -> bool {
        true
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPoint>,
    ) -> Result<(), LatticeError> {
        let hand = step.hand.position;
        let triangle = tool.proxy.touch.and_then(|touch| Some((touch.body, touch.triangle?)));
        let positions =
            triangle.map(|(body, triangle)| triangle.positions(&mut step.bodies[body as usize])).transpose()?.flatten();
        let anchor = tool.slide_proxy(step, positions.or(contact).map(|point| point.now))?;
        let Some(touch) = tool.proxy.touch else {
            tool.surface.leave();
            tool.law.iter_mut().for_each(|law| law.part(tool.proxy.position));
            return Ok(());
        };
        let body = &mut step.bodies[touch.body as usize];
        if tool.law.is_some() {
            return press_by_law(tool, step, touch);
        }
        if Tool::meets_samples(&tool.proxy.shape, body.discretization.edge()) {
            return balance_in_layer(tool, body, hand, touch, anchor);
        }
        let free = tool.proxy.position;
        let p = anchor.map_or(free, |anchor| apply_friction(free, anchor, hand, touch.normal, tool.friction));
        tool.proxy.position = p;
        tool.contact_directions.extend(direction(touch.normal).map(|normal| (-normal, 1.0)));
        let positions = touch.triangle.map(|triangle| triangle.positions(body)).transpose()?.flatten();
        let EmbeddedPoint { now, settled } = positions.map_or_else(|| body.embed_point(touch.rest), Ok)?;
        tool.depth = (settled - now).dot(&touch.normal);
        let pulled = tool.coupling.stiffness * (hand - p);
        if touch.triangle.and_then(|triangle| triangle.coarse_corners(body)).is_some() {
            return tool.press_corners(body, touch.body, touch.rest, pulled);
        }
        tool.press_disc(body, touch.body, touch.rest, touch.rest_normal, pulled)
    }
}

/// Moves the proxy to the equilibrium of the elastic layer and the coupling, and applies the contact forces to the samples.
fn balance_in_layer(
    tool: &mut Tool,
    body: &mut Body,
    hand: Vec3,
    touch: Contact,
    anchor: Option<Vec3>,
) -> Result<(), LatticeError> {
    let (coupling, near) = (tool.coupling, tool.proxy.near());
    let shape = tool.proxy.shape.clone();
    let layer = Layer { shape: &shape, coupling: coupling.stiffness, stiffness: body.layer_stiffness };
    let without_friction = |from| {
        let (p, layer_force) = layer.balance(near, from, hand, None);
        let normal = direction(layer_force).unwrap_or(touch.normal);
        Rest { position: p, anchor: p, normal, shear: 0.0 }
    };
    let Rest { position: p, anchor, normal, shear } = match anchor {
        Some(anchor) if tool.friction.static_coefficient > 0.0 => {
            rest_with_friction(tool, &layer, Slide { anchor, hand, normal: touch.normal })
                .unwrap_or_else(|| without_friction(tool.proxy.position))
        }
        _ => without_friction(tool.proxy.position),
    };
    let mut total = 0.0;
    let [mut pushed, mut rest] = [Vec3::zeros(); 2];
    for push in layer.pushes(near, p) {
        total += push.magnitude;
        pushed += push.force;
        rest += push.magnitude * push.rest;
    }
    if total == 0.0 {
        tool.proxy.position = p;
        return Ok(());
    }
    // What the coupling pulls along the surface is friction, inside the cone, and distributed like the normal forces.
    let pull = coupling.stiffness * (hand - p);
    let along = pull - pull.dot(&normal) * normal;
    let most = tool.friction.static_coefficient * pushed.norm();
    let friction = along * (most / along.norm().max(f64::MIN_POSITIVE)).min(1.0);
    let pulled = pushed + friction;
    // Within a step a limited force ends where the whole one would: a force that stayed would fling the surface away.
    let scale = coupling.cap(pulled.norm());
    tool.loads.clear();
    for push in layer.pushes(near, p) {
        let fraction = push.magnitude / total;
        tool.contact_directions.extend(direction(push.point - p).map(|towards| (towards, fraction)));
        let along_normal = push.normal * push.normal.transpose();
        let along_surface = Matrix3::identity() - along_normal;
        let block = scale * push.stiffness * (along_normal + shear * along_surface);
        let stiffness = std::array::from_fn(|e| block[(e / 3, e % 3)]);
        let force = scale * (push.force + fraction * friction);
        tool.loads.push(push.rest, force, stiffness, diagonal(scale * fraction * coupling.damping));
    }
    let touch = Contact { rest: rest / total, normal, triangle: None, ..touch };
    let EmbeddedPoint { now, settled } = body.embed_point(touch.rest)?;
    // The place of the rest point, not the mean place of the samples: over a curved surface they differ, and a tool that sticks would creep.
    tool.proxy.set_contact(p, Contact { offset: anchor - now, ..touch });
    tool.depth = (settled - now).dot(&normal);
    tool.attach_loads(body, touch.body)
}

/// A proxy with friction that moved with the surface.
#[derive(Clone, Copy)]
struct Slide {
    /// Position of the proxy if it sticks, m.
    anchor: Vec3,
    /// Position of the hand, m.
    hand: Vec3,
    /// Unit contact normal, out of the surface.
    normal: Vec3,
}

/// Equilibrium of the proxy between the layer and the coupling.
struct Rest {
    /// Position of the proxy, m.
    position: Vec3,
    /// Its position without the shear of the layer, m, which moves with the surface.
    anchor: Vec3,
    /// Unit vector of the layer's force on it.
    normal: Vec3,
    /// Stiffness that friction has within a step against a motion of the surface along itself, relative to that of the layer along the normal. A tool
    /// that slides has it too: without it a light surface would overshoot.
    shear: f64,
}

/// Equilibrium of the proxy with friction. The layer is as stiff in shear as along the normal, so however stiff the coupling is, a tool that sticks
/// pulls no harder than the time step allows. It sticks inside the friction cone; otherwise it slides up to the kinetic cone. `None` if it is not in
/// contact with the layer.
fn rest_with_friction(tool: &Tool, layer: &Layer<'_>, slide: Slide) -> Option<Rest> {
    let Slide { anchor, hand, normal } = slide;
    let near = tool.proxy.near();
    let (anchor, layer_force) = layer.balance(near, anchor, hand, Some(normal));
    let normal = direction(layer_force)?;
    let pull = hand - anchor;
    let along = pull - pull.dot(&normal) * normal;
    let press = layer_force.dot(&normal) / layer.coupling;
    // Coupling and shear of the layer in series, relative to the coupling.
    let series = 1.0 / (1.0 + layer.coupling / layer.total_stiffness(near, anchor));
    let pulled = series * along.norm();
    let sticks = pulled <= tool.friction.static_coefficient * press;
    let slid = if sticks { 0.0 } else { (1.0 - tool.friction.kinetic_coefficient * press.max(0.0) / pulled).max(0.0) };
    let sheared = slid + (1.0 - series) * (1.0 - slid);
    let (position, layer_force) = layer.balance(near, anchor + sheared * along, hand, Some(normal));
    Some(Rest {
        position,
        anchor: position - (sheared - slid) * along,
        normal: direction(layer_force)?,
        shear: 1.0 - series,
    })
}
