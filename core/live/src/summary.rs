//! Statistics of timing and force safety of a live session. Keys in files differ from names of fields where `serde` renames them.

use crate::histogram::Percentiles;
use crate::realtime::{RealtimeStatus, ThreadUsage};
use serde::Serialize;
use std::collections::BTreeMap;

/// Counters of the devices by name; devices without counters are left out.
pub type DeviceCounts = BTreeMap<String, BTreeMap<String, u64>>;

/// The hand of one tool.
#[derive(Clone, Debug, Serialize)]
pub struct HandSummary {
    /// Name of the tool in the scene.
    pub tool: String,
    /// Number of forces changed by force safety, by cause.
    #[serde(rename = "changed")]
    pub safety_counts: BTreeMap<&'static str, u64>,
    /// Number of samples of the haptic thread that were not valid or not finite.
    #[serde(rename = "dropped")]
    pub dropped_samples: u64,
    /// Number of samples that were followed at the speed limit.
    #[serde(rename = "slowed")]
    pub speed_limited_samples: u64,
    /// Energy the hand has put in minus energy returned to it, J; negative if the force has generated energy.
    pub energy: f64,
}

/// Timing and force safety of a live session.
#[derive(Clone, Debug, Serialize)]
pub struct LiveSummary {
    /// Wall-clock duration, s.
    pub seconds: f64,
    /// Requested rate of the haptic loop, Hz.
    pub rate: f64,
    /// Real-time settings of the haptic thread.
    #[serde(flatten)]
    pub realtime: RealtimeStatus,
    /// Processor use of the haptic thread; `None` if the system does not report it.
    #[serde(rename = "took")]
    pub thread_usage: Option<ThreadUsage>,
    /// Number of ticks finished.
    pub ticks: u64,
    /// Number of missed deadlines: ticks not finished before the next one was due.
    pub missed: u64,
    /// Time between the beginnings of two ticks.
    pub period: Option<Percentiles>,
    /// Time from the deadline of a tick to its beginning.
    pub lateness: Option<Percentiles>,
    /// Time from reading the devices to the end of writing the forces.
    pub latency: Option<Percentiles>,
    /// Age of a contact model when a force is rendered from it: time since its hand sample.
    pub contact_age: Option<Percentiles>,
    /// Simulated time that was skipped because the simulation was too slow, s.
    #[serde(rename = "lost")]
    pub lost_time: f64,
    /// Ratio of simulated time to wall-clock time; 1 is real time.
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
