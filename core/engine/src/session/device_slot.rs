//! An opened device of a session.

use crate::recording::RecordedHands;
use crate::tool::Frame;
use pliant_host::{Device, DeviceInfo, Pose};
use std::path::Path;
use std::sync::Arc;

/// An opened device.
pub struct DeviceSlot {
    /// Name in the scene.
    pub name: String,
    /// The device; `None` if it is lost or the caller has it.
    pub device: Option<Device>,
    /// Information reported by the device.
    pub facts: DeviceInfo,
    /// Its coordinate frame in the scene.
    pub frame: Frame,
    /// Source of its samples, for messages: name, plugin and text parameters, such as an address.
    pub origin: String,
    pub(super) poses: Vec<Pose>,
    /// The recording that it takes its hands from, and its index among the recorded devices; `None` for a plugin's device.
    pub(super) recorded: Option<(Arc<RecordedHands>, usize)>,
    /// Whether the caller places its hands, see [`place_hand`](super::Session::place_hand).
    pub(super) driven: bool,
    /// Its counters at the time it was lost.
    pub(super) counted: Vec<(String, u64)>,
}

impl DeviceSlot {
    /// Its counters since it was opened, also if it has been lost; empty if the caller has the device.
    pub fn counters(&self) -> Vec<(String, u64)> {
        self.device.as_ref().map_or_else(|| self.counted.clone(), Device::counters)
    }

    /// Closes the device for good.
    pub(super) fn lose(&mut self) {
        self.counted = self.counters();
        self.device = None;
    }

    /// Path of the recording that it takes its hands from; `None` for a plugin's device.
    pub fn recording(&self) -> Option<&Path> {
        self.recorded.as_ref().map(|(hands, _)| hands.path())
    }

    /// Poses of its hands in the last step.
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }
}
