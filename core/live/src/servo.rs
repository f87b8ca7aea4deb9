//! The servo: each tick reads the devices, renders the newest contact models and writes the forces.
//!
//! *Real time*: a tick does not allocate, lock, log or do I/O of its own, and does not loop over a mesh.

use crate::device::{HapticDevice, StopDevice};
use crate::histogram::Histogram;
use crate::servo_torque::ServoTorque;
use crate::snapshots::{ContactModels, DeviceLoss, HandSamples, SimulationPort};
use pliant_engine::session::{DeviceSlot, Session, ToolSlot};
use pliant_engine::tool::{Blend, ForceLimits, ForceSafety, Frame, Hand, HandState, Passivity, STALE_AFTER};
use pliant_host::{DeviceInfo, EffectorOutput, MAX_EFFECTORS, Pose};
use pliant_plugin_api::abi::Status;
use pliant_solver::Vec3;
use triple_buffer::triple_buffer;

/// Time after which a device without a new command goes to zero force, ns.
const FORCE_VALID: u64 = 50_000_000;
/// Highest rate of the haptic loop, Hz.
const MAX_RATE: f64 = 4000.0;
/// Rate of the haptic loop if no device declares one, Hz.
const DEFAULT_RATE: f64 = 1000.0;

/// The devices and tools of a session on the haptic thread. The caller passes the time, so tests can run it in simulated time;
/// [`LiveSession`](crate::LiveSession) runs it in wall-clock time.
pub struct Servo {
    devices: Vec<ServoDevice>,
    /// Tools in the order of the session's.
    pub(crate) tools: Vec<ServoTool>,
    models: triple_buffer::Output<ContactModels>,
    samples: triple_buffer::Input<HandSamples>,
    rate: f64,
    /// Number of the next tick.
    tick: u64,
    /// Time of the last tick, ns.
    last_tick: Option<u64>,
    /// Ages of the rendered contact models: time since their hand samples.
    pub(crate) contact_age: Histogram,
}

/// A device on the haptic thread.
struct ServoDevice {
    device: Box<dyn HapticDevice>,
    frame: Frame,
    poses: Vec<Pose>,
    /// The device is served every n-th tick, n = haptic rate / its rate.
    divider: u64,
    loss: Option<DeviceLoss>,
}

/// A tool on the haptic thread.
pub(crate) struct ServoTool {
    pub(crate) name: String,
    /// Index of its device.
    device: usize,
    /// Index of the effector on the device.
    effector: usize,
    pub(crate) hand: Hand,
    blend: Blend,
    pub(crate) safety: ForceSafety,
    /// Last rendered force, in axes of the device, N.
    device_force: Vec3,
    torque: ServoTorque,
    /// Whether it is a mirrored tool, which renders nothing.
    mirrored: bool,
    /// Forces of the pins of its tactile array, N (rows x columns).
    taxels: Vec<f64>,
}

impl Servo {
    /// The servo of a session with `devices`, in the order of the session's devices, and the simulation's end of the buffers between both. `rate` is that
    /// of the haptic loop, Hz; by default that of the fastest device, up to 4 kHz.
    ///
    /// # Panics
    /// If the number of `devices` differs from that of the session.
    pub fn new(session: &Session, devices: Vec<Box<dyn HapticDevice>>, rate: Option<f64>) -> (Self, SimulationPort) {
        assert_eq!(devices.len(), session.devices.len(), "one for each of the session");
        let fastest = devices.iter().map(|device| device.device_info().rate).fold(0.0, f64::max);
        let rate = rate.unwrap_or(if fastest > 0.0 { fastest } else { DEFAULT_RATE }).clamp(1.0, MAX_RATE);
        let slots = devices.into_iter().zip(&session.devices);
        let devices: Vec<ServoDevice> = slots.map(|(device, slot)| ServoDevice::new(device, slot, rate)).collect();
        let tools = session.tools.iter().map(|slot| ServoTool::new(slot, devices[slot.device].device.device_info()));
        let tools: Vec<ServoTool> = tools.collect();
        let (models, models_out) = triple_buffer(&ContactModels {
            contacts: vec![Default::default(); tools.len()],
            torques: vec![Vec3::zeros(); tools.len()],
            taxels: tools.iter().map(|tool| tool.taxels.clone()).collect(),
        });
        let (samples, samples_out) = triple_buffer(&HandSamples {
            time: 0,
            poses: devices.iter().map(|device| device.poses.clone()).collect(),
            device_forces: vec![Vec3::zeros(); tools.len()],
            losses: vec![None; devices.len()],
        });
        let contact_age = Histogram::default();
        let servo = Self { devices, tools, models: models_out, samples, rate, tick: 0, last_tick: None, contact_age };
        (servo, SimulationPort::new(samples_out, models))
    }

    /// Rate of the haptic loop, Hz.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Last force rendered to each tool's effector, in axes of its device, N.
    pub fn device_forces(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.tools.iter().map(|tool| tool.device_force)
    }

    /// Force safety of each tool.
    pub fn safety(&mut self) -> impl Iterator<Item = &mut ForceSafety> {
        self.tools.iter_mut().map(|tool| &mut tool.safety)
    }

    /// The emergency stop of each device.
    pub fn stop_handles(&self) -> Vec<StopDevice> {
        self.devices.iter().map(|device| device.device.stop_handle()).collect()
    }

    /// Index of each lost device with a description of the cause. Not for the haptic thread.
    pub fn losses(&self) -> impl Iterator<Item = (usize, String)> {
        self.devices.iter().enumerate().filter_map(|(i, device)| {
            let DeviceLoss { call, status } = device.loss?;
            Some((i, device.device.describe_status(call, status)))
        })
    }

    /// Counters of each device since it was opened, including lost devices. Not for the haptic thread.
    pub fn counters(&self) -> impl Iterator<Item = Vec<(String, u64)>> {
        self.devices.iter().map(|device| device.device.counters())
    }

    /// Reads the newest contact models, serves every device that is due at `now` (ns), and publishes the poses.
    pub fn tick(&mut self, now: u64) {
        let gap = self.last_tick.replace(now).map_or(0, |last| now.saturating_sub(last));
        if gap as f64 * 1e-9 > STALE_AFTER {
            // The forces have expired, so the devices have gone to zero force by themselves.
            self.tools.iter_mut().for_each(|tool| {
                tool.safety.release();
                tool.torque.release();
            });
        }
        if self.models.update() {
            let models = self.models.output_buffer_mut();
            let contacts = models.contacts.iter().zip(&models.torques);
            for ((tool, (contact, torque)), taxels) in self.tools.iter_mut().zip(contacts).zip(&models.taxels) {
                tool.blend.take(*contact, now);
                tool.torque.simulated = *torque;
                tool.taxels.copy_from_slice(taxels);
            }
        }
        for index in 0..self.devices.len() {
            let device = &self.devices[index];
            if device.loss.is_none() && self.tick.is_multiple_of(device.divider) {
                self.serve(index, now);
            }
        }
        self.tick += 1;
        let samples = self.samples.input_buffer_mut();
        samples.time = now;
        for (index, device) in self.devices.iter().enumerate() {
            samples.poses[index].copy_from_slice(&device.poses);
            samples.losses[index] = device.loss;
        }
        for (force, tool) in samples.device_forces.iter_mut().zip(&self.tools) {
            *force = tool.device_force;
        }
        self.samples.publish();
    }

    /// Reads the device `index` at `now` (ns), renders the tools on it and writes to it.
    fn serve(&mut self, index: usize, now: u64) {
        let device = &mut self.devices[index];
        device.poses.fill(Pose::default());
        let status = device.device.read(now, &mut device.poses);
        if status != Status::OK {
            return self.lose(index, "read", status);
        }
        let dt = device.divider as f64 / self.rate;
        let mut outputs =
            [EffectorOutput { valid_until: now + FORCE_VALID, ..EffectorOutput::default() }; MAX_EFFECTORS];
        for tool in self.tools.iter_mut().filter(|tool| tool.device == index && !tool.mirrored) {
            let Some(pose) = device.poses.get(tool.effector) else { continue };
            // A device that holds its last pose for a while does not make the hand stay longer.
            let age = if pose.time_ns == 0 { 0 } else { now.saturating_sub(pose.time_ns) };
            tool.hand.sample_of_age(pose, &device.frame, age as f64 * 1e-9, now as f64 * 1e-9, dt);
            tool.device_force = tool.render(&device.frame, now, dt, &mut self.contact_age);
            if !tool.hand.present || tool.blend.age(now) > STALE_AFTER {
                tool.taxels.fill(0.0);
            }
            let age = tool.blend.age(now);
            outputs[tool.effector].torque = tool.torque.render(&tool.hand, &device.frame, age, dt).into();
            (outputs[tool.effector].force, outputs[tool.effector].taxels) = (tool.device_force.into(), &tool.taxels);
        }
        let status = device.device.write(now, &outputs[..device.poses.len()]);
        if status != Status::OK {
            self.lose(index, "write", status);
        }
    }

    /// Marks the device `index` as lost: its poses become invalid and it gets no forces.
    fn lose(&mut self, index: usize, call: &'static str, status: Status) {
        let device = &mut self.devices[index];
        device.loss = Some(DeviceLoss { call, status });
        device.poses.fill(Pose::default());
        for tool in self.tools.iter_mut().filter(|tool| tool.device == index) {
            tool.safety.release();
            tool.torque.release();
            tool.device_force = Vec3::zeros();
        }
    }

    /// Sets all devices to zero force.
    pub fn stop(&mut self) {
        self.stop_handles().iter().for_each(|stop| stop());
    }
}

impl Drop for Servo {
    fn drop(&mut self) {
        self.stop();
    }
}

impl ServoDevice {
    /// A device with the frame of its slot, in a loop at `rate` (Hz).
    fn new(device: Box<dyn HapticDevice>, slot: &DeviceSlot, rate: f64) -> Self {
        let info = device.device_info();
        Self {
            poses: vec![Pose::default(); (info.effectors as usize).min(MAX_EFFECTORS)],
            divider: (rate / info.rate).round().max(1.0) as u64,
            frame: slot.frame,
            device,
            loss: None,
        }
    }
}

impl ServoTool {
    /// A tool of the session on a device with these properties.
    fn new(slot: &ToolSlot, device: DeviceInfo) -> Self {
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
            safety: ForceSafety::new(limits).with_passivity(passivity),
            device_force: Vec3::zeros(),
            torque: ServoTorque::new(slot, &device),
            mirrored: slot.mirror.is_some(),
            taxels: slot.pad.as_ref().map_or_else(Vec::new, |pad| pad.taxels.clone()),
        }
    }

    /// Force on the hand at `now` (ns), `dt` (s) after the last one, in axes of the device, N. Adds the age of its contact model to `ages`.
    fn render(&mut self, frame: &Frame, now: u64, dt: f64, ages: &mut Histogram) -> Vec3 {
        if !self.hand.present {
            self.safety.release();
            return Vec3::zeros();
        }
        let in_scene = self.blend.force(self.hand.position, now);
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
