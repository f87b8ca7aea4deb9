//! A touch that changes the body below it: the tool presses as in the edit `touch`, and every [`INTERVAL`] the body is changed around the contact.

use super::touch::Touching;
use super::{Action, BodyPoint, Step};
use crate::body::{EmbeddedPoint, LatticeError};
use crate::tool::Tool;

/// Time between two changes of a body, s: each one computes the rest data of every active element again.
const INTERVAL: f64 = 8e-3;

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
