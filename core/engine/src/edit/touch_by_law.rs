//! A touch of a solid by a contact law of a plugin.

use super::Step;
use crate::body::{EmbeddedPoint, LatticeError};
use crate::contact::{LawStep, Touch as Contact};
use crate::tool::{Tool, direction};
use pliant_solver::{Block, Vec3};

/// Moves the proxy to the equilibrium of the tool's contact law and the coupling, and applies the forces of the law to the samples of the body in contact.
/// Without a law it does nothing.
///
/// # Errors
/// Returns the error of the law or of the grid plugin.
pub(super) fn press_by_law(tool: &mut Tool, step: &mut Step<'_>, touch: Contact) -> Result<(), LatticeError> {
    let Some(mut law) = tool.law.take() else { return Ok(()) };
    let body = &mut step.bodies[touch.body as usize];
    if body.frozen.is_some() {
        law.leave();
        tool.law = Some(law);
        return Ok(());
    }
    let shape = tool.proxy.shape.clone();
    let law_step = LawStep {
        body: touch.body,
        samples: tool.proxy.near(),
        shape: &shape,
        hand: step.hand.position,
        coupling: tool.coupling.stiffness,
        mass: body.layer_mass,
        time: step.time,
        is_explicit: step.is_explicit,
    };
    let balanced = law.balance(&law_step, tool.proxy.position);
    let (pushed, total) = law
        .pushes()
        .fold((Vec3::zeros(), 0.0), |(pushed, total), (.., push)| (pushed + push.force, total + push.force.norm()));
    tool.loads.clear();
    // Within a step a limited force ends where the whole one would, as for other touches.
    let scale = tool.coupling.cap(pushed.norm());
    let mut rest = Vec3::zeros();
    for (place, point, normal, push) in law.pushes().filter(|(.., push)| push.force != Vec3::zeros()) {
        let fraction = push.force.norm() / total;
        rest += fraction * place;
        tool.contact_directions
            .extend(direction(point - tool.proxy.position).or(Some(normal)).map(|towards| (towards, fraction)));
        let scaled = |block: Block| block.map(|entry| scale * entry);
        tool.loads.push(place, scale * push.force, scaled(push.stiffness), scaled(push.damping));
    }
    tool.law = Some(law);
    let position = balanced.map_err(|error| LatticeError::ContactLaw { body: touch.body, error: Box::new(error) })?;
    tool.proxy.position = position;
    if total == 0.0 {
        return Ok(());
    }
    let normal = direction(-pushed).unwrap_or(touch.normal);
    let touch = Contact { rest, normal, triangle: None, ..touch };
    let EmbeddedPoint { now, settled } = body.embed_point(touch.rest)?;
    tool.proxy.set_contact(position, Contact { offset: position - now, ..touch });
    tool.depth = (settled - now).dot(&normal);
    tool.attach_loads(body, touch.body)
}
