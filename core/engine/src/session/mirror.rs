//! Mirrored hands: tools that an edit with `symmetry` adds, each driven by the mirror image of another tool's hand.
//!
//! A mirrored tool repeats the edit of the original tool on the other side. Its force goes to no device, so a hand feels its own side only.

use super::event::{EventKind, Events};
use super::{Session, ToolSlot};
use crate::body::{Axes, Body, Model, Reflection, Symmetry, SymmetryPlane};
use crate::edit::{EdgeInside, STRIDE};
use crate::plan::Image;
use crate::tool::{Hand, PreviousPose};
use nalgebra::UnitQuaternion;
use pliant_mesh::Surface;
use pliant_solver::Vec3;

/// Largest difference of the unit vectors in which two blades cut that go along with each other.
const SAME_HEADING: f64 = 0.2;

/// The reflection between a tool and its original.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Index of the original tool.
    pub of: usize,
    /// How the scene asks for it.
    pub image: Image,
    /// How it is reflected.
    pub reflection: Reflection,
    /// A point on all mirror planes, m.
    pub centre: Vec3,
    /// Whether the tool has a hand: it does not while [`SessionCommand::SetSymmetry`](super::SessionCommand::SetSymmetry) leaves out one of its axes, or all
    /// where it is mirrored in a plane of its own.
    pub is_active: bool,
}

impl Mirror {
    /// The mirror image of a place, m.
    fn point(&self, place: Vec3) -> Vec3 {
        self.centre + self.reflection.vector(place - self.centre)
    }

    /// The mirror image of a hand.
    pub fn hand(&self, hand: &Hand) -> Hand {
        let mut image = hand.clone();
        image.position = self.point(hand.position);
        image.rotation = self.reflection.rotation(hand.rotation);
        image.before = hand.before.map(|before| PreviousPose {
            position: self.point(before.position),
            rotation: self.reflection.rotation(before.rotation),
        });
        image
    }
}

impl Session {
    /// Whether the blade of a mirrored tool goes along with that of its original, or of one mirrored from it before: within a stride of it all along and in the
    /// same direction, so that it would cut the same again beside, or a slab thinner than the lattice parts.
    pub(super) fn cuts_the_same(&self, tool: usize) -> bool {
        let Some(mirror) = self.tools[tool].mirror else { return false };
        let Some(EdgeInside { body, ends, heading }) = self.tools[mirror.of].tool.edge_inside() else { return false };
        let stride = STRIDE * self.bodies[body as usize].discretization.edge();
        self.tools[..tool].iter().enumerate().any(|(index, other)| {
            let image = other.mirror.filter(|image| image.is_active && image.of == mirror.of);
            let place = |point: Vec3| image.map_or(point, |image| image.point(point));
            let direction = |along: Vec3| image.map_or(along, |image| image.reflection.vector(along));
            let is_near = |end: &Vec3| (mirror.point(*end) - place(*end)).norm() < stride;
            // Blades that cross each other are in one place too.
            let turned = heading.map_or(0.0, |along| (mirror.reflection.vector(along) - direction(along)).norm());
            (index == mirror.of || image.is_some()) && ends.iter().all(is_near) && turned < SAME_HEADING
        })
    }

    /// Sets the hands of mirrored tools to the mirror images of their originals; a tool that has just got one appears there, without a path from its last
    /// place.
    pub(super) fn mirror_hands(&mut self) {
        if self.edits_under_way() == 0
            && let Some((axes, centre)) = self.editing.next_symmetry.take()
        {
            self.set_symmetry(axes, centre);
        }
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

    /// Mirrors the hands of the next edits: from now on, or once no edit is under way, for that would begin or end on one side alone. Returns whether the scene has any
    /// mirrored tools.
    pub(super) fn want_symmetry(&mut self, axes: Axes, centre: Vec3) -> bool {
        self.editing.next_symmetry = None;
        if self.edits_under_way() == 0 {
            return self.set_symmetry(axes, centre);
        }
        self.editing.next_symmetry = Some((axes, centre));
        self.tools.iter().any(|slot| slot.mirror.is_some())
    }

    /// Mirrors hands along `axes` about `centre` (m) from now on, as far as the scene has mirrored tools for it, and in planes of their own where `axes` has any. Returns
    /// whether it has any.
    fn set_symmetry(&mut self, axes: Axes, centre: Vec3) -> bool {
        let (mut has_mirrors, mut planes) = (false, normal_to(axes, centre));
        for mirror in self.tools.iter_mut().filter_map(|slot| slot.mirror.as_mut()) {
            match mirror.image {
                Image::Axes(own) => {
                    mirror.centre = centre;
                    mirror.is_active = (0..3).all(|i| axes[i] || !own[i]);
                }
                Image::OwnAxis(_) | Image::Plane { .. } => {
                    mirror.is_active = axes.contains(&true);
                    let own = planes_of(mirror.reflection, mirror.centre).into_iter().filter(|_| mirror.is_active);
                    planes.extend(own.filter(|plane| !planes.contains(plane)).collect::<Vec<_>>());
                }
            }
            has_mirrors = true;
        }
        if has_mirrors {
            self.editing.unpaired = Some(planes);
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
        let Some(planes) = self.editing.unpaired.take() else { return };
        self.update_surface();
        let time = self.time();
        for body in &mut self.bodies {
            if let Err(error) = body.end_symmetry(self.motion.pool()) {
                self.events.add(EventKind::Message, time, || error.to_string());
            }
            pair(body, &planes, time, &mut self.events);
        }
        // Undo may bring these back.
        for body in self.editing.divided.aside_mut() {
            body.symmetry = (!planes.is_empty()).then(|| Symmetry::new(&body.model, &body.skin, &planes).0);
        }
    }
}

/// Pairs the vertices of a body, which are not paired, about planes.
fn pair(body: &mut Body, planes: &[SymmetryPlane], time: f64, events: &mut Events) {
    if planes.is_empty() {
        return;
    }
    let (symmetry, missing) = Symmetry::new(&body.model, &body.skin, planes);
    for SymmetryPlane { reflection, centre } in missing {
        events.add(EventKind::Model, time, || {
            let (name, words, at) = (&body.name, reflection.words(), centre.as_slice());
            format!("body `{name}` is not symmetric in {words} about {at:?} m: hands are mirrored, and the shape is what they make it")
        });
    }
    body.symmetry = Some(symmetry);
}

/// The planes through `centre` (m) normal to each of `axes`.
fn normal_to(axes: Axes, centre: Vec3) -> Vec<SymmetryPlane> {
    let single = |axis: usize| Reflection::Axes(std::array::from_fn(|i| i == axis));
    (0..3).filter(|i| axes[*i]).map(|i| SymmetryPlane { reflection: single(i), centre }).collect()
}

/// The reflection of a mirror image of a hand, and a point (m) on its planes.
fn reflection(image: Image, model: &Model) -> (Reflection, Vec3) {
    let middle = || model.surface.bounds().centre();
    match image {
        Image::Axes(axes) => (Reflection::Axes(axes), middle()),
        Image::Plane { point, normal } => (Reflection::in_plane(normal), point),
        // Without a rotation the exact one, along the same axis of the scene.
        Image::OwnAxis(axis) if model.placement.rotation == UnitQuaternion::identity() => {
            (Reflection::in_plane(Vec3::ith(axis, 1.0)), middle())
        }
        Image::OwnAxis(axis) => {
            let bounds = Surface::from_document(&model.document).bounds();
            let normal = model.placement.rotation * Vec3::ith(axis, 1.0);
            (Reflection::in_plane(normal), model.placement.apply(bounds.centre()))
        }
    }
}

/// Connects mirrored tools with their originals. Returns the planes about which vertices are to be paired; `None` without mirrored tools.
pub(super) fn join(
    tools: &mut [ToolSlot],
    mirrors: &[Option<(usize, Image)>],
    bodies: &[Body],
) -> Option<Vec<SymmetryPlane>> {
    let body = bodies.first().filter(|_| mirrors.iter().any(Option::is_some))?;
    let mut all: Vec<SymmetryPlane> = Vec::new();
    for (slot, mirror) in tools.iter_mut().zip(mirrors) {
        let Some((of, image)) = *mirror else { continue };
        let (reflection, centre) = reflection(image, &body.model);
        slot.mirror = Some(Mirror { of, image, reflection, centre, is_active: true });
        slot.tool.name = format!("{} mirrored in {}", slot.tool.name, reflection.words());
        slot.pad = None;
        if let Some(blade) = &mut slot.tool.blade {
            blade.direction = reflection.in_own_frame(blade.direction);
        }
        for plane in planes_of(reflection, centre) {
            if !all.contains(&plane) {
                all.push(plane);
            }
        }
    }
    Some(all)
}

/// The planes of a reflection about `centre` (m).
fn planes_of(reflection: Reflection, centre: Vec3) -> Vec<SymmetryPlane> {
    match reflection {
        Reflection::Axes(axes) => normal_to(axes, centre),
        Reflection::Plane(_) => vec![SymmetryPlane { reflection, centre }],
    }
}
