//! The torque of a tool on the haptic thread: that of the last simulated step, past the limits and the passivity of its rotation.
//!
//! *Real time*: as the servo.

use pliant_engine::session::ToolSlot;
use pliant_engine::tool::{Frame, Hand, HandTurn, Passivity, TorqueSafety};
use pliant_host::DeviceInfo;
use pliant_solver::Vec3;

/// Torque of one tool.
pub(crate) struct ServoTorque {
    /// Torque of the last simulated step, in axes of the scene, N m.
    pub(crate) simulated: Vec3,
    /// `None` for a device that renders no torque, or does not state its peak.
    safety: Option<TorqueSafety>,
    /// The hand at the last tick, and the sum of its rotation vectors, in axes of the device, rad.
    last: Option<Hand>,
    rotation: Vec3,
}

impl ServoTorque {
    /// The torque of a tool of the session on a device with these properties.
    pub(crate) fn new(slot: &ToolSlot, device: &DeviceInfo) -> Self {
        let limits = slot.torque_safety.as_ref().map(TorqueSafety::limits);
        let safety = limits.and_then(|limits| {
            // Twice the energy that the coupling stores at the peak force, as for the force.
            let stored = limits.peak * limits.peak / slot.tool.coupling.stiffness;
            let passivity = Passivity::new(device.damping, device.resolution, stored);
            TorqueSafety::new(device.peak_torque, limits).map(|safety| safety.with_passivity(passivity))
        });
        Self { simulated: Vec3::zeros(), safety, last: None, rotation: Vec3::zeros() }
    }

    /// Torque on the hand, in axes of the device, N m, `dt` (s) after the last one, from a simulation of this `age` (s).
    pub(crate) fn render(&mut self, hand: &Hand, frame: &Frame, age: f64, dt: f64) -> Vec3 {
        let Some(safety) = &mut self.safety else { return Vec3::zeros() };
        if !hand.present {
            self.release();
            return Vec3::zeros();
        }
        let before = self.last.replace(hand.clone());
        let turn = before.map_or(Vec3::zeros(), |before| (hand.rotation * before.rotation.inverse()).scaled_axis());
        self.rotation += frame.to_device(turn);
        let age = if self.simulated == Vec3::zeros() { 0.0 } else { age };
        safety.pass_live(frame.to_device(self.simulated), HandTurn { rotation: self.rotation, age }, dt)
    }

    /// Goes on from the torque of another session on the same effector; `factor` is a torque of this one over the same torque of that one.
    pub(crate) fn resume(&mut self, before: &Self, factor: f64) {
        self.simulated = factor * before.simulated;
        (self.last, self.rotation) = (before.last.clone(), before.rotation);
        if let (Some(now), Some(before)) = (&mut self.safety, &before.safety) {
            now.resume(before, factor);
        }
    }

    /// Sets the torque to zero at once: the hand or the device is gone.
    pub(crate) fn release(&mut self) {
        self.last = None;
        if let Some(safety) = &mut self.safety {
            safety.release();
        }
    }
}
