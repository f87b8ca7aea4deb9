//! The hand of the session, moved by the pointer.

use pliant_editor::{
    DeviceHand, DeviceWish, Gesture, HandNews, HandPlace, PointerRay, PointerStroke, StrokeStart, SurfacePoint,
};
use pliant_engine::tool::Frame as DeviceFrame;
use pliant_live::PointerHandle;
use pliant_solver::Vec3;

/// The hand of the session, which the pointer or a device moves.
pub struct HandControl {
    hand: PointerHandle,
    device_frame: DeviceFrame,
    stroke: Option<Stroke>,
    /// Last pose to which the hand was sent.
    place: Option<HandPlace>,
    /// A device that can have the hand in the place of the pointer.
    device_hand: Option<DeviceHand>,
}

/// A stroke under way.
struct Stroke {
    path: PointerStroke,
    /// Mask of the button that is held.
    buttons: u32,
    /// Whether it ends although its button may still be down.
    has_let_go: bool,
    /// Time since it began, s.
    time: f64,
    /// Time until the button is pressed, s.
    arrival: f64,
    /// Time since the stroke was let go while the hand was still on its way, or since the hand last came nearer to its target, s.
    finishing: f64,
    /// Smallest distance of the hand from its target since the stroke was let go, m.
    least_lag: f64,
    /// Remaining time of the blade along the drawn line of a cut that was let go, s.
    sweep: Option<f64>,
    /// Start of the drawn line of a cut, where the blade waits.
    start: Option<HandPlace>,
    /// End of the drawn line of a cut.
    end: Option<HandPlace>,
}

/// Time in which the hand moves from one pose to the next, s: a frame.
const GLIDE: f64 = 1.0 / 60.0;
/// Time until the button is pressed, so that the hand first reaches its place, s: for a hand that hovered near it, and for one farther away.
const ARRIVAL: [f64; 2] = [0.008, 0.03];
/// Radii of the tool within which a hand is near.
const NEAR: f64 = 4.0;
/// Longest time for which the hand may stand still on its way after a stroke was let go, s. A hand that moves may take any time, as in slow motion.
const LONGEST_FINISH: f64 = 5.0;
/// Radii of the tool by which a hand has moved on.
const MOVED_ON: f64 = 0.05;
/// Radii of the tool at which a hand has arrived.
const ARRIVED: f64 = 0.2;
/// Speed of a blade along a drawn line, radii of the tool for a second: a new tool crosses a model in a second.
const SWEEP: f64 = 25.0;
/// Shortest time of a cut along a drawn line, s.
const SHORTEST_SWEEP: f64 = 0.3;
/// Radii of the tool between it and the surface while nothing is pressed.
const HOVER: f64 = 0.6;

impl HandControl {
    /// The hand of a session whose device stands at `device_frame`.
    pub fn new(hand: PointerHandle, device_hand: Option<DeviceHand>, device_frame: DeviceFrame) -> Self {
        Self { hand, device_frame, stroke: None, place: None, device_hand }
    }

    /// The hand of the pointer, and the device that can have it.
    pub fn into_hand(mut self) -> (PointerHandle, Option<DeviceHand>) {
        self.end();
        (self.hand, self.device_hand)
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
        if let Some(device_hand) = &mut self.device_hand {
            device_hand.set_leads(leads);
        }
    }

    /// Guides the device for a frame; as for [`DeviceHand::advance`].
    pub fn guide_device(&mut self, wish: &DeviceWish) -> HandNews {
        self.device_hand.as_mut().map_or(HandNews::None, |device_hand| device_hand.advance(wish))
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
        let Some(mut path) = PointerStroke::begin(start) else { return false };
        let way = self.place.map_or(f64::INFINITY, |place| (path.advance(0.0).position - place.position).norm());
        let arrival = ARRIVAL[usize::from(way > NEAR * start.radius)];
        self.stroke = Some(Stroke {
            path,
            buttons,
            has_let_go: false,
            time: 0.0,
            arrival,
            finishing: 0.0,
            least_lag: f64::INFINITY,
            sweep: None,
            start: None,
            end: None,
        });
        self.advance(0.0);
        true
    }

    /// The stroke under way.
    pub fn stroke(&mut self) -> Option<&mut PointerStroke> {
        self.stroke.as_mut().map(|stroke| &mut stroke.path)
    }

    /// How the pointer moves the hand in the stroke under way.
    pub fn gesture(&self) -> Option<Gesture> {
        self.stroke.as_ref().map(|stroke| stroke.path.gesture())
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
        let (arrived, left) = (stroke.time >= stroke.arrival, stroke.arrival - stroke.time);
        // A press that waits for the hand does not go in yet.
        let place = stroke.path.advance(if arrived { dt } else { 0.0 });
        if stroke.path.gesture() == Gesture::Slice {
            // The line is drawn first; the blade waits at its start.
            let start = *stroke.start.get_or_insert(place);
            stroke.end = Some(place);
            self.send(start, 0);
            return;
        }
        let buttons = stroke.buttons;
        if arrived {
            self.send(place, buttons);
        } else {
            self.place = Some(place);
            place.glide_then_press(&mut self.hand, &self.device_frame, buttons, left);
        }
    }

    /// Lets go of the stroke under way, although its button may still be down.
    pub fn let_go(&mut self) {
        self.stroke.iter_mut().for_each(|stroke| stroke.has_let_go = true);
    }

    /// Whether the stroke under way was let go by [`Self::let_go`].
    pub fn has_let_go(&self) -> bool {
        self.stroke.as_ref().is_some_and(|stroke| stroke.has_let_go)
    }

    /// The stroke was let go `dt` (s) after the last call. It ends once the hand, which the simulation has at `hand` (m), has arrived: in slow
    /// motion it lags behind, and what was drawn shall be done. Gives whether it has ended.
    pub fn finish(&mut self, dt: f64, hand: Option<Vec3>, radius: f64) -> bool {
        let Some(stroke) = &mut self.stroke else { return true };
        if let (Some(start), Some(end), None) = (stroke.start, stroke.end, stroke.sweep) {
            // One even motion in the plane through the viewer and the line: a hand that trembles leaves splinters.
            let end = end.turned_from(&start);
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
        let lag = hand.zip(self.place).map_or(0.0, |(hand, place)| (hand - place.position).norm());
        if lag < stroke.least_lag - MOVED_ON * radius {
            (stroke.least_lag, stroke.finishing) = (lag, 0.0);
        }
        stroke.finishing += dt;
        let is_late = stroke.finishing > LONGEST_FINISH;
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

    /// Sends the hand to a place within `duration` (s).
    fn glide(&mut self, place: &HandPlace, buttons: u32, duration: f64) {
        place.glide(&mut self.hand, &self.device_frame, buttons, duration);
    }

    /// The line of a cut that is being drawn or made, from its start (m) to its end.
    pub fn line(&self) -> Option<[Vec3; 2]> {
        let stroke = self.stroke.as_ref()?;
        Some([stroke.start?.position, stroke.end?.position])
    }
}
