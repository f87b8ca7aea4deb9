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

/// What a hand holds in a stroke: once it has let go of a surface it takes hold of none until the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Hold {
    /// Nothing was in reach yet.
    #[default]
    Nothing,
    /// A gripped point.
    Held(Grip),
    /// It has let go.
    LetGo,
}

impl Hold {
    /// The grip, if there is one.
    pub fn grip(&self) -> Option<Grip> {
        match self {
            Self::Held(grip) => Some(*grip),
            Self::Nothing | Self::LetGo => None,
        }
    }

    /// The grip; where the hand has held nothing yet, that of the surface point closest to it, if one is within reach.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn take(&mut self, tool: &mut Tool, step: &mut Step<'_>) -> Result<Option<Grip>, LatticeError> {
        if *self == Self::Nothing {
            *self = Grip::take(tool, step)?.map_or(Self::Nothing, Self::Held);
        }
        Ok(self.grip())
    }

    /// Lets go because the force is over the limit of the edit.
    pub fn let_go(&mut self, tool: &mut Tool, step: &Step<'_>) {
        *self = Self::LetGo;
        tool.slipped += 1;
        tool.release_to_hand(step.hand);
    }
}
