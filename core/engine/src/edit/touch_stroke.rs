//! A touch that changes the body below it: the tool presses as in the edit `touch`, and every [`INTERVAL`] the body is changed around the contact.

use super::brush::BrushShape;
use super::touch::Touching;
use super::{Action, BodyPoint, Step};
use crate::body::{EmbeddedPoint, LatticeError};
use crate::tool::Tool;

/// Time between two changes of a body, s: each one computes the rest data of every active element again.
pub(crate) const INTERVAL: f64 = 8e-3;

/// A touch in progress, and the time since it last changed a body.
pub(super) struct TouchStroke {
    touching: Touching,
    /// Time since the last change, s.
    since_update: f64,
}

/// A change of a body that is due.
pub(super) struct Due {
    /// The contact around which the body changes.
    pub at: BodyPoint,
    /// Time since the last change, s.
    pub seconds: f64,
}

impl TouchStroke {
    /// A touch that has changed nothing.
    pub fn new() -> Self {
        Self { touching: Touching, since_update: 0.0 }
    }

    /// The contact of the touch; `None` without contact.
    pub fn contact(&self, tool: &Tool) -> Option<BodyPoint> {
        self.touching.contact(tool)
    }

    /// Follows the hand as a touch does. Returns the change that is due in this step.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    pub fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPoint>,
    ) -> Result<Option<Due>, LatticeError> {
        self.touching.follow(tool, step, contact)?;
        self.since_update += step.time.dt;
        if self.since_update < INTERVAL {
            return Ok(None);
        }
        let seconds = std::mem::take(&mut self.since_update);
        let at = match tool.proxy.touch {
            Some(touch) => Some(BodyPoint { body: touch.body, rest: touch.rest }),
            None => tool.sheet_below(step.bodies),
        };
        Ok(at.map(|at| Due { at, seconds }))
    }
}

/// What a touch does to the body below it.
pub(super) trait BodyChange: Send {
    /// Makes a change that is due, in a soft region of this shape. Returns whether anything has changed.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    fn change(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        shape: BrushShape,
        due: Due,
    ) -> Result<bool, LatticeError>;
}

/// An edit that is a touch with a change of the body.
pub(super) struct ChangingTouch<C> {
    shape: BrushShape,
    stroke: TouchStroke,
    change: C,
}

impl<C: BodyChange + 'static> ChangingTouch<C> {
    /// Begins a stroke that makes `change` in soft regions of this shape.
    pub fn begin(shape: BrushShape, change: C) -> Box<dyn Action> {
        Box::new(Self { shape, stroke: TouchStroke::new(), change })
    }
}

impl<C: BodyChange> Action for ChangingTouch<C> {
    fn contact(&self, tool: &Tool) -> Option<BodyPoint> {
        self.stroke.contact(tool)
    }

    fn extra_region_radius(&self, edge: f64) -> f64 {
        self.shape.radius_at(edge)
    }

    fn is_fingertip(&self) -> bool {
        true
    }

    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPoint>,
    ) -> Result<(), LatticeError> {
        if let Some(due) = self.stroke.follow(tool, step, contact)? {
            tool.changed_body |= self.change.change(tool, step, self.shape, due)?;
        }
        Ok(())
    }
}
