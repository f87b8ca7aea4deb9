//! Pull: the hand grips a point of a surface.
//!
//! The anchor P_s moves with the gripped point; the force on the hand is K (P_s - P_t) (Qi, Zhu and Fan 2019). The opposite force is distributed
//! over a disc of three cells, or over the part of the body within the tool's radius if that is larger than 1.5 cells.

use super::brush::{BrushShape, Falloff, MIN_RADIUS_EDGES};
use super::grip::Hold;
use super::key::{Key, KeyName};
use super::region::CoupledRegion;
use super::{Action, BodyPoint, EditKind, Step};
use crate::body::{EmbeddedPoint, LatticeError};
use crate::plan::Edit;
use crate::tool::Tool;

/// Grips a surface point and pulls it with the hand.
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

    fn grips(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        let shape = BrushShape { radius: tool.proxy.radius(), falloff: Falloff::Sphere };
        Box::new(Pulling {
            limit: edit.limit.unwrap_or(LIMIT),
            hold: Hold::default(),
            radius: shape.radius,
            region: CoupledRegion::new(shape, false),
        })
    }
}

/// A pull in progress.
struct Pulling {
    /// Force above which it lets go, N.
    limit: f64,
    hold: Hold,
    /// Radius of the tool, m.
    radius: f64,
    /// The region it pulls if cells are finer than the tool.
    region: CoupledRegion,
}

/// Default of `limit`, N.
const LIMIT: f64 = 3.0;

impl Pulling {
    /// Lets go because the force exceeds the limit.
    fn let_go(&mut self, tool: &mut Tool, step: &Step<'_>) {
        self.release();
        self.hold.let_go(tool, step);
    }
}

impl Action for Pulling {
    fn contact(&self, _tool: &Tool) -> Option<BodyPoint> {
        self.hold.grip().map(|grip| grip.at)
    }

    fn is_gripping(&self) -> bool {
        self.hold.grip().is_some()
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPoint>,
    ) -> Result<(), LatticeError> {
        tool.proxy.touch = None;
        let hand = step.hand.position;
        let Some(grip) = self.hold.take(tool, step)? else {
            tool.proxy.position = hand;
            return Ok(());
        };
        let body = &mut step.bodies[grip.at.body as usize];
        if self.radius > MIN_RADIUS_EDGES * body.discretization.edge() {
            if self.region.follow(tool, step.hand, body, grip.at)? > self.limit {
                self.let_go(tool, step);
            }
            return Ok(());
        }
        let EmbeddedPoint { now, settled } = contact.map_or_else(|| body.embed_point(grip.at.rest), Ok)?;
        tool.proxy.position = now + grip.offset;
        let stretch = hand - tool.proxy.position;
        if tool.coupling_factor * tool.coupling.stiffness * stretch.norm() > self.limit {
            self.let_go(tool, step);
            return Ok(());
        }
        tool.depth = (now - settled).norm();
        let pulled = tool.coupling.stiffness * stretch;
        tool.press_disc(body, grip.at.body, grip.at.rest, grip.normal, pulled)
    }

    fn release(&mut self) {
        self.hold = Hold::Nothing;
        self.region.release();
    }
}
