//! Pull: the hand takes hold of a point of a surface.
//!
//! The anchor P_s stays where it was taken; the force on the hand is K (P_s - P_t) (Qi, Zhu and Fan 2019), the opposite is
//! spread over a disc of the body.

use super::{Action, CarriedPlace, ContactPlace, EditKind, Step};
use crate::body::LatticeError;
use crate::plan::Edit;
use crate::tool::{Hand, Tool};
use pliant_solver::Vec3;

/// Takes hold of a point.
pub(super) struct Pull;

impl EditKind for Pull {
    fn name(&self) -> &'static str {
        "pull"
    }

    fn summary(&self) -> &'static str {
        "Take hold of a point."
    }

    fn keys(&self) -> &'static [&'static str] {
        &["limit"]
    }

    fn begin(&self, edit: &Edit, _tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        Box::new(Pulling { limit: edit.limit, grip: None })
    }
}

/// A pull under way.
struct Pulling {
    /// N, it lets go above this force
    limit: f64,
    grip: Option<Grip>,
}

/// A point of a surface that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Grip {
    at: ContactPlace,
    /// Normal there, in the rest shape; of no particular length
    normal: Vec3,
    /// m, from the point to the hand when it was taken, so that taking it makes no force
    offset: Vec3,
}

/// Radii of the tool within which a pull finds its point.
pub(crate) const GRIP_REACH: f64 = 3.0;

impl Pulling {
    /// Takes hold of the point of a surface nearest to the hand, if one is within reach.
    fn take_grip(&mut self, tool: &mut Tool, step: &mut Step<'_>) -> Result<(), LatticeError> {
        let Step { hand, bodies, moved } = step;
        let hand: &Hand = hand;
        let nearest = tool.surface.nearest(bodies, moved, hand.position, GRIP_REACH * tool.proxy.radius)?;
        self.grip = nearest.map(|near| Grip {
            at: ContactPlace { body: near.body, rest: near.rest },
            normal: near.normal,
            offset: hand.position - near.point,
        });
        Ok(())
    }
}

impl Action for Pulling {
    fn contact(&self, _tool: &Tool) -> Option<ContactPlace> {
        self.grip.map(|grip| grip.at)
    }

    fn holds(&self) -> bool {
        self.grip.is_some()
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<CarriedPlace>,
    ) -> Result<(), LatticeError> {
        tool.proxy.touch = None;
        if self.grip.is_none() {
            self.take_grip(tool, step)?;
        }
        let hand = step.hand.position;
        let Some(grip) = self.grip else {
            tool.proxy.position = hand;
            return Ok(());
        };
        let body = &mut step.bodies[grip.at.body as usize];
        let (now, settled) = match contact {
            Some(place) => (place.now, place.settled),
            None => body.carry_one(grip.at.rest)?,
        };
        tool.proxy.position = now + grip.offset;
        let stretch = hand - tool.proxy.position;
        if tool.coupling.stiffness * stretch.norm() > self.limit {
            tool.slipped += 1;
            self.release();
            tool.stand_free(step.hand);
            return Ok(());
        }
        tool.depth = (now - settled).norm();
        let pulled = tool.coupling.stiffness * stretch;
        tool.press_disc(body, grip.at.body, (grip.at.rest, grip.normal), pulled)
    }

    fn release(&mut self) {
        self.grip = None;
    }
}
