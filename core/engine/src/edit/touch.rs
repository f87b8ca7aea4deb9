//! Touch: the tool's proxy slides over surfaces and presses them.
//!
//! The god-object stays outside of the surface while the hand goes in; the force on the hand is K (P_s - P_t) (Qi, Zhu and Fan
//! 2019), the opposite is spread over the part of the body the tool lies on.

use super::{Action, EditKind, EmbeddedPlace, Step};
use crate::body::{Body, LatticeError};
use crate::contact::{Layer, Touch as Contact, apply_friction};
use crate::plan::Edit;
use crate::tool::{Tool, diagonal, direction};
use pliant_solver::Vec3;

/// Slides over surfaces and presses them.
pub(super) struct Touch;

impl EditKind for Touch {
    fn name(&self) -> &'static str {
        "touch"
    }

    fn summary(&self) -> &'static str {
        "Slide over surfaces and press them."
    }

    fn begin(&self, _edit: &Edit, _tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        Box::new(Touching)
    }
}

/// A touch under way; all it needs between steps is the tool's proxy.
pub(super) struct Touching;

impl Action for Touching {
    fn is_fingertip(&self) -> bool {
        true
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPlace>,
    ) -> Result<(), LatticeError> {
        let hand = step.hand.position;
        let triangle = tool.proxy.touch.and_then(|touch| Some((touch.body, touch.triangle?)));
        let carried =
            triangle.map(|(body, triangle)| triangle.positions(&mut step.bodies[body as usize])).transpose()?.flatten();
        let anchor = tool.slide_proxy(step, carried.map(|(now, _)| now).or(contact.map(|place| place.now)))?;
        let Some(touch) = tool.proxy.touch else {
            tool.surface.leave();
            return Ok(());
        };
        let body = &mut step.bodies[touch.body as usize];
        if Tool::meets_samples(&tool.proxy.shape, body.discretization.edge()) {
            return stand_in_layer(tool, body, hand, touch, anchor);
        }
        let free = tool.proxy.position;
        let p = anchor.map_or(free, |anchor| apply_friction(free, anchor, hand, touch.normal, tool.friction));
        tool.proxy.position = p;
        tool.presses.extend(direction(touch.normal).map(|normal| (-normal, 1.0)));
        let carried = touch.triangle.map(|triangle| triangle.positions(body)).transpose()?.flatten();
        let (now, settled) = carried.map_or_else(|| body.embed_point(touch.rest), Ok)?;
        tool.depth = (settled - now).dot(&touch.normal);
        let pulled = tool.coupling.stiffness * (hand - p);
        if touch.triangle.and_then(|triangle| triangle.coarse_corners(body)).is_some() {
            return tool.press_corners(body, touch.body, pulled);
        }
        tool.press_disc(body, touch.body, touch.rest, touch.rest_normal, pulled)
    }
}

/// Puts the proxy where the layer of the surface balances the coupling, and loads the samples it is pressed against.
fn stand_in_layer(
    tool: &mut Tool,
    body: &mut Body,
    hand: Vec3,
    touch: Contact,
    anchor: Option<Vec3>,
) -> Result<(), LatticeError> {
    let (coupling, near) = (tool.coupling, tool.proxy.near());
    let shape = tool.proxy.shape.clone();
    let layer = Layer { shape: &shape, coupling: coupling.stiffness, stiffness: body.layer_stiffness };
    let frictionless = |from| {
        let (p, felt) = layer.balance(near, from, hand, None);
        (p, direction(felt).unwrap_or(touch.normal))
    };
    let (p, normal) = match anchor {
        Some(anchor) if tool.friction.static_coefficient > 0.0 => {
            rest_with_friction(tool, &layer, Slide { anchor, hand, normal: touch.normal })
                .unwrap_or_else(|| frictionless(tool.proxy.position))
        }
        _ => frictionless(tool.proxy.position),
    };
    let mut total = 0.0;
    let [mut pushed, mut point, mut rest] = [Vec3::zeros(); 3];
    for push in layer.pushes(near, p) {
        total += push.magnitude;
        pushed += push.force;
        point += push.magnitude * push.point;
        rest += push.magnitude * push.rest;
    }
    if total == 0.0 {
        tool.proxy.position = p;
        return Ok(());
    }
    let pulled = coupling.stiffness * (hand - p);
    // What the pushes leave of the pull is friction's; it is shared as they are.
    let friction = pulled - pushed;
    let (scale, spring) = coupling.cap(pulled);
    tool.loads.clear();
    for push in layer.pushes(near, p) {
        let share = push.magnitude / total;
        tool.presses.extend(direction(push.point - p).map(|towards| (towards, share)));
        let sideways = diagonal(share * coupling.stiffness);
        let stiffness = std::array::from_fn(|e| spring * (push.stiffness[e] + sideways[e]));
        let force = scale * (push.force + share * friction);
        tool.loads.push(push.rest, force, stiffness, diagonal(spring * share * coupling.damping));
    }
    let touch = Contact { rest: rest / total, normal, triangle: None, ..touch };
    tool.proxy.set_contact(p, point / total, touch);
    let (now, settled) = body.embed_point(touch.rest)?;
    tool.depth = (settled - now).dot(&normal);
    tool.attach_loads(body, touch.body)
}

/// Where a ball would be held by friction, and what pulls it.
#[derive(Clone, Copy)]
struct Slide {
    /// m, where the surface has carried the ball
    anchor: Vec3,
    /// m, the hand
    hand: Vec3,
    /// Unit, out of the surface.
    normal: Vec3,
}

/// Where a ball rests that the surface has carried to the anchor, and the normal there: the direction of what the
/// layer does to it. It sticks inside the friction cone and slides up to it. `None` where the layer does not reach it.
fn rest_with_friction(tool: &Tool, layer: &Layer<'_>, slide: Slide) -> Option<(Vec3, Vec3)> {
    let Slide { anchor, hand, normal } = slide;
    let near = tool.proxy.near();
    let (p, felt) = layer.balance(near, anchor, hand, Some(normal));
    let normal = direction(felt)?;
    let pull = hand - p;
    let press = -pull.dot(&normal);
    let along = pull + press * normal;
    let slide = along.norm();
    if slide <= tool.friction.static_coefficient * press {
        return Some((p, normal));
    }
    let slid = p + (1.0 - tool.friction.kinetic_coefficient * press.max(0.0) / slide).max(0.0) * along;
    let (p, felt) = layer.balance(near, slid, hand, Some(normal));
    Some((p, direction(felt)?))
}
