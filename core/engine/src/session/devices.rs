//! The hands of a step: from devices, from whoever has them, or where the caller puts them.

use super::Session;
use super::event::EventKind;
use super::hand_events::{SampleCounts, add_sample_events};
use nalgebra::UnitQuaternion;
use pliant_host::{Device, EffectorOutput, MAX_EFFECTORS, Pose};
use pliant_plugin_api::abi::POSE_VALID;
use pliant_solver::{StepTime, Vec3};

/// ns, how long a device may go on with a force after the step it was meant for.
const VALID: u64 = 50_000_000;

/// Where a hand is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandPose {
    /// m, in the scene
    pub position: Vec3,
    /// Turns axes of the hand into scene axes.
    pub rotation: UnitQuaternion<f64>,
    /// Bit i is button i.
    pub buttons: u32,
}

impl Session {
    /// Puts the hand of the tool at index `tool` somewhere until it is put elsewhere; `None` takes it away. The first call lets its device
    /// go: from then on all hands of that device are where the caller puts them.
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

    /// Takes one step. Whatever a plugin does wrong is contained: its body stands still, its device is lost, and the rest
    /// goes on; the events say so.
    pub fn step(&mut self) {
        self.read_devices();
        self.advance();
        self.write_devices();
    }

    /// Takes one step with hands that come from elsewhere: the poses of each device, in their order. A device that is
    /// missing or has too few poses has no hand there. What is felt is left in the frame.
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

    /// What the hands were really given while the last step was under way, N, in the axes of the devices, in the order of the
    /// tools.
    pub fn report_device_forces(&mut self, given: &[Vec3]) {
        for (felt, given) in self.frame.tools.iter_mut().zip(given) {
            felt.device_force = *given;
        }
    }

    /// Hands over the open devices, by place: the session goes on with [`Session::step_with`].
    pub fn take_devices(&mut self) -> Vec<Option<Device>> {
        self.devices.iter_mut().map(|slot| slot.device.take()).collect()
    }

    fn read_devices(&mut self) {
        let now = self.time() + self.dt;
        for slot in &mut self.devices {
            if slot.driven {
                slot.poses.iter_mut().for_each(|pose| pose.time_ns = nanoseconds(now));
                continue;
            }
            slot.poses.fill(Pose::default());
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
                // It comes from nowhere, not along a line from where it was last.
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
            outputs.iter_mut().for_each(|o| o.valid_until = now + VALID);
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
