//! Events of a run: counts by kind, and a description of the first of each kind and of every refusal.

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
    /// Two hands hold a body in local regions that do not meet: what is between them stays at rest.
    GripsApart,
    /// A hand pulls with more than the largest force of its tool's coupling, so the body follows less than the hand.
    ForceLimit,
    /// A cut was refused; the model is unchanged.
    CutRefused,
    /// A blade was drawn right through a body, and its parts still hold together.
    CutHeld,
    /// A blade went along an earlier cut, where nothing is left to cut.
    CutAgain,
    /// Bodies were to be stitched together and cannot be.
    StitchRefused,
    /// Ties between bodies are gone with the surface that they were on.
    StitchOpened,
    /// An edit was to paint a parameter that the material does not let vary.
    PaintRefused,
    /// Parts of a body have become bodies of their own.
    Split,
    /// A request to split a body was refused; the body is unchanged.
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
    /// Vertices of a model's borders that lie where others do are taken as one with them.
    Welded,
    /// A shape was to be kept but springs back, because elements of the solid have failed, cells of it are inverted, or the hand had let go.
    NotKept,
    /// A shape that was kept had inverted or flat cells, or a folded surface, which were repaired.
    Repaired,
    /// A shape was kept with a folded surface.
    FoldsLeft,
}

impl EventKind {
    /// Whether an event of this kind says that something a user asked for was not done. Each is described, once for a stroke.
    const fn is_refusal(self) -> bool {
        matches!(
            self,
            Self::CutRefused
                | Self::CutHeld
                | Self::CutAgain
                | Self::StitchRefused
                | Self::PaintRefused
                | Self::SplitRefused
                | Self::LayerRefused
                | Self::NotKept
        )
    }
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
    /// Number of descriptions of each kind.
    descriptions: BTreeMap<EventKind, usize>,
    /// The last refusal of each kind, described or not.
    last_refusals: BTreeMap<EventKind, Event>,
    described: Vec<(EventKind, Event)>,
}

/// Largest number of descriptions of one kind that is not a refusal.
const MAX_DESCRIBED: usize = 8;
/// Largest number of described refusals of one kind: what a session keeps is limited.
const MAX_REFUSALS: usize = 1000;
/// A refusal that repeats the last one within this time (s) belongs to the same stroke, which asks anew in each step.
const SAME_REFUSAL: f64 = 0.25;

impl Events {
    /// Adds an event at `time` (s). `text` is called only if the event is described.
    pub fn add(&mut self, kind: EventKind, time: f64, text: impl FnOnce() -> String) {
        self.add_many(kind, 1, time, text);
    }

    /// Adds `count` events of a kind with one description.
    pub fn add_many(&mut self, kind: EventKind, count: u64, time: f64, text: impl FnOnce() -> String) {
        if count == 0 {
            return;
        }
        *self.counts.entry(kind).or_default() += count;
        let descriptions = self.descriptions.entry(kind).or_default();
        if *descriptions >= if kind.is_refusal() { MAX_REFUSALS } else { MAX_DESCRIBED } {
            return;
        }
        let event = Event { time, text: text() };
        if kind.is_refusal() {
            let last = self.last_refusals.insert(kind, event.clone());
            if last.is_some_and(|last| last.text == event.text && time - last.time < SAME_REFUSAL) {
                return;
            }
        }
        *descriptions += 1;
        self.described.push((kind, event));
    }

    /// Adds the `count` events of a kind in a step, described once at the beginning of an episode. `ongoing` tells whether the last step had such events
    /// and is updated.
    pub(super) fn add_episode(
        &mut self,
        kind: EventKind,
        count: u64,
        ongoing: &mut bool,
        time: f64,
        text: impl FnOnce() -> String,
    ) {
        if *ongoing && count > 0 {
            *self.counts.entry(kind).or_default() += count;
        } else {
            self.add_many(kind, count, time, text);
        }
        *ongoing = count > 0;
    }

    /// Number of events of each kind.
    pub fn counts(&self) -> &BTreeMap<EventKind, u64> {
        &self.counts
    }

    /// The described events in order of time.
    pub fn described(&self) -> &[(EventKind, Event)] {
        &self.described
    }

    /// Number of events of a kind.
    pub fn count(&self, kind: EventKind) -> u64 {
        self.counts.get(&kind).copied().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The texts of a kind that are described, in order.
    fn texts(events: &Events, of: EventKind) -> Vec<&str> {
        events.described().iter().filter(|(kind, _)| *kind == of).map(|(_, event)| event.text.as_str()).collect()
    }

    #[test]
    fn every_refusal_is_described_once_a_stroke_and_the_first_of_all_else() {
        let mut events = Events::default();
        let kinds = [
            EventKind::CutRefused,
            EventKind::CutHeld,
            EventKind::CutAgain,
            EventKind::PaintRefused,
            EventKind::SplitRefused,
            EventKind::LayerRefused,
        ];
        for kind in kinds {
            for number in 0..20 {
                // As a stroke that is refused in each of its steps.
                for step in 0..50 {
                    events.add(kind, f64::from(number) + 0.01 * f64::from(step), || number.to_string());
                }
            }
            assert_eq!(events.count(kind), 1000);
            let expected: Vec<String> = (0..20).map(|number| number.to_string()).collect();
            assert_eq!(texts(&events, kind), expected);
        }
        for number in 0..20 {
            events.add(EventKind::Unstable, 0.0, || number.to_string());
        }
        assert_eq!(texts(&events, EventKind::Unstable), ["0", "1", "2", "3", "4", "5", "6", "7"]);
        // The same refusal in a later stroke is an answer of its own.
        events.add(EventKind::CutRefused, 100.0, || "19".into());
        assert_eq!(texts(&events, EventKind::CutRefused).len(), 21);
    }

    #[test]
    fn an_episode_is_described_at_its_beginning_however_long_the_ones_before_were() {
        let (mut events, mut ongoing) = (Events::default(), false);
        for episode in 0..3 {
            for step in 0..100 {
                events.add_episode(EventKind::SpeedLimit, 5, &mut ongoing, f64::from(step), || {
                    format!("{episode} at {step}")
                });
            }
            events.add_episode(EventKind::SpeedLimit, 0, &mut ongoing, 100.0, String::new);
        }
        assert_eq!(events.count(EventKind::SpeedLimit), 1500);
        assert_eq!(texts(&events, EventKind::SpeedLimit), ["0 at 0", "1 at 0", "2 at 0"]);
    }
}
