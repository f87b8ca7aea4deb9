//! Grab: a soft region of a body follows the hand, its position and its orientation.

use super::brush::BrushShape;
use super::grip::Hold;
use super::key::{FALLOFF, Key, KeyName, RADIUS};
use super::region::CoupledRegion;
use super::{Action, BodyPoint, EditKind, Step};
use crate::body::{EmbeddedPoint, LatticeError};
use crate::plan::Edit;
use crate::tool::Tool;

/// Moves and rotates a soft region with the hand.
pub(super) struct Grab;

impl EditKind for Grab {
    fn name(&self) -> &'static str {
        "grab"
    }

    fn summary(&self) -> &'static str {
        "Move and turn a soft region with the hand."
    }

    fn keys(&self) -> &'static [Key] {
        &[RADIUS, FALLOFF, Key { name: KeyName::Limit, default: "none", summary: "It lets go above this force." }]
    }

    fn grips(&self) -> bool {
        true
    }

    fn renders_torque(&self) -> bool {
        true
    }

    fn begin(&self, edit: &Edit, tool: &Tool, _bodies: usize) -> Box<dyn Action> {
        let shape = BrushShape::of(edit, tool);
        let limit = edit.limit.unwrap_or(f64::INFINITY);
        Box::new(Grabbing { limit, hold: Hold::default(), region: CoupledRegion::new(shape, true) })
    }
}

/// A grab in progress.
struct Grabbing {
    /// Force above which it lets go, N.
    limit: f64,
    hold: Hold,
    region: CoupledRegion,
}

impl Action for Grabbing {
    fn contact(&self, _tool: &Tool) -> Option<BodyPoint> {
        self.hold.grip().map(|grip| grip.at)
    }

    fn extra_region_radius(&self, edge: f64) -> f64 {
        self.region.radius(edge)
    }

    fn is_gripping(&self) -> bool {
        self.hold.grip().is_some()
    }

    fn renders_torque(&self) -> bool {
        true
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        _contact: Option<EmbeddedPoint>,
    ) -> Result<(), LatticeError> {
        tool.proxy.touch = None;
        let Some(grip) = self.hold.take(tool, step)? else {
            tool.proxy.position = step.hand.position;
            return Ok(());
        };
        let body = &step.bodies[grip.at.body as usize];
        if self.region.follow(tool, step.hand, body, grip.at)? > self.limit {
            self.release();
            self.hold.let_go(tool, step);
        }
        Ok(())
    }

    fn release(&mut self) {
        self.hold = Hold::Nothing;
        self.region.release();
    }
}
