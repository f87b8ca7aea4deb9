//! Which bodies of a scene meet each other, and which meet themselves.

use super::Plan;
use crate::contact::CollisionSettings;
use crate::scene::{BodyScene, DEFAULT_FRICTION, Extent, Scene, SceneError, Source};

/// Whether a body is to meet others.
fn meets(body: &BodyScene) -> bool {
    body.meets.as_ref().is_some_and(|meets| *meets.get_ref())
}

/// Whether a body is to meet itself.
fn meets_itself(body: &BodyScene) -> bool {
    body.self_contact.as_ref().is_some_and(|itself| *itself.get_ref())
}

/// Checks the keys of a body for contact with bodies.
///
/// # Errors
/// Returns an error if the body is to meet others or itself and cannot, or if it has friction and meets nothing.
pub(super) fn check(body: &BodyScene, scene: &Scene, source: &Source) -> Result<(), SceneError> {
    let name = body.name.get_ref();
    for (key, given) in [("meets", &body.meets), ("self-contact", &body.self_contact)] {
        let Some(given) = given.as_ref().filter(|given| *given.get_ref()) else { continue };
        let why = if scene.time.integrator.scheme().is_some_and(|scheme| !scheme.has_inertia()) {
            "allowed is an integrator with inertia, as `backward-euler`: contact between bodies is found in their motion"
        } else if key == "self-contact" && body.sheet.is_none() {
            "allowed is a `sheet`: the cells of a solid keep its sides apart until they turn over"
        } else if body.extent() == Extent::Local {
            "allowed is `grid = { region = \"whole\" }`: of a local region only cells around tools move"
        } else if key == "meets" && scene.body.iter().filter(|body| meets(body)).count() < 2 {
            "it is the only one; allowed are two bodies or more with `meets = true`, which then meet each other"
        } else {
            continue;
        };
        return Err(source.error(given.span(), format!("`{key} = true` of body `{name}`; {why}")));
    }
    match &body.friction {
        Some(friction) if !meets(body) && !meets_itself(body) => {
            let text = format!(
                "`friction` of body `{name}`, which meets nothing; allowed is with `meets = true` or `self-contact = true` (tools and obstacles have \
                 a `friction` of their own)"
            );
            Err(source.error(friction.span(), text))
        }
        _ => Ok(()),
    }
}

impl Plan {
    /// Finds how bodies meet others. A body that others may push moves.
    pub(super) fn find_collisions(&mut self, scene: &Scene) {
        let is_moved = scene.body.iter().zip(&self.moving).any(|(body, moves)| *moves && meets(body));
        for (body, moves) in scene.body.iter().zip(&mut self.moving) {
            let meets = is_moved && meets(body);
            *moves |= meets;
            let friction = body.friction.as_ref().map_or(DEFAULT_FRICTION, |friction| *friction.get_ref());
            self.collisions.push(CollisionSettings { meets, meets_itself: meets_itself(body), friction });
        }
        if !self.collisions.iter().any(|settings| settings.meets) {
            let why = match scene.body.len() {
                0 | 1 => "there are no two bodies",
                _ if scene.body.iter().any(meets) => "none of the bodies with `meets = true` moves",
                _ => "no body has `meets = true`",
            };
            self.leave_out("contact of bodies with each other", why);
        }
        if !self.collisions.iter().any(|settings| settings.meets_itself) {
            self.leave_out("contact of sheets with themselves", "no body has `self-contact = true`");
        }
    }
}
