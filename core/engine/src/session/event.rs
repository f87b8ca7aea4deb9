//! Events of a run, counted by kind; the first ones of each kind have a description, and every answer to a request.

use serde::Serialize;
use std::collections::BTreeMap;

/// Kinds of events.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EventKind {
    /// A plugin logged a message.
    Message,
    /// A body was frozen because its material failed or its state was not finite.
    Quarantine,
    /// A device was lost.
    DeviceLost,
    /// Force safety changed a force.
    ForceSafety,
    /// Samples of a hand were dropped.
    SampleDropped,
    /// A hand moved faster than its speed limit.
    SpeedLimit,
    /// A grip was lost because its force exceeded the limit.
    GripLost,
    /// A hand pulls with more than the largest force of its tool's coupling, so the body follows less than the hand.
    ForceLimit,
    /// A cut was refused; the model is unchanged.
    CutRefused,
    /// A material does not let the parameter vary that an edit paints.
    PaintRefused,
    /// Parts of a body have become bodies of their own.
    Split,
    /// A body was to be split and stays as it is.
    SplitRefused,
    /// A change of sculpt layers was refused; shape and layers are unchanged.
    LayerRefused,
    /// A cut or a stitch has fixed the sculpt layers from before it.
    LayerFixed,
    /// An edit was undone or redone.
    History,
    /// A solve did not meet its tolerance.
    NotConverged,
    /// A step would have gained energy and was taken again: an implicit one with backward Euler and more Newton iterations, an explicit one with more
    /// substeps.
    RepeatedStep,
    /// More substeps were taken than planned.
    Substeps,
    /// The step is too long to follow a hand well.
    LongStep,
    /// An explicit integrator was forced beyond its step limit, or a contact asks for more substeps than are allowed.
    Unstable,
    /// Collisions between bodies are left after a step.
    CollisionsLeft,
    /// A body fell asleep.
    Asleep,
    /// Elements of a body have failed, because its material has failed there.
    ElementsFailed,
    /// A model has a defect.
    Model,
    /// A shape was to be kept and springs back, for elements of the solid have failed.
    NotKept,
    /// A shape that was kept had inverted or flat cells, which were repaired.
    Repaired,
}

/// An event with its description.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Event {
    /// Simulated time, s.
    pub time: f64,
    /// Description for people.
    pub text: String,
}

/// All events of a session.
#[derive(Clone, Debug, Default)]
pub struct Events {
    counts: BTreeMap<EventKind, u64>,
    told: Vec<(EventKind, Event)>,
}

/// Number of events of a kind that are described. A refusal answers a request and is always described.
const MAX_DESCRIBED: u64 = 8;

impl Events {
    /// Adds an event at `time` (s). `text` is called only if the event is described.
    pub fn add(&mut self, kind: EventKind, time: f64, text: impl FnOnce() -> String) {
        self.add_many(kind, 1, time, text);
    }

    /// Adds `many` events of a kind with one description.
    pub fn add_many(&mut self, kind: EventKind, many: u64, time: f64, text: impl FnOnce() -> String) {
        if many == 0 {
            return;
        }
        let count = self.counts.entry(kind).or_default();
        if *count < MAX_DESCRIBED || matches!(kind, EventKind::LayerRefused | EventKind::SplitRefused) {
            self.told.push((kind, Event { time, text: text() }));
        }
        *count += many;
    }

    /// Adds the `many` events of a kind in a step, described once at the beginning of an episode. `ongoing` tells whether the last step had such events and
    /// is updated.
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

    /// Number of events of each kind.
    pub fn counts(&self) -> &BTreeMap<EventKind, u64> {
        &self.counts
    }

    /// The described events in order of time.
    pub fn told(&self) -> &[(EventKind, Event)] {
        &self.told
    }

    /// Number of events of a kind.
    pub fn count(&self, kind: EventKind) -> u64 {
        self.counts.get(&kind).copied().unwrap_or(0)
    }
}
