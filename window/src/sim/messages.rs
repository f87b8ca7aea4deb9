//! What window and simulation tell each other.

use super::gauges::{Gauges, StepTimes};
use super::history::Stroke;
use crate::opening::ModelFacts;
use pliant_editor::DeviceHand;
use pliant_editor::surface::ViewSurface;
use pliant_engine::body::Model;
use pliant_engine::session::{SculptLayerState, SessionCommand, StiffnessState, Warning};
use pliant_engine::tool::Frame as DeviceFrame;
use pliant_live::{LiveSummary, PointerHandle, ViewReader};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::Sender;

/// What the window asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// A stroke begins; it is called this.
    BeginStroke(&'static str),
    /// The stroke has ended.
    EndStroke,
    /// Take the last stroke back.
    Undo,
    /// Make the stroke again that was taken back last.
    Redo,
    /// Take back or make again until this many strokes are there.
    JumpTo(usize),
    /// Change size, strength, falloff or symmetry of the brush by one of the session's commands on them: strokes that begin after it have it.
    ChangeBrush(SessionCommand),
    /// Give all bodies a stiffness; they get there without a jump of the force.
    SetStiffness {
        /// Factor of the stiffness they were opened with.
        factor: f64,
    },
    /// Change the sculpt layers by one of the session's commands on them.
    ChangeLayers(SessionCommand),
    /// Make parts of a body bodies of their own.
    Split {
        /// Index of the body among those that move.
        body: u32,
        /// A triangle of the part that leaves it; `None` if each part does.
        triangle: Option<u32>,
    },
    /// Write the model to a file, once no stroke is under way.
    Save {
        /// Path of the model or scene.
        path: PathBuf,
        /// Whether it is the user's file, and not one to open the present shape from.
        for_user: bool,
    },
    /// Say what shape the model has, once no stroke is under way.
    ReportShape,
    /// Write what was done by hand as a recording.
    SaveSession {
        /// Path of the recording.
        path: PathBuf,
    },
    /// Stop, and leave the live session to another simulation.
    HandOver,
    /// Stop.
    End,
}

/// A model that has just been opened.
pub struct OpenModel {
    /// What is known of it.
    pub facts: ModelFacts,
    /// Frames of the session.
    pub reader: ViewReader,
    /// Its surfaces as they were opened: bodies that move, then those that stand.
    pub surfaces: Vec<ViewSurface>,
    /// Their models, in the same order.
    pub models: Vec<Arc<Model>>,
    /// The hand of the pointer.
    pub hand: PointerHandle,
    /// A device that can have the hand, its scale and its name.
    pub device_hand: Option<DeviceHand>,
    /// Where the device of the hand is in the scene.
    pub device_frame: DeviceFrame,
    /// s, wall-clock time that opening took
    pub seconds: f64,
}

/// What the simulation says.
pub enum Notice {
    /// The model is open.
    Opened(Box<OpenModel>),
    /// It cannot be opened, or goes no further; a sentence why.
    Failed(String),
    /// The model was written.
    Saved {
        /// Path of the saved file.
        path: PathBuf,
        /// As asked for.
        for_user: bool,
        /// The shape that was written, as in [`Status::shape`].
        shape: u64,
        /// Sentences on materials and textures that an exported file lacks.
        problems: Vec<String>,
    },
    /// No stroke is under way, and the model has this shape, as in [`Status::shape`].
    Shape(u64),
    /// The model was not written; a sentence why.
    NotSaved(String),
    /// The device that was to have the hand cannot have it; a sentence why. The pointer has it.
    NoDevice(String),
    /// Something happened that people should know.
    Message(String),
    /// It has ended.
    Ended(Box<EndedRun>),
}

/// What a simulation that has ended leaves.
#[derive(Clone, Debug)]
pub struct EndedRun {
    /// How it kept time.
    pub live: LiveSummary,
    /// Wall-clock times of its steps.
    pub step: StepTimes,
}

/// The state of affairs, several times a second.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Status {
    /// How well it keeps time.
    pub gauges: Gauges,
    /// Strokes that are there, then those that were taken back, the next to make again first.
    pub strokes: Vec<Stroke>,
    /// How many of them are there, that of a stroke under way included.
    pub begun: usize,
    /// How many of those have ended.
    pub done: usize,
    /// The present shape: the number of the last stroke that has edited it, 0 as it was opened.
    pub shape: u64,
    /// Whether no stroke is under way and nothing moves.
    pub is_at_rest: bool,
    /// The stiffness over that at the opening, and where it goes.
    pub stiffness: StiffnessState,
    /// The sculpt layers, the lowest first.
    pub layers: Vec<SculptLayerState>,
    /// What has no effect, or not the one it looks like; of strokes, those that have ended.
    pub warnings: Vec<Warning>,
}

impl Status {
    /// Whether the window shows anything else of it than of `other`, but for gauges, which the window reads at its own times.
    pub(super) fn is_news_after(&self, other: &Self) -> bool {
        let others = Self { gauges: other.gauges, ..self.clone() };
        others != *other
    }
}

/// Sends notices and wakes the window.
pub(super) struct Notifier {
    pub(super) sender: Sender<Notice>,
    pub(super) wake: Box<dyn Fn() + Send>,
}

impl Notifier {
    pub(super) fn send(&self, notice: Notice) {
        // A window that has gone needs no notices.
        let _ = self.sender.send(notice);
        self.wake();
    }

    /// Asks the window to look at the status.
    pub(super) fn wake(&self) {
        (self.wake)();
    }
}
