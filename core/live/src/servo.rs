//! One tick of the haptic thread: read the devices, render the contacts, write to the devices.
//!
//! *Real time*: nothing here allocates, locks, logs or does I/O of its own, and nothing loops over a mesh.

use super::exchange::{Exchange, Models, Samples};
use super::haptic::{Haptic, StopNow};
use super::histogram::Histogram;
use pliant_engine::session::Session;
use pliant_engine::tool::{Blend, ForceLimits, ForceSafety, Frame, Hand, Moment, PATIENCE, Passivity};
use pliant_host::{MOST_EFFECTORS, Output, Pose};
use pliant_plugin_api::abi::Status;
use pliant_solver::{V3, axpy};
use triple_buffer::triple_buffer;

/// ns, how long a device may go on with a force when nothing comes after it
const VALID: u64 = 50_000_000;

/// The devices and tools of a session, as the haptic thread has them.
pub struct Servo {
    arms: Vec<Arm>,
    /// In the order of the session's.
    pub(super) tools: Vec<ServoTool>,
    models: triple_buffer::Output<Models>,
    samples: triple_buffer::Input<Samples>,
    rate: f64,
    tick: u64,
    before: Option<u64>,
    /// s, that a rendered contact was behind the hand
    pub(super) age: Histogram,
}

struct Arm {
    device: Box<dyn Haptic>,
    frame: Frame,
    poses: Vec<Pose>,
    /// It is served in every so-manieth tick.
    every: u64,
    lost: Option<(&'static str, Status)>,
}

pub(super) struct ServoTool {
    pub(super) name: String,
    arm: usize,
    effector: usize,
    pub(super) hand: Hand,
    blend: Blend,
    pub(super) safety: ForceSafety,
    given: V3,
    /// N, of its tactile array
    taxels: Vec<f64>,
}

/// Hz, the fastest loop
const FASTEST: f64 = 4000.0;

/// The haptic side of a session over `devices`, in the order of the session's, and the simulation's end of what goes between.
/// `rate` (Hz) is the loop's; by default that of the fastest device, up to 4 kHz.
///
/// # Panics
/// If there is not one device for each of the session.
pub fn servo(session: &Session, devices: Vec<Box<dyn Haptic>>, rate: Option<f64>) -> (Servo, Exchange) {
    assert_eq!(devices.len(), session.devices.len(), "one for each of the session");
    let fastest = devices.iter().map(|device| device.facts().rate).fold(0.0, f64::max);
    let rate = rate.unwrap_or(if fastest > 0.0 { fastest } else { 1000.0 }).clamp(1.0, FASTEST);
    let arm = |(device, slot): (Box<dyn Haptic>, &pliant_engine::session::DeviceSlot)| Arm {
        poses: vec![Pose::default(); (device.facts().effectors as usize).min(MOST_EFFECTORS)],
        every: (rate / device.facts().rate).round().max(1.0) as u64,
        frame: slot.frame,
        device,
        lost: None,
    };
    let arms: Vec<Arm> = devices.into_iter().zip(&session.devices).map(arm).collect();
    let tool = |slot: &pliant_engine::session::ToolSlot| {
        let facts = arms[slot.device].device.facts();
        let limits = ForceLimits { continuous: facts.continuous_force, ..slot.safety.limits() };
        let stored = limits.peak * limits.peak / slot.tool.coupling.stiffness;
        let passivity = Passivity::new(facts.damping, facts.resolution, stored);
        ServoTool {
            name: slot.tool.name.clone(),
            arm: slot.device,
            effector: slot.effector,
            hand: Hand::new(slot.hand.fastest),
            blend: Blend::default(),
            safety: ForceSafety::new(limits).observed(passivity),
            given: [0.0; 3],
            taxels: slot.pad.as_ref().map_or_else(Vec::new, |pad| pad.taxels.clone()),
        }
    };
    let tools: Vec<ServoTool> = session.tools.iter().map(tool).collect();
    let (models, models_out) = triple_buffer(&Models {
        contacts: vec![Default::default(); tools.len()],
        taxels: tools.iter().map(|tool| tool.taxels.clone()).collect(),
    });
    let (samples, samples_out) = triple_buffer(&Samples {
        time: 0,
        poses: arms.iter().map(|arm| arm.poses.clone()).collect(),
        given: vec![[0.0; 3]; tools.len()],
        lost: vec![None; arms.len()],
    });
    let age = Histogram::default();
    let servo = Servo { arms, tools, models: models_out, samples, rate, tick: 0, before: None, age };
    (servo, Exchange::new(samples_out, models))
}

impl Servo {
    /// Hz
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// N, what each tool's effector was given last, in the axes of its device
    pub fn given(&self) -> impl Iterator<Item = V3> + '_ {
        self.tools.iter().map(|tool| tool.given)
    }

    /// The last thing each tool's force passes.
    pub fn safety(&mut self) -> impl Iterator<Item = &mut ForceSafety> {
        self.tools.iter_mut().map(|tool| &mut tool.safety)
    }

    /// An emergency stop for each device.
    pub fn stoppers(&self) -> Vec<StopNow> {
        self.arms.iter().map(|arm| arm.device.stopper()).collect()
    }

    /// What there is to say of lost devices, by place.
    pub fn losses(&self) -> impl Iterator<Item = (usize, String)> {
        self.arms.iter().enumerate().filter_map(|(i, arm)| {
            let (call, status) = arm.lost?;
            Some((i, arm.device.told(call, status)))
        })
    }

    /// What each device has counted since it was opened, lost or not, by place; outside of the haptic thread.
    pub fn counters(&self) -> impl Iterator<Item = Vec<(String, u64)>> {
        self.arms.iter().map(|arm| arm.device.counters())
    }

    /// Serves every device that is due at `now` (ns).
    pub fn tick(&mut self, now: u64) {
        let gap = self.before.map_or(0, |before| now.saturating_sub(before));
        self.before = Some(now);
        if gap as f64 * 1e-9 > PATIENCE {
            // Everything may have changed; devices are at zero by themselves by now.
            self.tools.iter_mut().for_each(|tool| tool.safety.release());
        }
        if self.models.update() {
            let models = self.models.output_buffer_mut();
            for ((tool, contact), taxels) in self.tools.iter_mut().zip(&models.contacts).zip(&models.taxels) {
                tool.blend.take(*contact, now);
                tool.taxels.copy_from_slice(taxels);
            }
        }
        for index in 0..self.arms.len() {
            if self.arms[index].lost.is_none() && self.tick.is_multiple_of(self.arms[index].every) {
                self.serve(index, now);
            }
        }
        self.tick += 1;
        let samples = self.samples.input_buffer_mut();
        samples.time = now;
        for (index, arm) in self.arms.iter().enumerate() {
            samples.poses[index].copy_from_slice(&arm.poses);
            samples.lost[index] = arm.lost;
        }
        for (given, tool) in samples.given.iter_mut().zip(&self.tools) {
            *given = tool.given;
        }
        self.samples.publish();
    }

    fn serve(&mut self, index: usize, now: u64) {
        let arm = &mut self.arms[index];
        arm.poses.fill(Pose::default());
        let status = arm.device.read(now, &mut arm.poses);
        if status != Status::OK {
            return self.lose(index, "read", status);
        }
        let dt = arm.every as f64 / self.rate;
        let mut outputs = [Output { valid_until: now + VALID, ..Output::default() }; MOST_EFFECTORS];
        for tool in self.tools.iter_mut().filter(|tool| tool.arm == index) {
            let Some(pose) = arm.poses.get(tool.effector) else { continue };
            tool.hand.sample(pose, &arm.frame, (now as f64 * 1e-9, dt));
            tool.given = tool.render(&arm.frame, now, dt, &mut self.age);
            if !tool.hand.present || tool.blend.age(now) > PATIENCE {
                tool.taxels.fill(0.0);
            }
            (outputs[tool.effector].force, outputs[tool.effector].taxels) = (tool.given, &tool.taxels);
        }
        let status = arm.device.write(now, &outputs[..arm.poses.len()]);
        if status != Status::OK {
            self.lose(index, "write", status);
        }
    }

    fn lose(&mut self, index: usize, call: &'static str, status: Status) {
        let arm = &mut self.arms[index];
        arm.lost = Some((call, status));
        arm.poses.fill(Pose::default());
        for tool in self.tools.iter_mut().filter(|tool| tool.arm == index) {
            tool.safety.release();
            tool.given = [0.0; 3];
        }
    }

    /// Zero force on everything: the end, whatever led to it.
    pub fn stop(&mut self) {
        self.stoppers().iter().for_each(|stop| stop());
    }
}

impl Drop for Servo {
    fn drop(&mut self) {
        self.stop();
    }
}

impl ServoTool {
    /// N, on the hand, in the axes of the device
    fn render(&mut self, frame: &Frame, now: u64, dt: f64, ages: &mut Histogram) -> V3 {
        if !self.hand.present {
            self.safety.release();
            return [0.0; 3];
        }
        let in_scene = self.blend.force(self.hand.position, now);
        let force = frame.to_device(in_scene);
        // A metre of the hand is `scale` of the scene's.
        let compliance = self.blend.compliance(in_scene) / frame.scale;
        let mut age = 0.0;
        if self.blend.is_contact() {
            age = self.blend.age(now);
            ages.add((age * 1e9) as u64);
        }
        let place = axpy(self.hand.position, -1.0, frame.origin);
        let position = frame.to_device(place).map(|c| c / frame.scale);
        self.safety.pass_live(force, Moment { position, age, compliance }, dt)
    }
}
