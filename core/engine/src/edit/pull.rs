//! Pull: the hand takes hold of a point of a surface.
//!
//! The anchor P_s stays where it was taken; the force on the hand is K (P_s - P_t) (Qi, Zhu and Fan 2019), the opposite is
//! spread over a disc of the body, as wide as the tool, or over what of the body is within the tool's radius where cells are finer
//! than the tool.

use super::brush::{BrushShape, Falloff, LEAST_EDGES};
use super::grip::Grip;
use super::key::{Key, KeyName};
use super::region::Region;
use super::{Action, ContactPlace, EditKind, EmbeddedPlace, Step};
use crate::body::LatticeError;
use crate::plan::Edit;
use crate::tool::Tool;

/// Takes hold of a point.
pub(super) struct Pull;

impl EditKind for Pull {
    fn name(&self) -> &'static str {
        "pull"
    }

    fn summary(&self) -> &'static str {
        "Take hold of a point."
    }

    fn keys(&self) -> &'static [Key] {
        &[Key { name: KeyName::Limit, default: "3 N", summary: "It lets go above this force." }]
    }

    fn takes_hold(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        let shape = BrushShape { radius: tool.proxy.radius(), falloff: Falloff::Sphere };
        Box::new(Pulling {
            limit: edit.limit.unwrap_or(LIMIT),
            grip: None,
            radius: shape.radius,
            region: Region::new(shape, false),
        })
    }
}

/// A pull under way.
struct Pulling {
    /// N, it lets go above this force
    limit: f64,
    grip: Option<Grip>,
    /// m, of the tool
    radius: f64,
    /// Where cells are finer than the tool.
    region: Region,
}

/// N, above which a pull lets go, where the scene says nothing.
const LIMIT: f64 = 3.0;

impl Pulling {
    /// Lets go because of too much force.
    fn let_go(&mut self, tool: &mut Tool, step: &Step<'_>) {
        tool.slipped += 1;
        self.release();
        tool.release_to_hand(step.hand);
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
        contact: Option<EmbeddedPlace>,
    ) -> Result<(), LatticeError> {
        tool.proxy.touch = None;
        if self.grip.is_none() {
            self.grip = Grip::take(tool, step)?;
        }
        let hand = step.hand.position;
        let Some(grip) = self.grip else {
            tool.proxy.position = hand;
            return Ok(());
        };
        let body = &mut step.bodies[grip.at.body as usize];
        if self.radius > LEAST_EDGES * body.discretization.edge() {
            if self.region.follow(tool, step.hand, body, grip.at)? > self.limit {
                self.let_go(tool, step);
            }
            return Ok(());
        }
        let (now, settled) = match contact {
            Some(place) => (place.now, place.settled),
            None => body.embed_point(grip.at.rest)?,
        };
        tool.proxy.position = now + grip.offset;
        let stretch = hand - tool.proxy.position;
        if tool.coupling.stiffness * stretch.norm() > self.limit {
            self.let_go(tool, step);
            return Ok(());
        }
        tool.depth = (now - settled).norm();
        let pulled = tool.coupling.stiffness * stretch;
        tool.press_disc(body, grip.at.body, grip.at.rest, grip.normal, pulled)
    }

    fn release(&mut self) {
        self.grip = None;
        self.region.release();
    }
}
