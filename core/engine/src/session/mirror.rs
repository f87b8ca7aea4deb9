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
    /// Whether the tool has a hand: it does not while [`SessionCommand::SetSymmetry`](super::SessionCommand::SetSymmetry) leaves out one of its axes.
    pub is_active: bool,
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
    /// Sets the hands of mirrored tools to the mirror images of their originals; a tool that has just got one appears there, without a path from its last
    /// place.
    pub(super) fn mirror_hands(&mut self) {
        self.pair_vertices();
        for at in 0..self.tools.len() {
            let Some(mirror) = self.tools[at].mirror else { continue };
            let was_present = self.tools[at].hand.present;
            let image = mirror.hand(&self.tools[mirror.of].hand);
            let slot = &mut self.tools[at];
            slot.hand = image;
            if !mirror.is_active {
                slot.hand.leave();
            } else if slot.hand.present && !was_present {
                slot.tool.release(&slot.hand);
            }
        }
    }

    /// Mirrors hands along `axes` about `centre` (m) from now on, as far as the scene has mirrored tools for it. Returns whether it has any.
    pub(super) fn set_symmetry(&mut self, axes: Axes, centre: Vec3) -> bool {
        let mut has_mirrors = false;
        for mirror in self.tools.iter_mut().filter_map(|slot| slot.mirror.as_mut()) {
            mirror.centre = centre;
            mirror.is_active = (0..3).all(|i| axes[i] || !mirror.axes[i]);
            has_mirrors = true;
        }
        if has_mirrors {
            self.unpaired = Some((axes, centre));
        }
        has_mirrors
    }

    /// An edit of a tool begins: whether it is mirrored says what its changes are. Mirrored tools belong to their originals.
    pub(super) fn begin_symmetric_edit(&mut self, tool: usize) {
        if self.tools[tool].mirror.is_some() {
            return;
        }
        if self.bodies.iter().all(|body| body.symmetry.is_none()) {
            return;
        }
        self.update_surface();
        let is_mirrored =
            self.tools.iter().filter_map(|slot| slot.mirror).any(|image| image.of == tool && image.is_active);
        for body in &mut self.bodies {
            if let Some(symmetry) = &mut body.symmetry {
                symmetry.begin_edit(is_mirrored, &body.model, &body.skin);
            }
        }
    }

    /// Pairs the vertices of all bodies about the planes that were set last, if that has not been done: it looks at every vertex, and an editor switches a
    /// scene's symmetry off before the first step.
    pub(super) fn pair_vertices(&mut self) {
        let Some((axes, centre)) = self.unpaired.take() else { return };
        self.update_surface();
        let time = self.time();
        for body in &mut self.bodies {
            pair(body, centre, axes, time, &mut self.events);
        }
        // Undo may bring these back.
        for body in self.divided.aside_mut() {
            body.symmetry = axes.contains(&true).then(|| Symmetry::new(&body.model, &body.skin, centre, axes).0);
        }
    }
}

/// Pairs the vertices of a body about the planes through `centre` (m) normal to each of `axes`; with none its vertices are no longer paired.
fn pair(body: &mut Body, centre: Vec3, axes: Axes, time: f64, events: &mut Events) {
    body.symmetry = None;
    if !axes.contains(&true) {
        return;
    }
    let (symmetry, missing) = Symmetry::new(&body.model, &body.skin, centre, axes);
    for axis in missing {
        events.add(EventKind::Model, time, || {
            let name = ["x", "y", "z"][axis];
            format!(
                "body `{}` is not symmetric in {name} about {} m: hands are mirrored, and the shape is what they make it",
                body.name, centre[axis]
            )
        });
    }
    body.symmetry = Some(symmetry);
}

/// Connects mirrored tools with their originals, with mirror planes through the centre of the first body's bounding box. Returns the axes and the centre (m)
/// about which vertices are to be paired; `None` without mirrored tools.
pub(super) fn join(tools: &mut [ToolSlot], mirrors: &[Option<(usize, Axes)>], bodies: &[Body]) -> Option<(Axes, Vec3)> {
    let body = bodies.first().filter(|_| mirrors.iter().any(Option::is_some))?;
    let centre = body.model.surface.bounds().centre();
    let mut all = [false; 3];
    for (slot, mirror) in tools.iter_mut().zip(mirrors) {
        let Some((of, axes)) = *mirror else { continue };
        slot.mirror = Some(Mirror { of, axes, centre, is_active: true });
        slot.tool.name = format!("{} mirrored in {}", slot.tool.name, Mirror::words(axes));
        slot.pad = None;
        if let Some(blade) = &mut slot.tool.blade {
            blade.direction = mirrored(blade.direction, axes);
        }
        (0..3).for_each(|i| all[i] |= axes[i]);
    }
    Some((all, centre))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirrored_hand_has_the_reflected_rotation() {
        let mirror = Mirror { of: 0, axes: [true, false, false], centre: Vec3::new(1.0, 0.0, 0.0), is_active: true };
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
