//! How long a person waits: from the start of the program to the model on screen, and from the pointer to the picture.
//!
//! A picture is on screen once the window library has handed it over, which the window knows when its next frame begins: every figure here is up to that
//! moment, and so an upper bound.

use crate::sim::StepTimes;
use nalgebra::Vector3;
use std::time::{Duration, Instant};

/// What happens once, from the start of the program on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum StartStage {
    /// There is a window with a context for drawing.
    Window,
    /// The first picture is on screen, without a model.
    FirstFrame,
    /// The model is open.
    Opened,
    /// The model is on screen.
    ModelShown,
}

/// All stages, in their order.
pub const START_STAGES: [StartStage; 4] =
    [StartStage::Window, StartStage::FirstFrame, StartStage::Opened, StartStage::ModelShown];

/// Times of the stages of the start.
#[derive(Clone, Debug)]
pub struct StartTimes {
    began: Instant,
    reached: [Option<Duration>; START_STAGES.len()],
}

impl StartTimes {
    /// Of a program that began then.
    pub fn since(began: Instant) -> Self {
        Self { began, reached: [None; START_STAGES.len()] }
    }

    /// A stage is reached; its first time counts. Returns whether this is it.
    pub fn reach(&mut self, stage: StartStage) -> bool {
        let slot = &mut self.reached[stage as usize];
        let is_first = slot.is_none();
        slot.get_or_insert(self.began.elapsed());
        is_first
    }

    /// s, from the start of the program; `None` before the stage is reached
    pub fn of(&self, stage: StartStage) -> Option<f64> {
        self.reached[stage as usize].map(|time| time.as_secs_f64())
    }
}

/// What a person waits for at the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Awaited {
    /// The hand, which was at rest here (m), leaves.
    Motion { from: Vector3<f64> },
    /// The tool touches or grips, after the button was pressed.
    Contact,
}

/// Something that was done with the pointer and is not on screen yet.
#[derive(Clone, Copy, Debug)]
struct Pending {
    awaited: Awaited,
    /// Number of the frame that took it in.
    frame: u64,
    /// s, when that frame began
    time: f64,
    /// Number of the first frame whose picture shows the effect.
    shown: Option<u64>,
}

/// The hand as a frame of the simulation shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenHand {
    /// Position, m.
    pub position: Vector3<f64>,
    /// Whether the tool touches or grips a body.
    pub is_in_contact: bool,
}

/// Frames and times from what the pointer does to the picture that shows it. The frame that takes an event in is the first; one whose picture has the
/// effect at once would be 1, and the next one is 2.
#[derive(Clone, Debug, Default)]
pub struct PointerLatency {
    frame: u64,
    time: f64,
    seen: Option<SeenHand>,
    /// Where the hand was sent last, m.
    sent: Option<Vector3<f64>>,
    pending: [Option<Pending>; 2],
    motions: LatencyList,
    contacts: LatencyList,
}

/// Latencies of one kind.
#[derive(Clone, Debug, Default)]
struct LatencyList {
    frames: Vec<f64>,
    seconds: Vec<f64>,
}

/// Summary of latencies of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Latency {
    /// Frames, as [`PointerLatency`] counts them.
    pub frames: StepTimes,
    /// s, from the beginning of the frame that took the event in until the picture was on screen
    pub seconds: StepTimes,
}

/// Latencies that are kept.
const REMEMBERED: usize = 1000;
/// Radii of the tool by which a hand at rest is off its place at most, and by which it has left it.
const AT_REST: f64 = 0.02;

impl LatencyList {
    fn add(&mut self, frames: u64, seconds: f64) {
        if self.frames.len() >= REMEMBERED {
            self.frames.drain(..REMEMBERED / 2);
            self.seconds.drain(..REMEMBERED / 2);
        }
        self.frames.push(frames as f64);
        self.seconds.push(seconds);
    }

    fn summary(&self) -> Latency {
        Latency { frames: StepTimes::of(&mut self.frames.clone()), seconds: StepTimes::of(&mut self.seconds.clone()) }
    }
}

impl PointerLatency {
    /// A frame begins at `time` (s) that shows the hand where the newest frame of the simulation has it. `radius`: that of the tool, m.
    pub fn begin_frame(&mut self, time: f64, seen: Option<SeenHand>, radius: f64) {
        (self.frame, self.time, self.seen) = (self.frame + 1, time, seen);
        for pending in &mut self.pending {
            let Some(waiting) = pending else { continue };
            match (waiting.shown, seen) {
                // The picture before this frame is on screen.
                (Some(shown), _) => {
                    let list = match waiting.awaited {
                        Awaited::Motion { .. } => &mut self.motions,
                        Awaited::Contact => &mut self.contacts,
                    };
                    list.add(shown - waiting.frame + 1, time - waiting.time);
                    *pending = None;
                }
                (None, Some(seen)) if waiting.awaited.is_shown(&seen, radius) => waiting.shown = Some(self.frame),
                (None, Some(_)) => {}
                (None, None) => *pending = None,
            }
        }
    }

    /// The hand was sent to a place (m). It counts in a stroke, where the hand was at rest before: on its way from one place to the next nobody can say which
    /// of them is seen.
    pub fn send(&mut self, to: Vector3<f64>, radius: f64, in_stroke: bool) {
        let before = self.sent.replace(to);
        let is_free = in_stroke && self.pending[0].is_none();
        if let (true, Some(before), Some(seen)) = (is_free, before, self.seen)
            && (seen.position - before).norm() < AT_REST * radius
            && (to - before).norm() > 4.0 * AT_REST * radius
        {
            self.wait_for(0, Awaited::Motion { from: seen.position });
        }
    }

    /// A stroke begins with a press of the button.
    pub fn press(&mut self) {
        if self.seen.is_some_and(|seen| !seen.is_in_contact) {
            self.wait_for(1, Awaited::Contact);
        }
    }

    /// The stroke is over; one that has met nothing is not waited for.
    pub fn release(&mut self) {
        self.pending[1] = self.pending[1].filter(|pending| pending.shown.is_some());
    }

    fn wait_for(&mut self, slot: usize, awaited: Awaited) {
        self.pending[slot] = Some(Pending { awaited, frame: self.frame, time: self.time, shown: None });
    }

    /// Whether a frame is to follow at once, so that the time at which a picture was on screen is known.
    pub fn is_waiting(&self) -> bool {
        self.pending.iter().flatten().any(|pending| pending.shown.is_some())
    }

    /// From a motion of the pointer at rest to the picture in which the hand has left its place.
    pub fn motions(&self) -> Latency {
        self.motions.summary()
    }

    /// From the press of the button to the picture in which the tool touches or grips.
    pub fn contacts(&self) -> Latency {
        self.contacts.summary()
    }
}

impl Awaited {
    fn is_shown(&self, seen: &SeenHand, radius: f64) -> bool {
        match self {
            Awaited::Motion { from } => (seen.position - from).norm() > AT_REST * radius,
            Awaited::Contact => seen.is_in_contact,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RADIUS: f64 = 0.005;

    fn at(x: f64, is_in_contact: bool) -> Option<SeenHand> {
        Some(SeenHand { position: Vector3::new(x, 0.0, 0.0), is_in_contact })
    }

    /// Frames of 16 ms; the simulation shows a motion `delay` frames after the frame that sent it.
    fn latency_of(delay: usize) -> PointerLatency {
        let mut latency = PointerLatency::default();
        let mut sent = vec![0.0; 10];
        for frame in 0..200 {
            let shown = sent[sent.len() - delay];
            latency.begin_frame(0.016 * f64::from(frame), at(shown, false), RADIUS);
            // Rests for nine frames, and moves in the tenth.
            let to = f64::from(frame / 10) * 2.0 * RADIUS;
            latency.send(Vector3::new(to, 0.0, 0.0), RADIUS, true);
            sent.push(to);
        }
        latency
    }

    #[test]
    fn a_motion_is_counted_from_the_frame_that_took_it_in_to_the_one_that_shows_it() {
        for delay in 1..6 {
            let motions = latency_of(delay).motions();
            assert!(motions.frames.count >= 18, "{motions:?}");
            let frames = delay as f64 + 1.0;
            assert_eq!([motions.frames.median, motions.frames.p99], [frames; 2]);
            // On screen when the frame after it begins.
            let seconds = 0.016 * frames;
            assert!((motions.seconds.median - seconds).abs() < 1e-12, "{delay}: {motions:?}");
        }
    }

    #[test]
    fn a_hand_on_its_way_is_not_counted() {
        let mut latency = PointerLatency::default();
        for frame in 0..100 {
            let x = f64::from(frame) * RADIUS;
            latency.begin_frame(0.016 * f64::from(frame), at(x - 2.0 * RADIUS, false), RADIUS);
            latency.send(Vector3::new(x, 0.0, 0.0), RADIUS, true);
        }
        assert_eq!(latency.motions().frames.count, 0);
    }

    #[test]
    fn a_press_is_counted_until_the_tool_touches_and_one_that_meets_nothing_is_not() {
        let mut latency = PointerLatency::default();
        let frame = |latency: &mut PointerLatency, is_in_contact| {
            latency.begin_frame(latency.time + 0.01, at(0.0, is_in_contact), RADIUS);
        };
        frame(&mut latency, false);
        latency.press();
        frame(&mut latency, false);
        frame(&mut latency, true);
        assert!(latency.is_waiting());
        frame(&mut latency, true);
        let contacts = latency.contacts();
        assert_eq!((contacts.frames.count, contacts.frames.median), (1, 3.0));
        assert!((contacts.seconds.median - 0.03).abs() < 1e-12);
        // Pressed while it touches: there is nothing to see begin.
        latency.press();
        frame(&mut latency, true);
        frame(&mut latency, false);
        latency.press();
        frame(&mut latency, false);
        latency.release();
        frame(&mut latency, true);
        frame(&mut latency, true);
        assert_eq!(latency.contacts().frames.count, 1);
    }

    #[test]
    fn a_stage_is_reached_once() {
        let mut times = StartTimes::since(Instant::now());
        assert_eq!(times.of(StartStage::Opened), None);
        assert!(times.reach(StartStage::Window) && times.reach(StartStage::Opened));
        let first = times.of(StartStage::Opened);
        std::thread::sleep(Duration::from_millis(2));
        assert!(!times.reach(StartStage::Opened));
        assert_eq!(times.of(StartStage::Opened), first);
        assert!(times.of(StartStage::Window) <= first);
    }
}
