//! A place on a surface that the hand moves and the edit itself does not.
//!
//! The surface point closest to the hand will not do: a pressure lifts the surface past a hand that stands still, and the closest point is then on
//! a side of the bulge, which rises in its turn, so the place jumps between the sides in every step; or the surface goes out of reach and comes
//! back when the pressure is gone. Here the place is a material point, and it moves along the surface only as the hand moves.

use super::grip::GRIP_REACH;
use super::{BodyPoint, Step};
use crate::body::{EmbeddedPoint, LatticeError};
use crate::tool::Tool;
use pliant_solver::Vec3;

/// Largest distance by which a place comes back below the hand in a step, in distances that the hand moves in it: the deformation goes with the
/// place and carries it along the surface, and a way along a curved surface is not as long as that of a hand above it.
const RETURN: f64 = 1.0;

/// A surface point that follows the movements of a hand.
#[derive(Debug, Default)]
pub(super) struct CarriedPlace {
    carried: Option<Carried>,
}

/// The place at the last step.
#[derive(Clone, Copy, Debug)]
struct Carried {
    at: BodyPoint,
    /// Unit normal of the present shape when the place was found; zero where there is none.
    normal: Vec3,
    /// Position of the hand, m.
    hand: Vec3,
}

impl CarriedPlace {
    /// The place in the rest shape of its body; `None` where the hand is at no body.
    pub fn at(&self) -> Option<BodyPoint> {
        self.carried.map(|carried| carried.at)
    }

    /// Follows the hand; `contact` is the embedded position of the present place. The place is given up where the hand is out of the reach of a
    /// grip, to which is added how far the surface has moved there, up to `region`, the radius of the edit's region (m). Returns the new place.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPoint>,
        region: impl Fn(f64) -> f64,
    ) -> Result<Option<BodyPoint>, LatticeError> {
        let (hand, reach) = (step.hand.position, GRIP_REACH * tool.proxy.radius());
        let (near_to, reach) = match (self.carried.take(), contact) {
            (Some(carried), Some(EmbeddedPoint { now, settled })) => {
                let edge = step.bodies[carried.at.body as usize].discretization.edge();
                let reach = reach + (now - settled).norm().min(region(edge));
                if (hand - now).norm() > reach {
                    return Ok(None);
                }
                if hand == carried.hand {
                    self.carried = Some(carried);
                    return Ok(self.at());
                }
                (carried.image(hand, now), reach)
            }
            _ => (hand, reach),
        };
        let near = tool.surface.nearest(step.bodies, step.moved, near_to, reach)?;
        self.carried = near.map(|near| Carried {
            at: BodyPoint { body: near.body, rest: near.rest },
            normal: near.normal.try_normalize(0.0).unwrap_or_default(),
            hand,
        });
        Ok(self.at())
    }

    /// Gives the place up.
    pub fn release(&mut self) {
        self.carried = None;
    }
}

impl Carried {
    /// Where the place, now at `now`, goes with the hand, before it is brought back to the surface, m: along the surface as the hand moves to
    /// `hand`, and towards it.
    fn image(&self, hand: Vec3, now: Vec3) -> Vec3 {
        let along = |v: Vec3| v - self.normal * v.dot(&self.normal);
        let moved = hand - self.hand;
        now + along(moved) + along(hand - moved - now).cap_magnitude(RETURN * moved.norm())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The image of a place at the origin of a plane when a hand goes from `hand` by `moved`.
    fn image(hand: Vec3, moved: Vec3) -> Vec3 {
        let at = BodyPoint { body: 0, rest: Vec3::zeros() };
        Carried { at, normal: Vec3::z(), hand }.image(hand + moved, Vec3::zeros())
    }

    #[test]
    fn a_place_moves_along_the_surface_with_the_hand_above_it() {
        assert_eq!(image(3.0 * Vec3::z(), Vec3::new(1.0, 2.0, -0.5)), Vec3::new(1.0, 2.0, 0.0));
    }

    #[test]
    fn a_place_that_is_left_behind_comes_back_as_far_as_the_hand_moves() {
        assert_eq!(image(-10.0 * Vec3::x(), Vec3::y()), Vec3::new(-RETURN, 1.0, 0.0));
        assert_eq!(image(0.5 * Vec3::x(), Vec3::y()), Vec3::new(0.5, 1.0, 0.0));
    }
}
