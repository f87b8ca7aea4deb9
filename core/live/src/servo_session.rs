//! The haptic thread's part of a session: its tools, the frames of its devices, and the buffers to the simulation. It can be replaced by that of another session.
//!
//! *Real time*: as the servo; it is made and dropped on the thread of the simulation.

use crate::guided::Rescaling;
use crate::histogram::Histogram;
use crate::servo_torque::ServoTorque;
use crate::snapshots::{ContactModels, DeviceLoss, HandSamples, SimulationPort};
use pliant_engine::session::{Session, ToolSlot};
use pliant_engine::tool::{Blend, ForceLimits, ForceSafety, Frame, Hand, HandState, Passivity};
use pliant_host::{DeviceInfo, MAX_EFFECTORS, Pose};
use pliant_solver::Vec3;
use triple_buffer::triple_buffer;

/// Tools and buffers of one session on the haptic thread.
pub(crate) struct ServoSession {
    /// Tools in the order of the session's.
    pub(crate) tools: Vec<ServoTool>,
    /// Frame of each device.
    pub(crate) frames: Vec<Frame>,
    /// New scale of each device, applied when this session takes it over; `None` if its scale stays.
    pub(crate) rescalings: Vec<Option<Rescaling>>,
    models: triple_buffer::Output<ContactModels>,
    samples: triple_buffer::Input<HandSamples>,
}

/// A tool on the haptic thread.
pub(crate) struct ServoTool {
    pub(crate) name: String,
    /// Index of its device.
    pub(crate) device: usize,
    /// Index of the effector on the device.
    pub(crate) effector: usize,
    pub(crate) hand: Hand,
    pub(crate) blend: Blend,
    /// The last contact with the session before, until the contact with this session has settled.
    leaving: Option<Leaving>,
    pub(crate) safety: ForceSafety,
    /// Last rendered force, in axes of the device, N.
    pub(crate) device_force: Vec3,
    pub(crate) torque: ServoTorque,
    /// Whether it is a mirrored tool, which renders nothing.
    pub(crate) mirrored: bool,
    /// Forces of the pins of its tactile array, N (rows x columns).
    pub(crate) taxels: Vec<f64>,
}

/// The contact of a tool with the session that had its device before.
struct Leaving {
    blend: Blend,
    /// Arrival of the first contact of this session, ns; `None` before it.
    since: Option<u64>,
}

/// Time over which the force changes from the contact with one session to that with the next, s: a body that is not yet dented rings when a tool is pressed into it
/// at once.
const SETTLE_TIME: f64 = 0.1;

impl ServoSession {
    /// The haptic thread's part of a session with these devices, in their order, and the port of the simulation to the shared buffers.
    pub(crate) fn new(session: &Session, devices: &[DeviceInfo]) -> (Self, SimulationPort) {
        let tools = session.tools.iter().map(|slot| ServoTool::new(slot, &devices[slot.device]));
        let tools: Vec<ServoTool> = tools.collect();
        let (models, models_out) = triple_buffer(&ContactModels {
            contacts: vec![Default::default(); tools.len()],
            torques: vec![Vec3::zeros(); tools.len()],
            taxels: tools.iter().map(|tool| tool.taxels.clone()).collect(),
        });
        let poses = |device: &DeviceInfo| vec![Pose::default(); (device.effectors as usize).min(MAX_EFFECTORS)];
        let (samples, samples_out) = triple_buffer(&HandSamples {
            time: 0,
            poses: devices.iter().map(poses).collect(),
            device_forces: vec![Vec3::zeros(); tools.len()],
            losses: vec![None; devices.len()],
        });
        let frames = session.devices.iter().map(|slot| slot.frame).collect();
        let rescalings = vec![None; devices.len()];
        let servo = Self { tools, frames, rescalings, models: models_out, samples };
        (servo, SimulationPort::new(samples_out, models))
    }

    /// As [`ServoSession::new`], for a session that takes over the devices of another one. Each device has a rescaling, or `None` if its scale stays.
    ///
    /// # Panics
    /// If the number of devices differs from that of the session.
    pub(crate) fn rescaled(
        session: &Session,
        devices: &[DeviceInfo],
        rescalings: &[Option<Rescaling>],
    ) -> (Self, SimulationPort) {
        assert_eq!(devices.len(), session.devices.len(), "one for each of the session");
        let each = devices.iter().enumerate();
        let scaled = |(index, info): (usize, &DeviceInfo)| {
            rescalings.get(index).copied().flatten().map_or(*info, |rescaling| rescaling.info)
        };
        let (mut servo, port) = Self::new(session, &each.map(scaled).collect::<Vec<_>>());
        servo.rescalings.iter_mut().zip(rescalings).for_each(|(to, rescaling)| *to = *rescaling);
        (servo, port)
    }

    /// Takes over the states of tools of the session before that have the same name, device and effector.
    pub(crate) fn resume(&mut self, before: &Self) {
        for tool in &mut self.tools {
            let same =
                |old: &&ServoTool| (&old.name, old.device, old.effector) == (&tool.name, tool.device, tool.effector);
            if let Some(old) = before.tools.iter().find(same) {
                tool.resume(old, self.rescalings[tool.device].as_ref());
            }
        }
    }

    /// Takes the newest contact models in at `now` (ns), if there are new ones.
    pub(crate) fn take_models(&mut self, now: u64) {
        if !self.models.update() {
            return;
        }
        let models = self.models.output_buffer_mut();
        let contacts = models.contacts.iter().zip(&models.torques);
        for ((tool, (contact, torque)), taxels) in self.tools.iter_mut().zip(contacts).zip(&models.taxels) {
            if let Some(Leaving { since: since @ None, .. }) = &mut tool.leaving {
                (*since, tool.blend) = (Some(now), Blend::default());
            }
            tool.blend.take(*contact, now);
            tool.torque.simulated = *torque;
            tool.taxels.copy_from_slice(taxels);
        }
    }

    /// Publishes poses and cause of loss of each device, and the forces on the tools, at `now` (ns).
    pub(crate) fn publish<'a>(&mut self, now: u64, devices: impl Iterator<Item = (&'a [Pose], Option<DeviceLoss>)>) {
        let samples = self.samples.input_buffer_mut();
        samples.time = now;
        for (index, (poses, loss)) in devices.enumerate() {
            samples.poses[index].copy_from_slice(poses);
            samples.losses[index] = loss;
        }
        for (force, tool) in samples.device_forces.iter_mut().zip(&self.tools) {
            *force = tool.device_force;
        }
        self.samples.publish();
    }
}

impl ServoTool {
    /// A tool of the session on a device with these properties.
    fn new(slot: &ToolSlot, device: &DeviceInfo) -> Self {
        let limits = ForceLimits { continuous: device.continuous_force, ..slot.safety.limits() };
        // Bound of the energy balance, J: twice the energy the coupling stores at the peak force.
        let stored = limits.peak * limits.peak / slot.tool.coupling.stiffness;
        let passivity = Passivity::new(device.damping, device.resolution, stored);
        Self {
            name: slot.tool.name.clone(),
            device: slot.device,
            effector: slot.effector,
            hand: Hand::new(slot.hand.fastest),
            blend: Blend::default(),
            leaving: None,
            safety: ForceSafety::new(limits).with_passivity(passivity),
            device_force: Vec3::zeros(),
            torque: ServoTorque::new(slot, device),
            mirrored: slot.mirror.is_some(),
            taxels: slot.pad.as_ref().map_or_else(Vec::new, |pad| pad.taxels.clone()),
        }
    }

    /// Takes over the state of the tool that had the effector before: its hand, and its last contact, which is rendered until a step of this session has
    /// found its own.
    fn resume(&mut self, before: &Self, rescaling: Option<&Rescaling>) {
        let [force, torque] = rescaling.map_or([1.0; 2], Rescaling::factors);
        let fastest = self.hand.fastest;
        self.hand = before.hand.clone();
        self.hand.fastest = fastest;
        self.device_force = force * before.device_force;
        // At another scale of lengths the hand is elsewhere, so the old contact says nothing.
        if rescaling.is_none_or(Rescaling::keeps_lengths) {
            (self.blend, self.leaving) = (before.blend, Some(Leaving { blend: before.blend, since: None }));
        }
        self.safety.resume(&before.safety, force);
        self.torque.resume(&before.torque, torque);
    }

    /// Force of the contact at `now` (ns), in axes of the scene, N.
    fn contact_force(&mut self, now: u64) -> Vec3 {
        let force = self.blend.force(self.hand.position, now);
        let Some(Leaving { blend, since: Some(since) }) = &self.leaving else { return force };
        let share = now.saturating_sub(*since) as f64 * 1e-9 / SETTLE_TIME;
        if share >= 1.0 {
            self.leaving = None;
            return force;
        }
        blend.force(self.hand.position, now).lerp(&force, share)
    }

    /// Force on the hand at `now` (ns), `dt` (s) after the last one, in axes of the device, N. Adds the age of its contact model to `ages`.
    pub(crate) fn render(&mut self, frame: &Frame, now: u64, dt: f64, ages: &mut Histogram) -> Vec3 {
        if !self.hand.present {
            self.safety.release();
            return Vec3::zeros();
        }
        let in_scene = self.contact_force(now);
        let force = frame.to_device(in_scene);
        // A displacement of the hand is scaled to the scene, so compliances are scaled back.
        let compliance = self.blend.compliance(in_scene) / frame.scale;
        let mut age = 0.0;
        if self.blend.is_contact() {
            age = self.blend.age(now);
            ages.add((age * 1e9) as u64);
        }
        let place = self.hand.position - frame.origin;
        let position = frame.to_device(place) / frame.scale;
        self.safety.pass_live(force, HandState { position, age, compliance }, dt)
    }
}
