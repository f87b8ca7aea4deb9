//! A grip: the point of a surface a hand has taken hold of.

use super::{ContactPlace, Step};
use crate::body::LatticeError;
use crate::tool::Tool;
use pliant_solver::Vec3;

/// A point of a surface that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grip {
    /// Body and rest place that is held.
    pub at: ContactPlace,
    /// Normal there, in the rest shape; of no particular length
    pub normal: Vec3,
    /// m, from the point to the hand when it was taken, so that taking it makes no force
    pub offset: Vec3,
}

/// Radii of the tool within which a grip finds its point.
pub(crate) const GRIP_REACH: f64 = 3.0;

impl Grip {
    /// Of the point of a surface nearest to the hand, if one is within reach.
    ///
    /// # Errors
    /// What the grid says.
    pub fn take(tool: &mut Tool, step: &mut Step<'_>) -> Result<Option<Self>, LatticeError> {
        let (hand, reach) = (step.hand.position, GRIP_REACH * tool.proxy.radius());
        let nearest = tool.surface.nearest(step.bodies, step.moved, hand, reach)?;
        Ok(nearest.map(|near| Self {
            at: ContactPlace { body: near.body, rest: near.rest },
            normal: near.normal,
            offset: hand - near.point,
        }))
    }
}
