//! Mirrored hands: tools that an edit with `symmetry` adds, each driven by the mirror image of another tool's hand.
//!
//! A mirrored tool repeats the edit of the original tool on the other side. Its force goes to no device, so a hand feels its own side only.

use super::event::{EventKind, Events};
use super::{Session, ToolSlot};
use crate::body::{Axes, Body, Symmetry, mirrored};
use crate::tool::Hand;
use nalgebra::{Quaternion, UnitQuaternion};
use pliant_solver::Vec3;

/// The reflection between a tool and its original.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Index of the original tool.
    pub of: usize,
    /// Axes of the scene that are reflected.
    pub axes: Axes,
    /// A point on all mirror planes, m.
    pub centre: Vec3,
}

impl Mirror {
    /// The mirror image of a hand.
    pub fn hand(&self, hand: &Hand) -> Hand {
        let mut image = hand.clone();
        image.position = self.centre + mirrored(hand.position - self.centre, self.axes);
        image.rotation = self.rotation(hand.rotation);
        image
    }

    /// The reflected rotation `M R M` with the reflection M; a rotation axis is a pseudovector.
    fn rotation(&self, rotation: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        let turns = self.axes.iter().filter(|a| **a).count() % 2 == 1;
        let axis = mirrored(rotation.imag(), self.axes);
        let axis = if turns { -axis } else { axis };
        UnitQuaternion::new_unchecked(Quaternion::from_parts(rotation.w, axis))
    }

    /// The axes as text, such as `x and z`.
    pub fn words(axes: Axes) -> String {
        let names: Vec<&str> = ["x", "y", "z"].into_iter().zip(axes).filter(|(_, set)| *set).map(|(n, _)| n).collect();
        names.join(" and ")
    }
}

impl Session {
    /// Sets the hands of mirrored tools to the mirror images of their originals.
    pub(super) fn mirror_hands(&mut self) {
        for at in 0..self.tools.len() {
            if let Some(mirror) = self.tools[at].mirror {
                self.tools[at].hand = mirror.hand(&self.tools[mirror.of].hand);
            }
        }
    }
}

/// Connects mirrored tools with their originals, with mirror planes through the centre of the first body's bounding box, and pairs that body's vertices.
pub(super) fn join(
    tools: &mut [ToolSlot],
    mirrors: &[Option<(usize, Axes)>],
    bodies: &mut [Body],
    events: &mut Events,
) {
    let Some(body) = bodies.first_mut().filter(|_| mirrors.iter().any(Option::is_some)) else { return };
    let centre = body.model.surface.bounds().centre();
    let mut all = [false; 3];
    for (slot, mirror) in tools.iter_mut().zip(mirrors) {
        let Some((of, axes)) = *mirror else { continue };
        slot.mirror = Some(Mirror { of, axes, centre });
        slot.tool.name = format!("{} mirrored in {}", slot.tool.name, Mirror::words(axes));
        slot.pad = None;
        if let Some(blade) = &mut slot.tool.blade {
            blade.direction = mirrored(blade.direction, axes);
        }
        (0..3).for_each(|i| all[i] |= axes[i]);
    }
    let (symmetry, missing) = Symmetry::new(&body.model, centre, all);
    for axis in missing {
        events.add(EventKind::Model, 0.0, || {
            let name = ["x", "y", "z"][axis];
            format!(
                "body `{}` is not symmetric in {name} about {} m: hands are mirrored, and the shape is what they make it",
                body.name, centre[axis]
            )
        });
    }
    body.symmetry = Some(symmetry);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirrored_hand_has_the_reflected_rotation() {
        let mirror = Mirror { of: 0, axes: [true, false, false], centre: Vec3::new(1.0, 0.0, 0.0) };
        let mut hand = Hand::new(1.0);
        hand.position = Vec3::new(3.0, 2.0, 1.0);
        hand.rotation = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), 0.3);
        let image = mirror.hand(&hand);
        assert_eq!(image.position, Vec3::new(-1.0, 2.0, 1.0));
        for v in [Vec3::x(), Vec3::y(), Vec3::new(0.2, -0.5, 0.7)] {
            let seen = mirrored(hand.rotation * mirrored(v, mirror.axes), mirror.axes);
            assert!((image.rotation * v - seen).norm() < 1e-15);
        }
    }
}
