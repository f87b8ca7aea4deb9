//! What happened in a run besides what was asked for: counted by kind, the first of each told in full.

use serde::Serialize;
use std::collections::BTreeMap;

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EventKind {
    /// A plugin said something.
    Message,
    /// A body was frozen: its material failed, or its state was no longer finite.
    Quarantine,
    /// A device was lost.
    DeviceLost,
    /// A force on a hand was changed to keep it safe.
    ForceSafety,
    /// Samples of a hand were dropped.
    SampleDropped,
    /// A hand moved faster than it is followed.
    SpeedLimit,
    /// A pull let go because of its force.
    GripLost,
    /// A hand pulls with more than its tool's coupling gives: the body follows less than the hand.
    ForceLimit,
    /// A cut could not be made there; the model is what it was.
    CutRefused,
    /// Something was taken back or made again.
    History,
    /// A solve did not meet its tolerance.
    NotConverged,
    /// More substeps were taken than planned.
    Substeps,
    /// One step is longer than a hand can be followed well.
    LongStep,
    /// An explicit integrator was forced over its limit.
    Unstable,
    /// A body came to rest and sleeps.
    Asleep,
    /// Something about a model.
    Model,
    /// A shape that was kept had inverted or flat cells, which were repaired.
    Repaired,
}

/// An event that is described in full.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// s
    pub time: f64,
    /// Description for people.
    pub text: String,
}

/// Everything that happened.
#[derive(Clone, Debug, Default)]
pub struct Events {
    counts: BTreeMap<EventKind, u64>,
    told: Vec<(EventKind, Event)>,
}

/// Events of a kind that are told in full.
const TOLD: u64 = 8;

impl Events {
    /// One more of `kind`. `text` is only made if it will be told.
    pub fn add(&mut self, kind: EventKind, time: f64, text: impl FnOnce() -> String) {
        self.add_many(kind, 1, time, text);
    }

    /// `many` more of `kind`, told as one.
    pub fn add_many(&mut self, kind: EventKind, many: u64, time: f64, text: impl FnOnce() -> String) {
        if many == 0 {
            return;
        }
        let count = self.counts.entry(kind).or_default();
        if *count < TOLD {
            self.told.push((kind, Event { time, text: text() }));
        }
        *count += many;
    }

    /// `many` more of `kind` in a step, told when they begin: `ongoing` says whether the step before had some, and is set for this one.
    pub(super) fn add_episode(
        &mut self,
        kind: EventKind,
        many: u64,
        ongoing: &mut bool,
        time: f64,
        text: impl FnOnce() -> String,
    ) {
        if *ongoing && many > 0 {
            *self.counts.entry(kind).or_default() += many;
        } else {
            self.add_many(kind, many, time, text);
        }
        *ongoing = many > 0;
    }

    /// How many there were of each kind.
    pub fn counts(&self) -> &BTreeMap<EventKind, u64> {
        &self.counts
    }

    /// Those told in full, in order.
    pub fn told(&self) -> &[(EventKind, Event)] {
        &self.told
    }

    /// How many there were of a kind.
    pub fn count(&self, kind: EventKind) -> u64 {
        self.counts.get(&kind).copied().unwrap_or(0)
    }
}
