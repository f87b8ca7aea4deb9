//! The servo: each tick reads the devices, renders the newest contact models and writes the forces.
//!
//! *Real time*: a tick does not allocate, lock, log or do I/O of its own, and does not loop over a mesh.

use crate::device::{HapticDevice, StopDevice};
use crate::guided::Rescaling;
use crate::handover::Handover;
use crate::histogram::Histogram;
use crate::servo_session::ServoSession;
use crate::snapshots::{DeviceLoss, SimulationPort};
use pliant_engine::session::Session;
use pliant_engine::tool::{ForceSafety, STALE_AFTER};
use pliant_host::{DeviceInfo, EffectorOutput, MAX_EFFECTORS, Pose};
use pliant_plugin_api::abi::Status;
use pliant_solver::Vec3;
use std::sync::Arc;

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
    /// What it has of the session.
    pub(crate) session: Box<ServoSession>,
    /// Where another session waits to have the devices.
    pub(crate) handover: Arc<Handover>,
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
    poses: Vec<Pose>,
    /// The device is served every n-th tick, n = haptic rate / its rate.
    divider: u64,
    loss: Option<DeviceLoss>,
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
        let infos: Vec<DeviceInfo> = devices.iter().map(|device| device.device_info()).collect();
        let devices: Vec<ServoDevice> = devices.into_iter().map(|device| ServoDevice::new(device, rate)).collect();
        let (session, port) = ServoSession::new(session, &infos);
        let (session, handover, contact_age) = (Box::new(session), Arc::default(), Histogram::default());
        (Self { devices, session, handover, rate, tick: 0, last_tick: None, contact_age }, port)
    }

    /// Gives the devices to another session, in the order of its own: forces go on from the last ones within their limits. Returns the simulation's end of the
    /// buffers. A [`crate::LiveSession`] does so by [`crate::LiveSession::hand_over`].
    ///
    /// # Panics
    /// If the number of devices differs from that of the session.
    pub fn hand_over(&mut self, next: &Session, scales: &[Option<Rescaling>]) -> SimulationPort {
        let infos: Vec<DeviceInfo> = self.devices.iter().map(|device| device.device.device_info()).collect();
        let (session, port) = ServoSession::rescaled(next, &infos, scales);
        self.take_over(&mut Box::new(session));
        port
    }

    /// Goes on with another session; what it had of the last one is left in `next`.
    fn take_over(&mut self, next: &mut Box<ServoSession>) {
        next.resume(&self.session);
        for (device, rescaling) in self.devices.iter_mut().zip(&next.rescalings) {
            if let Some(rescaling) = rescaling {
                device.device.rescale(rescaling);
            }
        }
        std::mem::swap(&mut self.session, next);
    }

    /// Rate of the haptic loop, Hz.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Last force rendered to each tool's effector, in axes of its device, N.
    pub fn device_forces(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.session.tools.iter().map(|tool| tool.device_force)
    }

    /// Force safety of each tool.
    pub fn safety(&mut self) -> impl Iterator<Item = &mut ForceSafety> {
        self.session.tools.iter_mut().map(|tool| &mut tool.safety)
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

    /// Whether any device needs exact ticks.
    pub(crate) fn needs_exact_ticks(&self) -> bool {
        self.devices.iter().any(|device| device.device.needs_exact_ticks())
    }

    /// Counters of each device since it was opened, including lost devices. Not for the haptic thread.
    pub fn counters(&self) -> impl Iterator<Item = Vec<(String, u64)>> {
        self.devices.iter().map(|device| device.device.counters())
    }

    /// Reads the newest contact models, serves every device that is due at `now` (ns), and publishes the poses.
    pub fn tick(&mut self, now: u64) {
        let handover = Arc::clone(&self.handover);
        handover.take(|next| self.take_over(next));
        let gap = self.last_tick.replace(now).map_or(0, |last| now.saturating_sub(last));
        if gap as f64 * 1e-9 > STALE_AFTER {
            // The forces have expired, so the devices have gone to zero force by themselves.
            self.session.tools.iter_mut().for_each(|tool| {
                tool.safety.release();
                tool.torque.release();
            });
        }
        self.session.take_models(now);
        for index in 0..self.devices.len() {
            let device = &self.devices[index];
            if device.loss.is_none() && self.tick.is_multiple_of(device.divider) {
                self.serve(index, now);
            }
        }
        self.tick += 1;
        let devices = self.devices.iter().map(|device| (&device.poses[..], device.loss));
        self.session.publish(now, devices);
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
        let ServoSession { tools, frames, .. } = &mut *self.session;
        let frame = &frames[index];
        for tool in tools.iter_mut().filter(|tool| tool.device == index && !tool.mirrored) {
            let Some(pose) = device.poses.get(tool.effector) else { continue };
            // A device that holds its last pose for a while does not make the hand stay longer.
            let age = if pose.time_ns == 0 { 0 } else { now.saturating_sub(pose.time_ns) };
            tool.hand.sample_of_age(pose, frame, age as f64 * 1e-9, now as f64 * 1e-9, dt);
            tool.device_force = tool.render(frame, now, dt, &mut self.contact_age);
            if !tool.hand.present || tool.blend.age(now) > STALE_AFTER {
                tool.taxels.fill(0.0);
            }
            let age = tool.blend.age(now);
            outputs[tool.effector].torque = tool.torque.render(&tool.hand, frame, age, dt).into();
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
        for tool in self.session.tools.iter_mut().filter(|tool| tool.device == index) {
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
    /// A device in a loop at `rate` (Hz).
    fn new(device: Box<dyn HapticDevice>, rate: f64) -> Self {
        let info = device.device_info();
        Self {
            poses: vec![Pose::default(); (info.effectors as usize).min(MAX_EFFECTORS)],
            divider: (rate / info.rate).round().max(1.0) as u64,
            device,
            loss: None,
        }
    }
}
