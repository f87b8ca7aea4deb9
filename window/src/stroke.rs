//! The hands of the session, moved by the pointer.

use crate::symmetry::MirrorPlane;
use pliant_editor::{
    DeviceHand, DeviceWish, Gesture, HandNews, HandPlace, PointerRay, PointerStroke, StrokeStart, SurfacePoint,
};
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
    /// A device that can have the hand in the place of the pointer.
    device_hand: Option<DeviceHand>,
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
    /// Of a cut that was let go: s, until the blade has gone along the line.
    sweep: Option<f64>,
    /// Of a cut: where the blade waits for the line to be drawn.
    start: Option<HandPlace>,
    /// Of a cut: where the line leads.
    end: Option<HandPlace>,
}

/// s, in which a hand goes from one place to the next: a frame
const GLIDE: f64 = 1.0 / 60.0;
/// s, before the button is pressed, so that the hand is where it shall take hold
const ARRIVAL: f64 = 0.03;
/// s, that a hand may still be on its way after a stroke was let go
const LONGEST_FINISH: f64 = 5.0;
/// Radii of the tool at which a hand has arrived.
const ARRIVED: f64 = 0.2;
/// Speed of a blade along a drawn line, radii of the tool for a second: a new tool crosses a model in a second.
const SWEEP: f64 = 25.0;
/// s, that a cut takes at least
const SHORTEST_SWEEP: f64 = 0.3;
/// Radii of the tool between it and the surface while nothing is pressed.
const HOVER: f64 = 0.6;

impl HandControl {
    /// The hands of a session whose devices stand at `device_frame`.
    pub fn new([hand, mirror]: [PointerHandle; 2], device_hand: Option<DeviceHand>, device_frame: DeviceFrame) -> Self {
        Self { hand, mirror, device_frame, plane: None, stroke: None, place: None, device_hand }
    }

    /// The hands of the pointer, and the device that can have the first.
    pub fn into_hands(mut self) -> ([PointerHandle; 2], Option<DeviceHand>) {
        self.end();
        self.mirror.remove();
        ([self.hand, self.mirror], self.device_hand)
    }

    /// The device that can have the hand.
    pub fn device_hand(&self) -> Option<&DeviceHand> {
        self.device_hand.as_ref()
    }

    /// Whether the device was lost: it can have the hand again once it is opened anew.
    pub fn is_device_lost(&mut self) -> bool {
        self.device_hand.as_mut().is_some_and(DeviceHand::is_lost)
    }

    /// Whether a device has the hand.
    pub fn is_by_device(&self) -> bool {
        self.device_hand.as_ref().is_some_and(DeviceHand::leads)
    }

    /// Gives the hand to the device, or to the pointer; nothing without a device.
    pub fn give_to_device(&mut self, leads: bool) {
        self.end();
        self.mirror.remove();
        if let Some(device_hand) = &mut self.device_hand {
            device_hand.set_leads(leads);
        }
    }

    /// Guides the device for a frame, and the hand that mirrors it; as for [`DeviceHand::advance`].
    pub fn guide_device(&mut self, wish: &DeviceWish) -> HandNews {
        let Some(device_hand) = &mut self.device_hand else { return HandNews::None };
        let news = device_hand.advance(wish);
        let state = device_hand.state();
        match (&self.plane, state.place) {
            (Some(plane), Some(place)) if device_hand.leads() => {
                plane.hand(&place).glide(&mut self.mirror, &self.device_frame, state.buttons, GLIDE);
            }
            _ => self.mirror.remove(),
        }
        news
    }

    /// The next stroke is made on both sides of a plane, or on one.
    pub fn set_mirror(&mut self, plane: Option<MirrorPlane>) {
        if !self.is_busy() {
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
        self.stroke = Some(Stroke { path, buttons, time: 0.0, finishing: 0.0, sweep: None, start: None, end: None });
        self.advance(0.0);
        true
    }

    /// The stroke under way.
    pub fn stroke(&mut self) -> Option<&mut PointerStroke> {
        self.stroke.as_mut().map(|stroke| &mut stroke.path)
    }

    /// Whether a stroke is under way.
    pub fn is_busy(&self) -> bool {
        self.stroke.is_some() || self.device_hand.as_ref().is_some_and(DeviceHand::is_busy)
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
        if stroke.path.gesture() == Gesture::Slice {
            // The line is drawn first; the blade waits at its start.
            let start = *stroke.start.get_or_insert(place);
            stroke.end = Some(place);
            self.send(start, 0);
            return;
        }
        let buttons = if arrived { stroke.buttons } else { 0 };
        self.send(place, buttons);
    }

    /// The stroke was let go `dt` (s) after the last call. It ends once the hand, which the simulation has at `hand` (m), has arrived: in slow
    /// motion it lags behind, and what was drawn shall be done. Gives whether it has ended.
    pub fn finish(&mut self, dt: f64, hand: Option<Vec3>, radius: f64) -> bool {
        let Some(stroke) = &mut self.stroke else { return true };
        if let (Some(start), Some(end), None) = (stroke.start, stroke.end, stroke.sweep) {
            // One even motion in the plane through the viewer and the line: a hand that trembles leaves splinters.
            let duration = ((end.position - start.position).norm() / (SWEEP * radius)).max(SHORTEST_SWEEP);
            (stroke.sweep, self.place) = (Some(duration), Some(end));
            let buttons = stroke.buttons;
            self.glide(&end, buttons, duration);
            return false;
        }
        if let Some(left) = &mut stroke.sweep
            && *left > 0.0
        {
            *left -= dt;
            return false;
        }
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
        self.glide(&place, buttons, GLIDE);
    }

    /// Sends the hand, and the one that mirrors it, to a place within `duration` (s).
    fn glide(&mut self, place: &HandPlace, buttons: u32, duration: f64) {
        place.glide(&mut self.hand, &self.device_frame, buttons, duration);
        if let Some(plane) = &self.plane {
            plane.hand(place).glide(&mut self.mirror, &self.device_frame, buttons, duration);
        }
    }

    /// The line of a cut that is being drawn or made, from its start (m) to its end.
    pub fn line(&self) -> Option<[Vec3; 2]> {
        let stroke = self.stroke.as_ref()?;
        Some([stroke.start?.position, stroke.end?.position])
    }
}
