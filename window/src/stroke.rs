//! The hands of the session, moved by the pointer.

use crate::symmetry::MirrorPlane;
use pliant_editor::{HandPlace, PointerRay, PointerStroke, StrokeStart, SurfacePoint};
use pliant_engine::tool::Frame as DeviceFrame;
use pliant_live::PointerHandle;
use pliant_solver::Vec3;

/// The hand of the session, and the one that mirrors it.
pub struct HandControl {
    hand: PointerHandle,
    mirror: PointerHandle,
    device_frame: DeviceFrame,
    /// Where the other hand does the same.
    plane: Option<MirrorPlane>,
    stroke: Option<Stroke>,
    /// Where the hand was sent last.
    place: Option<HandPlace>,
}

/// A stroke under way.
struct Stroke {
    path: PointerStroke,
    /// Mask of the button that is held.
    buttons: u32,
    /// s, since it began
    time: f64,
    /// s, since it was let go while the hand was still on its way
    finishing: f64,
}

/// s, in which a hand goes from one place to the next: a frame
const GLIDE: f64 = 1.0 / 60.0;
/// s, before the button is pressed, so that the hand is where it shall take hold
const ARRIVAL: f64 = 0.03;
/// s, that a hand may still be on its way after a stroke was let go
const LONGEST_FINISH: f64 = 5.0;
/// Radii of the tool at which a hand has arrived.
const ARRIVED: f64 = 0.2;
/// Radii of the tool between it and the surface while nothing is pressed.
const HOVER: f64 = 0.6;

impl HandControl {
    /// The hands of a session whose devices stand at `device_frame`.
    pub fn new([hand, mirror]: [PointerHandle; 2], device_frame: DeviceFrame) -> Self {
        Self { hand, mirror, device_frame, plane: None, stroke: None, place: None }
    }

    /// The next stroke is made on both sides of a plane, or on one.
    pub fn set_mirror(&mut self, plane: Option<MirrorPlane>) {
        if self.stroke.is_none() {
            self.plane = plane;
        }
    }

    /// Holds the tool at a place in the scene (m), touching nothing.
    pub fn wait_at(&mut self, position: Vec3) {
        self.send(HandPlace { position, rotation: Default::default() }, 0);
    }

    /// Holds the tool over a point of the surface, touching nothing.
    pub fn hover(&mut self, at: &SurfacePoint, radius: f64) {
        if self.stroke.is_none() {
            let position = at.point + (1.0 + HOVER) * radius * at.normal;
            let rotation = self.place.map_or_else(Default::default, |place| place.rotation);
            self.send(HandPlace { position, rotation }, 0);
        }
    }

    /// Begins a stroke with the button of this mask; gives whether it did.
    pub fn begin(&mut self, start: StrokeStart, buttons: u32) -> bool {
        let Some(path) = PointerStroke::begin(start) else { return false };
        self.stroke = Some(Stroke { path, buttons, time: 0.0, finishing: 0.0 });
        self.advance(0.0);
        true
    }

    /// The stroke under way.
    pub fn stroke(&mut self) -> Option<&mut PointerStroke> {
        self.stroke.as_mut().map(|stroke| &mut stroke.path)
    }

    /// Whether a stroke is under way.
    pub fn is_busy(&self) -> bool {
        self.stroke.is_some()
    }

    /// The pointer has moved.
    pub fn follow(&mut self, ray: PointerRay, hit: Option<SurfacePoint>) {
        if let Some(stroke) = &mut self.stroke {
            stroke.path.follow(ray, hit);
        }
    }

    /// Moves the hand on by `dt` (s).
    pub fn advance(&mut self, dt: f64) {
        let Some(stroke) = &mut self.stroke else { return };
        stroke.time += dt;
        let arrived = stroke.time >= ARRIVAL;
        // A press that waits for the hand does not go in yet.
        let place = stroke.path.advance(if arrived { dt } else { 0.0 });
        let buttons = if arrived { stroke.buttons } else { 0 };
        self.send(place, buttons);
    }

    /// The stroke was let go `dt` (s) after the last call. It ends once the hand, which the simulation has at `hand` (m), has arrived: in slow
    /// motion it lags behind, and what was drawn shall be done. Gives whether it has ended.
    pub fn finish(&mut self, dt: f64, hand: Option<Vec3>, radius: f64) -> bool {
        let Some(stroke) = &mut self.stroke else { return true };
        stroke.finishing += dt;
        let is_late = stroke.finishing > LONGEST_FINISH;
        let lag = hand.zip(self.place).map_or(0.0, |(hand, place)| (hand - place.position).norm());
        if lag > ARRIVED * radius && !is_late {
            return false;
        }
        self.end()
    }

    /// Ends the stroke, if there is one.
    pub fn end(&mut self) -> bool {
        let ended = self.stroke.take().is_some();
        if let (true, Some(place)) = (ended, self.place) {
            self.send(place, 0);
        }
        ended
    }

    /// Where the hand was sent last, m.
    pub fn position(&self) -> Option<Vec3> {
        self.place.map(|place| place.position)
    }

    fn send(&mut self, place: HandPlace, buttons: u32) {
        self.place = Some(place);
        glide(&mut self.hand, &self.device_frame, &place, buttons);
        if let Some(plane) = &self.plane {
            glide(&mut self.mirror, &self.device_frame, &plane.hand(&place), buttons);
        }
    }
}

/// Sends a hand to a place in the scene.
fn glide(hand: &mut PointerHandle, frame: &DeviceFrame, place: &HandPlace, buttons: u32) {
    let DeviceFrame { origin, rotation, scale } = *frame;
    let back = rotation.inverse();
    let position = back * (place.position - origin) / scale;
    hand.glide_to(position, back * place.rotation, buttons, GLIDE);
}
