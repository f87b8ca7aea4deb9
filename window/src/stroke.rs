//! The hand of the session, moved by the pointer.

use pliant_editor::{HandPlace, PointerRay, PointerStroke, StrokeStart, SurfacePoint};
use pliant_engine::tool::Frame as DeviceFrame;
use pliant_live::PointerHandle;
use pliant_solver::Vec3;

/// The hand of the session.
pub struct HandControl {
    hand: PointerHandle,
    device_frame: DeviceFrame,
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
}

/// s, in which a hand goes from one place to the next: a frame
const GLIDE: f64 = 1.0 / 60.0;
/// s, before the button is pressed, so that the hand is where it shall take hold
const ARRIVAL: f64 = 0.03;
/// Radii of the tool between it and the surface while nothing is pressed.
const HOVER: f64 = 0.6;

impl HandControl {
    /// The hand of a session whose device stands at `device_frame`.
    pub fn new(hand: PointerHandle, device_frame: DeviceFrame) -> Self {
        Self { hand, device_frame, stroke: None, place: None }
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
        self.stroke = Some(Stroke { path, buttons, time: 0.0 });
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
        let DeviceFrame { origin, rotation, scale } = self.device_frame;
        let back = rotation.inverse();
        let position = back * (place.position - origin) / scale;
        self.hand.glide_to(position, back * place.rotation, buttons, GLIDE);
    }
}
