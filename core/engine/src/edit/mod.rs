//! Edits: what a hand does to bodies with a tool.
//!
//! An edit kind is one file: an [`EditKind`] says how scenes write it, what it needs and what it is for, and begins an [`Action`],
//! which acts on the bodies in every step until the edit ends. A new kind is added by its file and its line in [`KINDS`];
//! scenes, plans, sessions, recordings and undo know kinds through these traits alone.

mod brush;
mod cut;
mod flatten;
mod flow;
mod grab;
mod grip;
mod grow;
mod inflate;
mod key;
mod pinch;
mod pull;
mod region;
mod relax;
mod smooth;
mod touch;

pub use brush::{Brush, BrushShape, Falloff};
pub use cut::{BladeEdge, CutStep};
pub(crate) use grip::GRIP_REACH;
pub use key::{Key, KeyName, Strength};

use crate::body::{Body, LatticeError};
use crate::plan::Edit;
use crate::tool::{Hand, Tool};
use pliant_solver::{StepTime, Vec3};
use std::fmt;

/// Every edit kind, in the order help lists them.
pub static KINDS: &[&dyn EditKind] = &[
    &touch::Touch,
    &pull::Pull,
    &cut::Cut,
    &grab::Grab,
    &inflate::INFLATE,
    &inflate::DEFLATE,
    &smooth::Smooth,
    &flatten::Flatten,
    &pinch::Pinch,
    &relax::Relax,
    &grow::GROW,
    &grow::SHRINK,
];

/// The name of the edit that takes the last edit back.
pub const UNDO: &str = "undo";
/// The name of the edit that makes again what was taken back last.
pub const REDO: &str = "redo";

/// What a scene's `kind` stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// Something done with a tool.
    Tool(&'static dyn EditKind),
    /// Take the last edit back.
    Undo,
    /// Make again what was taken back last.
    Redo,
}

impl Command {
    /// The command of a name, if there is one.
    pub fn find(name: &str) -> Option<Self> {
        match name {
            UNDO => Some(Self::Undo),
            REDO => Some(Self::Redo),
            name => KINDS.iter().find(|kind| kind.name() == name).map(|kind| Self::Tool(*kind)),
        }
    }

    /// Every name with a sentence of what it does.
    pub fn names() -> impl Iterator<Item = (&'static str, &'static str)> {
        let history = [
            (UNDO, "Take back the last edit that changed a shape for good: a cut, or one whose shape was kept."),
            (REDO, "Make again what was taken back last."),
        ];
        KINDS.iter().map(|kind| (kind.name(), kind.summary())).chain(history)
    }
}

/// A kind of edit.
pub trait EditKind: Sync {
    /// As scenes write it.
    fn name(&self) -> &'static str;

    /// One sentence on what it does, for help and the schema.
    fn summary(&self) -> &'static str;

    /// Keys of an `[[edit]]` that it reads besides those every edit has, with their defaults.
    fn keys(&self) -> &'static [Key] {
        &[]
    }

    /// What the key `strength` measures, if it reads it.
    fn strength(&self) -> Option<Strength> {
        None
    }

    /// Whether it cuts: its tool needs a `blade`, bodies keep a mesh that can be cut, and undo takes it back even if no shape is kept.
    fn cuts(&self) -> bool {
        false
    }

    /// Whether it takes hold of a body and moves what it holds with the hand.
    fn takes_hold(&self) -> bool {
        false
    }

    /// Whether it changes the shape at rest while it is under way: undo takes it back, and `release` says nothing, as what it presses
    /// always springs back.
    fn reshapes(&self) -> bool {
        false
    }

    /// Begins the edit with `tool`, in a scene of `bodies` bodies.
    fn begin(&self, edit: &Edit, tool: &Tool, bodies: usize) -> Box<dyn Action>;
}

impl fmt::Debug for dyn EditKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl PartialEq for dyn EditKind {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

/// What an action acts on in a step.
pub struct Step<'a> {
    /// The hand that holds the tool.
    pub hand: &'a Hand,
    /// Bodies that move.
    pub bodies: &'a mut [Body],
    /// m, how far nodes of each body may have moved since the last step
    pub moved: &'a [f64],
    /// The step that follows.
    pub time: StepTime,
}

/// Where an action is on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPlace {
    /// Index of the body.
    pub body: u32,
    /// m, the place in the rest shape
    pub rest: Vec3,
}

/// A ball of rest places around which cells must be simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveBall {
    /// Index of the body.
    pub body: u32,
    /// m, in the rest shape
    pub centre: Vec3,
    /// m, added to the radius that the body's own settings give
    pub extra_radius: f64,
}

/// An edit under way with one tool.
///
/// In every step [`Action::cut`] comes first, then [`Action::active_ball`], then [`Action::follow`]; bodies move after that.
pub trait Action: Send {
    /// Where it is in contact.
    fn contact(&self, tool: &Tool) -> Option<ContactPlace> {
        tool.proxy.touch.map(|touch| ContactPlace { body: touch.body, rest: touch.rest })
    }

    /// Cells that must be simulated for it; `None` while it is in contact with nothing.
    fn active_ball(&self, tool: &Tool) -> Option<ActiveBall> {
        self.contact(tool).map(|at| ActiveBall { body: at.body, centre: at.rest, extra_radius: 0.0 })
    }

    /// m, of what it acts on around its contact on a body whose cells have this edge (m): as much more must be simulated.
    fn extra_radius(&self, _edge: f64) -> f64 {
        0.0
    }

    /// Whether it holds on to a body.
    fn holds(&self) -> bool {
        false
    }

    /// Whether it turns what it acts on with the hand, and so gives a torque back.
    fn turns(&self) -> bool {
        false
    }

    /// Whether its tool meets sheets as a fingertip does: as a contact constraint or a soft tip.
    fn is_fingertip(&self) -> bool {
        false
    }

    /// Changes meshes before bodies move; `last` when the edit ends with this step.
    ///
    /// # Errors
    /// What grid or material say.
    fn cut(&mut self, _tool: &Tool, _hand: &Hand, _bodies: &mut [Body], _last: bool) -> Result<CutStep, LatticeError> {
        Ok(CutStep::default())
    }

    /// Follows the hand: places the tool's proxy and sets the loads of the tool on the bodies. `contact` tells where the nodes carry
    /// the place of [`Action::contact`].
    ///
    /// # Errors
    /// What grid or material say.
    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPlace>,
    ) -> Result<(), LatticeError>;

    /// Lets go of everything, as when the hand is gone.
    fn release(&mut self) {}
}

/// Where nodes carry a rest place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmbeddedPlace {
    /// m, now
    pub now: Vec3,
    /// m, when all nodes are at rest
    pub settled: Vec3,
}
