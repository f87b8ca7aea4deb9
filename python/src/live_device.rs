//! Steps in real time with a haptic device that has one of the hands, on a haptic thread of its own.
//!
//! Forces pass the force safety of every live session. The device is closed before the session is given back: when it is asked to end, after a fault, and
//! when its Python object is gone.

use super::failure::{Failure, Kind};
use super::live::{Publisher, Shared, UsedPose, lock};
use pliant_editor::{DeviceHand, DeviceHandState, DeviceWish, HandNews, HandPlace};
use pliant_engine::session::{HandPose, Session, TouchingProxy};
use pliant_engine::tool::Frame;
use pliant_host::{Device, POSE_VALID, Pose};
use pliant_live::{HapticDevice, LiveSession, LiveSettings, PointerDevice, PointerHandle};
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;

/// s, in which a hand that Python sends somewhere gets there: a frame
const GLIDE: f64 = 1.0 / 60.0;

/// A device that shall have a hand.
pub struct Lead {
    /// Index of the tool.
    pub tool: usize,
    /// The device itself: opened for this hand, or taken from that of another session.
    pub device: LeadDevice,
    /// Plugin of the device.
    pub name: String,
    /// What is asked of it from the start.
    pub wish: DeviceWish,
}

/// Where a device that shall have a hand comes from.
pub enum LeadDevice {
    /// It was opened for it.
    Opened(Device),
    /// It had a hand of another session.
    Kept(Box<KeptDevice>),
}

/// A device that has had a hand of a session that is no longer played: its haptic thread goes on, and what it feels fades within 150 ms. Dropping it closes the
/// device.
pub struct KeptDevice {
    live: LiveSession,
    hand: DeviceHand,
    pointers: Vec<(PointerHandle, Frame)>,
    touching: Vec<TouchingProxy>,
    strokes: u64,
    /// Plugin of the device.
    pub name: String,
    /// What was asked of it last.
    pub wish: DeviceWish,
}

/// The hand that a device has.
#[derive(Clone, Debug)]
pub struct LedHand {
    /// Plugin of the device.
    pub device: String,
    /// Where it is, its buttons and its force.
    pub state: DeviceHandState,
    /// Displacement in the scene for one of the device.
    pub length_scale: f64,
    /// Strokes begun so far.
    pub strokes: u64,
    /// Whether one is under way.
    pub in_stroke: bool,
    /// Why the device was lost, if it was.
    pub lost: Option<String>,
}

/// Refuses tools that no device can have by itself, and scenes in which other tools share a device: its place is taken by a pointer with one pose, so
/// a hand that Python moves would take the other hands of that device along.
pub fn check_tool(session: &Session, tool: usize) -> Result<(), Failure> {
    let slot = &session.tools[tool];
    let refused = |what: String| {
        let text = format!("tool `{}` {what}; allowed is a tool whose hand is of a device of its own", slot.tool.name);
        Err(Failure::new(Kind::Argument, text))
    };
    if slot.mirror.is_some() {
        return refused("is the mirror of another".into());
    }
    let others = session.tools.iter().enumerate().filter(|(index, other)| *index != tool && other.mirror.is_none());
    match others.map(|(_, other)| other).find(|other| other.device == slot.device) {
        Some(other) => return refused(format!("shares its device with tool `{}`", other.tool.name)),
        None if slot.effector > 0 => return refused(format!("is on effector {} of its device", slot.effector)),
        None => {}
    }
    let mut known = BTreeMap::new();
    for other in session.tools.iter().filter(|other| other.mirror.is_none()) {
        if let Some(first) = known.insert(other.device, &other.tool.name) {
            let text = format!(
                "tools `{first}` and `{}` share a device, so their hands would move as one; allowed is a device for each tool while a haptic \
                 device has the hand of tool `{}`",
                other.tool.name, slot.tool.name
            );
            return Err(Failure::new(Kind::Argument, text));
        }
    }
    Ok(())
}

/// Steps in real time until it is asked to end. Gives the device if that is to be kept.
pub(super) fn play_with_device(
    session: &mut Session,
    lead: Lead,
    shared: &Shared,
) -> Result<Option<KeptDevice>, Failure> {
    let tools = session.tools.iter().enumerate().filter(|(_, slot)| slot.mirror.is_none()).map(|(index, _)| index);
    // From now on all hands are the device's or Python's.
    for tool in tools.collect::<Vec<_>>() {
        session.place_hand(tool, None);
    }
    let Lead { tool, device, name, wish } = lead;
    let Started { live, mut hand, pointers, strokes } = match device {
        LeadDevice::Opened(device) => Started::open(session, tool, device, &name, &wish)?,
        LeadDevice::Kept(kept) => Started::go_on(session, tool, *kept)?,
    };
    hand.advance(&wish);
    let led = LedHand {
        device: name,
        state: DeviceHandState::default(),
        length_scale: hand.length_scale(),
        strokes,
        in_stroke: false,
        lost: None,
    };
    let sent = BTreeMap::new();
    let done = DevicePlayer { session, shared, live, hand, led, pointers, sent }.play();
    // The hand goes back to Python, away from the bodies.
    session.place_hand(tool, None);
    done
}

/// A live session whose device has begun to have a hand.
struct Started {
    live: LiveSession,
    hand: DeviceHand,
    pointers: Vec<(PointerHandle, Frame)>,
    /// Strokes begun before.
    strokes: u64,
}

impl Started {
    /// With a device that was opened for it, and pointers in the place of all others.
    fn open(
        session: &mut Session,
        tool: usize,
        device: Device,
        name: &str,
        wish: &DeviceWish,
    ) -> Result<Self, Failure> {
        let of_device = session.tools[tool].device;
        let (mut devices, mut pointers) = (Vec::<Box<dyn HapticDevice>>::new(), Vec::new());
        let mut real = Some(device);
        let mut hand = None;
        for (index, slot) in session.devices.iter().enumerate() {
            let (pointer, handle) = PointerDevice::new(slot.facts);
            pointers.push((handle, slot.frame));
            devices.push(match real.take_if(|_| index == of_device) {
                None => Box::new(pointer),
                Some(real) => {
                    let given = DeviceHand::give(Box::new(real), pointer, session, tool, name.to_owned());
                    hand = Some(given.1);
                    Box::new(given.0)
                }
            });
        }
        let mut hand = hand.expect("a tool has a device");
        hand.advance(wish);
        let live = LiveSession::start_with_devices(session, devices, LiveSettings::default())
            .map_err(|error| Failure::new(Kind::File, format!("the system gives no thread: {error}")))?;
        Ok(Self { live, hand, pointers, strokes: 0 })
    }

    /// With the devices of another session.
    fn go_on(session: &mut Session, tool: usize, kept: KeptDevice) -> Result<Self, Failure> {
        let KeptDevice { live, mut hand, pointers, touching, strokes, name, .. } = kept;
        let of_device = session.tools[tool].device;
        let rescaling = hand.continue_in(session, tool);
        let rescalings: Vec<_> =
            (0..session.devices.len()).map(|device| (device == of_device).then_some(rescaling)).collect();
        let live = live.hand_over(session, &touching, &rescalings, None).map_err(|_| {
            let text = format!(
                "device `{name}` cannot go on in this session, and is closed: its haptic thread has ended, or the session has another number of devices or \
                 other frames of them; allowed is a session whose devices have the frames of the one before"
            );
            Failure::new(Kind::Argument, text)
        })?;
        Ok(Self { live, hand, pointers, strokes })
    }
}

/// Steps the session with its devices, on the thread of a [`super::live::LiveThread`], and guides the device that has a hand.
struct DevicePlayer<'a> {
    session: &'a mut Session,
    shared: &'a Shared,
    live: LiveSession,
    hand: DeviceHand,
    led: LedHand,
    /// Handle of the pointer in the place of each device, and the frame of the device, in the order of the session's devices. That of the device that
    /// has a hand moves the hand once the device is lost.
    pointers: Vec<(PointerHandle, Frame)>,
    /// Where hands were sent last, by tool.
    sent: BTreeMap<usize, Option<HandPose>>,
}

impl DevicePlayer<'_> {
    fn play(mut self) -> Result<Option<KeptDevice>, Failure> {
        let mut publisher = Publisher::new(self.shared);
        let mut is_alive = true;
        while is_alive && !self.shared.is_stopped() {
            self.send_hands();
            self.step();
            self.guide();
            is_alive = self.live.is_alive();
            if publisher.is_due() {
                let lost_time = self.live.gauges().lost_time;
                publisher.publish(self.session, lost_time, Some(self.led.clone()));
            }
        }
        let lost_time = self.live.gauges().lost_time;
        if is_alive && self.led.lost.is_none() && self.shared.keeps_device.load(Ordering::Relaxed) {
            self.hand.pause_strokes();
            publisher.publish(self.session, lost_time, Some(self.led.clone()));
            let wish = (*lock(&self.shared.wish)).expect("it was there when the device began to have the hand");
            let Self { session, live, hand, led, pointers, .. } = self;
            let (touching, strokes, name) = (session.touching_proxies(), led.strokes, led.device);
            return Ok(Some(KeptDevice { live, hand, pointers, touching, strokes, name, wish }));
        }
        // The device is closed before anybody hears of the end.
        let panicked = self.live.finish().panicked;
        publisher.publish(self.session, lost_time, Some(self.led));
        if panicked || !is_alive {
            return Err(Failure::new(Kind::Panic, "the haptic thread ended with a fault; the device is closed"));
        }
        Ok(None)
    }

    /// Sends hands that Python moves where they are to go.
    fn send_hands(&mut self) {
        let targets = lock(&self.shared.targets).clone();
        for (tool, target) in targets {
            if self.sent.insert(tool, target) == Some(target) {
                continue;
            }
            let (pointer, frame) = &mut self.pointers[self.session.tools[tool].device];
            match target {
                None => pointer.remove(),
                Some(HandPose { position, rotation, buttons }) => {
                    HandPlace { position, rotation }.glide(pointer, frame, buttons, GLIDE);
                }
            }
        }
    }

    /// Takes a step when it is due, and keeps the poses that it used.
    fn step(&mut self) {
        let samples = self.live.step(self.session);
        let time = self.session.time();
        let mut used = lock(&self.shared.used);
        for (tool, slot) in self.session.tools.iter().enumerate().filter(|(_, slot)| slot.mirror.is_none()) {
            let pose = samples.poses.get(slot.device).and_then(|poses| poses.get(slot.effector));
            let frame = &self.session.devices[slot.device].frame;
            if let Some(pose) = pose.and_then(|pose| pose_in_scene(pose, frame)) {
                used.push(UsedPose { time, tool, pose });
            }
        }
    }

    /// Guides the device, and hears what its user has done.
    fn guide(&mut self) {
        let Some(wish) = *lock(&self.shared.wish) else { return };
        if self.led.lost.is_some() {
            return;
        }
        match self.hand.advance(&wish) {
            HandNews::Began { .. } => self.led.strokes += 1,
            HandNews::Lost(why) => {
                self.led.lost = Some(format!("device `{}` is lost: {why}", self.led.device));
                self.led.state = DeviceHandState::default();
                self.led.in_stroke = false;
                return;
            }
            HandNews::None | HandNews::Ended => {}
        }
        self.led.state = self.hand.state();
        self.led.in_stroke = self.hand.is_busy();
    }
}

/// A valid pose of a device, in the scene.
fn pose_in_scene(pose: &Pose, frame: &Frame) -> Option<HandPose> {
    let is_valid = pose.flags & POSE_VALID != 0 && pose.position.iter().all(|c| c.is_finite());
    is_valid.then(|| HandPose {
        position: frame.to_scene(pose.position.into()),
        rotation: frame.rotation_in_scene(pose.orientation),
        buttons: pose.buttons,
    })
}
