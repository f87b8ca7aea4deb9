//! Timing and force safety of a live session in numbers. The keys in files are older than some names of fields; `serde` keeps them.

use crate::histogram::Percentiles;
use crate::realtime::{RealtimeStatus, ThreadUsage};
use serde::Serialize;
use std::collections::BTreeMap;

/// Counters of the devices by their names, those without counters left out.
pub type DeviceCounts = BTreeMap<String, BTreeMap<String, u64>>;

/// The hand of one tool.
#[derive(Clone, Debug, Serialize)]
pub struct HandSummary {
    /// Name of the tool in the scene.
    pub tool: String,
    /// Number of times each measure of force safety changed the force, by cause.
    #[serde(rename = "changed")]
    pub safety_counts: BTreeMap<&'static str, u64>,
    /// Number of samples of the haptic thread that were not valid or not finite.
    #[serde(rename = "dropped")]
    pub dropped_samples: u64,
    /// Number of samples that were followed at the speed limit.
    #[serde(rename = "slowed")]
    pub speed_limited_samples: u64,
    /// J, energy the hand has given and not got back; below zero the force has given the hand energy
    pub energy: f64,
}

/// Timing and force safety of a live session.
#[derive(Clone, Debug, Serialize)]
pub struct LiveSummary {
    /// s, wall clock
    pub seconds: f64,
    /// Hz, rate of the haptic loop as asked for
    pub rate: f64,
    /// Real-time settings of the haptic thread.
    #[serde(flatten)]
    pub realtime: RealtimeStatus,
    /// Use of the processor by the haptic thread; `None` where the system does not tell.
    #[serde(rename = "took")]
    pub thread_usage: Option<ThreadUsage>,
    /// Number of ticks finished.
    pub ticks: u64,
    /// Number of ticks that were not finished before the next was due.
    pub missed: u64,
    /// Time from the beginning of a tick to that of the next.
    pub period: Option<Percentiles>,
    /// Time from the deadline of a tick to its beginning.
    pub lateness: Option<Percentiles>,
    /// Time from reading the devices to having written the forces for those samples.
    pub latency: Option<Percentiles>,
    /// Time from the sample of the hand that a contact was computed for to a force rendered from that contact.
    pub contact_age: Option<Percentiles>,
    /// s, time the simulation fell behind the clock and did not catch up
    #[serde(rename = "lost")]
    pub lost_time: f64,
    /// Simulated time over wall-clock time: 1 keeps real time.
    #[serde(rename = "kept")]
    pub real_time_factor: f64,
    /// Number of times the watchdog stopped the devices.
    #[serde(rename = "watchdog")]
    pub watchdog_trips: u64,
    /// Whether the haptic thread ended by a panic.
    pub panicked: bool,
    /// Hands in the order of the tools.
    pub hands: Vec<HandSummary>,
    /// Counters of the devices. The summary of a run has them in its own `devices`, live or not.
    #[serde(skip)]
    pub devices: DeviceCounts,
}
