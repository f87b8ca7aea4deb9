//! Where tools touch and where blades are, for viewers.

use pliant_engine::session::{Session, ToolSlot};
use pliant_solver::Vec3;

/// A point where a tool touches a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Index of the tool in the session.
    pub tool: usize,
    /// Place on the surface of the tool in the scene, m.
    pub position: Vec3,
    /// Unit vector from the tool into the body.
    pub direction: Vec3,
    /// Share of the contact force of the tool, 0 to 1.
    pub share: f64,
}

/// The edge of a blade in a hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BladeEdgeView {
    /// Index of the tool in the session.
    pub tool: usize,
    /// Both ends in the scene, first the one in the hand, m.
    pub ends: [Vec3; 2],
}

/// Lists where the tools of a session touch, in the place of what was listed before.
pub(super) fn list_contacts(session: &Session, points: &mut Vec<ContactPoint>) {
    points.clear();
    for (tool, (slot, felt)) in session.tools.iter().zip(&session.frame().tools).enumerate() {
        if felt.contact.is_none() || !slot.hand.present {
            continue;
        }
        let (centre, radius) = (felt.proxy, slot.tool.proxy.radius());
        let point = |direction: Vec3, share: f64| ContactPoint {
            tool,
            position: centre + radius * direction,
            direction,
            share,
        };
        if felt.grips {
            // What is gripped is held at the proxy.
            let direction = (-felt.force).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            points.push(ContactPoint { position: centre, ..point(direction, 1.0) });
        } else if slot.tool.contact_directions.is_empty() {
            // A tip on a sheet has no list of its contacts: the sheet pushes it away from where it touches.
            points.extend((-felt.force).try_normalize(0.0).map(|direction| point(direction, 1.0)));
        } else {
            points.extend(slot.tool.contact_directions.iter().map(|(direction, share)| point(*direction, *share)));
        }
    }
}

/// Lists the blades of the hands that are present.
pub(super) fn list_blades(session: &Session, blades: &mut Vec<BladeEdgeView>) {
    blades.clear();
    let edge = |(tool, slot): (usize, &ToolSlot)| {
        let blade = slot.tool.blade.as_ref().filter(|_| slot.hand.present)?;
        let tip = slot.hand.position;
        Some(BladeEdgeView { tool, ends: [tip, tip + slot.hand.rotation * (blade.length * blade.direction)] })
    };
    blades.extend(session.tools.iter().enumerate().filter_map(edge));
}
