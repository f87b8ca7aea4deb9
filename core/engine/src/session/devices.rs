//! The hands of a step: read from devices, passed by the caller as device poses, or placed by the caller in the scene.

use super::Session;
use super::event::EventKind;
use super::hand_events::{SampleCounts, add_sample_events};
use nalgebra::UnitQuaternion;
use pliant_host::{Device, EffectorOutput, MAX_EFFECTORS, Pose};
use pliant_plugin_api::abi::POSE_VALID;
use pliant_solver::{CancelToken, StepTime, Vec3};

/// Time for which a device may hold a force after its step, ns.
const FORCE_HOLD: u64 = 50_000_000;

/// Pose of a hand in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandPose {
    /// Position of the hand, m.
    pub position: Vec3,
    /// Rotation from axes of the hand to those of the scene.
    pub rotation: UnitQuaternion<f64>,
    /// Pressed buttons: bit i is button i.
    pub buttons: u32,
}

impl Session {
    /// Places the hand of the tool with index `tool` until the next call; `None` removes it. The first call releases its device: from then on the caller
    /// places all hands of that device.
    ///
    /// # Panics
    /// If there is no such tool.
    pub fn place_hand(&mut self, tool: usize, pose: Option<HandPose>) {
        let slot = &self.tools[tool];
        let device = &mut self.devices[slot.device];
        if !device.driven {
            device.lose();
            device.driven = true;
            device.poses.fill(Pose::default());
        }
        device.poses[slot.effector] = pose.map_or_else(Pose::default, |pose| {
            let [x, y, z, w] = (device.frame.rotation.inverse() * pose.rotation).coords.into();
            let position = device.frame.to_hand(pose.position).into();
            Pose { flags: POSE_VALID, buttons: pose.buttons, position, orientation: [x, y, z, w], ..Pose::default() }
        });
    }

    /// Takes one step. A failing plugin is isolated: its body is frozen or its device lost, with an event, and the rest continues.
    ///
    /// A step that is cancelled ([`Session::cancel_when`]) is not taken: the devices are stopped, and the body under way stays as it was before. What tools
    /// have begun in it stays, and so do the moves of bodies that come before it in the scene; the next call goes on from there, with the hands of the
    /// cancelled one, so both together are one step. If nodes were changed in between, as by an undo, the step begins anew.
    pub fn step(&mut self) {
        if self.guard.resumes_at.is_none() {
            self.read_devices();
        }
        self.advance();
        if self.guard.is_cancelled {
            self.stop_devices();
        } else {
            self.write_devices();
        }
    }

    /// Ends the step under way and all later ones when `token` is cancelled.
    pub fn cancel_when(&mut self, token: CancelToken) {
        self.guard.cancel = token;
    }

    /// Whether the last step was cancelled: it was not completed, and [`Session::frame`] is still that of the step before.
    pub fn is_cancelled(&self) -> bool {
        self.guard.is_cancelled
    }

    /// Sets the forces of all devices to zero. One that fails is lost.
    pub fn stop_devices(&mut self) {
        let now = self.time();
        for slot in &mut self.devices {
            if let Some(Err(error)) = slot.device.as_ref().map(Device::stop) {
                self.events.add(EventKind::DeviceLost, now, || error.to_string());
                slot.lose();
            }
        }
    }

    /// Takes one step with the given poses of each device, in the order of the devices. The hands of missing devices and poses are absent. Forces are in
    /// the frame.
    pub fn step_with<P: AsRef<[Pose]>>(&mut self, poses: &[P]) {
        for slot in &mut self.devices {
            slot.poses.fill(Pose::default());
        }
        for (slot, given) in self.devices.iter_mut().zip(poses) {
            for (to, from) in slot.poses.iter_mut().zip(given.as_ref()) {
                *to = *from;
            }
        }
        self.advance();
    }

    /// Reports the forces that were rendered to the hands during the last step, N (tools x 3), in axes of the devices.
    pub fn report_device_forces(&mut self, given: &[Vec3]) {
        for (felt, given) in self.frame.tools.iter_mut().zip(given) {
            felt.device_force = *given;
        }
    }

    /// Moves the open devices to the caller, by index; the session continues with [`Session::step_with`].
    pub fn take_devices(&mut self) -> Vec<Option<Device>> {
        self.devices.iter_mut().map(|slot| slot.device.take()).collect()
    }

    fn read_devices(&mut self) {
        let now = self.time() + self.clock.dt;
        for slot in &mut self.devices {
            if slot.driven {
                slot.poses.iter_mut().for_each(|pose| pose.time_ns = nanoseconds(now));
                continue;
            }
            slot.poses.fill(Pose::default());
            if let Some((recording, device)) = &slot.recorded {
                for (to, from) in slot.poses.iter_mut().zip(recording.poses(*device, self.clock.steps)) {
                    *to = *from;
                }
                continue;
            }
            let Some(device) = &mut slot.device else { continue };
            if let Err(error) = device.read(nanoseconds(now), &mut slot.poses) {
                self.events.add(EventKind::DeviceLost, now, || error.to_string());
                slot.lose();
                slot.poses.fill(Pose::default());
            }
        }
    }

    pub(super) fn sample_hands(&mut self, StepTime { start: time, dt }: StepTime) {
        let now = time + dt;
        for slot in self.tools.iter_mut().filter(|slot| slot.mirror.is_none()) {
            let device = &self.devices[slot.device];
            if device.driven && device.poses[slot.effector].flags & POSE_VALID == 0 {
                slot.hand.leave();
                continue;
            }
            let (before, was_present) = (SampleCounts::of(slot), slot.hand.present);
            slot.hand.sample(&device.poses[slot.effector], &device.frame, now, dt);
            if slot.hand.present && !was_present {
                // A placed hand appears at its position, without a path from the last one.
                slot.tool.release(&slot.hand);
            }
            add_sample_events(&mut self.events, slot, device, before, now);
        }
        self.mirror_hands();
    }

    fn write_devices(&mut self) {
        let time = self.time();
        let now = nanoseconds(time);
        for (index, slot) in self.devices.iter_mut().enumerate() {
            let Some(device) = &mut slot.device else { continue };
            let mut outputs = [EffectorOutput::default(); MAX_EFFECTORS];
            for (tool, felt) in self.tools.iter().zip(&self.frame.tools) {
                if tool.device == index && tool.mirror.is_none() {
                    outputs[tool.effector].force = felt.device_force.into();
                    outputs[tool.effector].torque = felt.device_torque.into();
                    outputs[tool.effector].taxels = tool.pad.as_ref().map_or(&[], |pad| &pad.taxels);
                }
            }
            outputs.iter_mut().for_each(|o| o.valid_until = now + FORCE_HOLD);
            if let Err(error) = device.write(now, &outputs[..slot.poses.len()]) {
                self.events.add(EventKind::DeviceLost, time, || error.to_string());
                slot.lose();
            }
        }
    }
}

fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}
