//! A grip: a surface point held by a hand.

use super::{BodyPoint, Step};
use crate::body::LatticeError;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// A gripped surface point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grip {
    /// The point in the rest shape of its body.
    pub at: BodyPoint,
    /// Normal in the rest shape, not normalised.
    pub normal: Vec3,
    /// From the point to the hand at the time of the grip, m; keeps the force zero at that time.
    pub offset: Vec3,
}

/// Largest distance from the hand to a gripped point, in radii of the tool.
pub(crate) const GRIP_REACH: f64 = 3.0;

impl Grip {
    /// Grips the surface point closest to the hand; `None` if none is within reach.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn take(tool: &mut Tool, step: &mut Step<'_>) -> Result<Option<Self>, LatticeError> {
        let (hand, reach) = (step.hand.position, GRIP_REACH * tool.proxy.radius());
        let nearest = tool.surface.nearest(step.bodies, step.moved, hand, reach)?;
        Ok(nearest.map(|near| Self {
            at: BodyPoint { body: near.body, rest: near.rest },
            normal: near.normal,
            offset: hand - near.point,
        }))
    }
}
