//! The hand of a device: where its workspace is in a view, and what its buttons do.
//!
//! The axes of the device (right, up, towards the user) are those of the picture, and the centre of its workspace is the point in the centre of the picture.
//! During a stroke the workspace stays in place while the view turns.

use crate::hand::HandPlace;
use nalgebra::UnitQuaternion;
use pliant_engine::session::Session;
use pliant_engine::tool::Frame;
use pliant_live::{DeviceScale, Guide, GuideHandle, GuidedDevice, HapticDevice, PointerDevice, Rescaling};
use pliant_solver::Vec3;

/// The viewpoint from which the user of a device sees the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceView {
    /// Point of the scene in the centre of the picture, m.
    pub centre: Vec3,
    /// Rotation from axes of the picture (right, up, towards the viewer) to those of the scene.
    pub rotation: UnitQuaternion<f64>,
}

/// Settings that a program passes to a device in each frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceWish {
    /// Viewpoint of its user.
    pub view: DeviceView,
    /// Buttons of the scene (bit i is button i) while no button of the device is pressed, while its first is, and while only another is.
    pub buttons: [u32; 3],
    /// Share of the force that the device can render, 0 to 1.
    pub force_share: f64,
}

/// A device that can move the hand of a session instead of the pointer.
pub struct DeviceHand {
    handle: GuideHandle,
    /// Last settings passed to the device, in axes of `frame`.
    guide: Guide,
    /// Frame of the device of the scene that it replaces.
    frame: Frame,
    /// Scales of lengths and forces.
    pub scale: DeviceScale,
    /// Name of the device, for messages.
    pub name: String,
    /// Largest force on the device at a share of 1, N.
    peak_force: f64,
    /// Index in [`DeviceWish::buttons`] of the stroke that is under way; 0 for none.
    pressed: usize,
}

/// What the device's user has done since the last call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HandNews {
    /// Nothing but motion.
    None,
    /// A stroke has begun, with the first button or with another.
    Began {
        /// Whether it is another than the first.
        is_other: bool,
    },
    /// The stroke has ended.
    Ended,
    /// The device is lost, and why; the pointer has the hand.
    Lost(&'static str),
}

/// Requirements of a tool (by index) of a session on a device, in axes of its frame: longest edge of the bodies (m), stiffness of the coupling (N/m) and peak
/// force (N).
fn asked_of_device(session: &Session, tool: usize) -> [f64; 3] {
    let slot = &session.tools[tool];
    let frame = session.devices[slot.device].frame;
    let bodies = session.bodies.iter().map(|body| &body.model);
    let models = bodies.chain(session.standing.iter().map(|(_, model)| model));
    let size = models.map(|model| model.surface.bounds().longest_edge()).fold(0.0, f64::max);
    [size / frame.scale, slot.tool.coupling.stiffness * frame.scale, slot.safety.limits().peak]
}

/// The hand of a device in the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DeviceHandState {
    /// Pose of the hand; `None` while the device gives no pose.
    pub place: Option<HandPlace>,
    /// Buttons of the scene that are pressed: bit i is button i.
    pub buttons: u32,
    /// Force the device was given last, in its own axes, N.
    pub force: Vec3,
    /// Largest force it may be given now, N.
    pub force_limit: f64,
}

impl DeviceHand {
    /// Puts a device called `name` beside the pointer of a tool (by index) of a session, at the scale at which the bodies fit into its workspace. Returns what
    /// the session gets for both, and the hand, which leads at once.
    pub fn give(
        device: Box<dyn HapticDevice>,
        pointer: PointerDevice,
        session: &Session,
        tool: usize,
        name: String,
    ) -> (GuidedDevice, Self) {
        let frame = session.devices[session.tools[tool].device].frame;
        let [size, coupling, peak] = asked_of_device(session, tool);
        let info = device.device_info();
        let scale = DeviceScale::fit(&info, size, coupling, peak);
        let peak_force = (scale.force * peak).min(info.peak_force);
        let (guided, handle) = GuidedDevice::new(device, pointer, scale);
        let guide = Guide { leads: true, ..Guide::default() };
        (guided, Self { handle, guide, frame, scale, name, peak_force, pressed: 0 })
    }

    /// Moves the device to a tool (by index) of another session; returns the scale for [`pliant_live::LiveSession::hand_over`], which must be called next. A
    /// stroke under way keeps its buttons until it ends.
    pub fn continue_in(&mut self, session: &Session, tool: usize) -> Rescaling {
        self.frame = session.devices[session.tools[tool].device].frame;
        let [size, coupling, peak] = asked_of_device(session, tool);
        let rescaling = self.handle.rescale(size, coupling, peak);
        self.scale = self.handle.scale();
        self.peak_force = (self.scale.force * peak).min(self.handle.device_info().peak_force);
        rescaling
    }

    /// Disables strokes by buttons of the device until the next [`DeviceHand::advance`], before it moves to another session.
    pub fn pause_strokes(&mut self) {
        self.guide.buttons = [self.guide.buttons[0]; 3];
        self.pressed = 0;
        self.handle.set(self.guide);
    }

    /// Displacement in the scene over displacement of the device, m/m.
    pub fn length_scale(&self) -> f64 {
        self.scale.length * self.frame.scale
    }

    /// Whether the device has the hand, and not the pointer.
    pub fn leads(&self) -> bool {
        self.guide.leads
    }

    /// Whether the device was lost: it has to be opened anew.
    pub fn is_lost(&mut self) -> bool {
        self.handle.hand().lost.is_some()
    }

    /// Gives the hand to the device, or to the pointer. The device takes it in the next frame, with the view of that frame.
    pub fn set_leads(&mut self, leads: bool) {
        self.guide.leads = leads;
        self.pressed = 0;
        if !leads {
            self.handle.set(self.guide);
        }
    }

    /// Whether a stroke is under way.
    pub fn is_busy(&self) -> bool {
        self.pressed > 0
    }

    /// The hand at the last tick of the device.
    pub fn state(&mut self) -> DeviceHandState {
        let hand = self.handle.hand();
        let place = hand.place.map(|(position, rotation)| HandPlace {
            position: self.frame.to_scene(position),
            rotation: self.frame.rotation * rotation,
        });
        let force_limit = self.guide.force_share * self.peak_force;
        DeviceHandState { place, buttons: hand.buttons, force: hand.force, force_limit }
    }

    /// Guides the device for a frame.
    pub fn advance(&mut self, wish: &DeviceWish) -> HandNews {
        let hand = self.handle.hand();
        if let Some(status) = hand.lost {
            self.set_leads(false);
            return HandNews::Lost(status.meaning());
        }
        // A button that does nothing in the scene begins no stroke.
        let pressed = if hand.buttons == 0 { 0 } else { hand.pressed };
        let before = std::mem::replace(&mut self.pressed, pressed);
        if pressed == 0 {
            self.guide.rotation = self.frame.rotation.inverse() * wish.view.rotation;
            self.guide.centre = self.frame.to_hand(wish.view.centre);
            self.guide.buttons = wish.buttons;
        }
        self.guide.force_share = wish.force_share;
        self.handle.set(self.guide);
        match (before, pressed) {
            (0, 0) => HandNews::None,
            (0, pressed) => HandNews::Began { is_other: pressed > 1 },
            (_, 0) => HandNews::Ended,
            _ => HandNews::None,
        }
    }
}
