//! How well a live session kept its time and its limits.

use super::footing::{Footing, Took};
use super::histogram::Spread;
use serde::Serialize;
use std::collections::BTreeMap;

/// What devices have counted, by their names; those that count nothing are not here.
pub type DeviceCounts = BTreeMap<String, BTreeMap<String, u64>>;

/// One tool's hand.
#[derive(Clone, Debug, Serialize)]
pub struct HandSummary {
    /// As the scene calls the tool.
    pub tool: String,
    /// How often each cause changed its force.
    pub changed: BTreeMap<&'static str, u64>,
    /// Samples of the haptic thread that were not valid or not finite.
    pub dropped: u64,
    /// Samples that were followed at the limit of speed.
    pub slowed: u64,
    /// J, what the hand has given and not got back; below zero: made by the force
    pub energy: f64,
}

/// A live session in numbers.
#[derive(Clone, Debug, Serialize)]
pub struct LiveSummary {
    /// s, wall clock
    pub seconds: f64,
    /// Hz, of the haptic loop, as asked for
    pub rate: f64,
    /// What its thread was given.
    #[serde(flatten)]
    pub footing: Footing,
    /// What its thread went without, where the system tells.
    pub took: Option<Took>,
    /// Ticks done.
    pub ticks: u64,
    /// Ticks that were not done before the next was due.
    pub missed: u64,
    /// From the beginning of a tick to that of the next.
    pub period: Option<Spread>,
    /// From when a tick was due to its beginning.
    pub lateness: Option<Spread>,
    /// From reading the devices to having written the forces of those samples.
    pub latency: Option<Spread>,
    /// From the sample of the hand a contact was computed for to a force rendered from it.
    pub contact_age: Option<Spread>,
    /// s, that the simulation fell behind the clock for good
    pub lost: f64,
    /// Share of real time the simulation kept.
    pub kept: f64,
    /// How often the watchdog stopped the devices.
    pub watchdog: u64,
    /// Whether the haptic thread ended by a panic.
    pub panicked: bool,
    /// In the order of the tools.
    pub hands: Vec<HandSummary>,
    /// What the devices counted, by their names: in the summary of a run they stand where those of other runs do.
    #[serde(skip)]
    pub devices: DeviceCounts,
}
