//! Edits: operations of a hand on bodies with a tool.
//!
//! An edit kind is one file: an [`EditKind`] has its name, its keys and its requirements, and begins an [`Action`], which acts on the bodies in
//! every step until the edit ends. A new kind is added by its file and its line in [`KINDS`]; scenes, plans, sessions, recordings and undo
//! use kinds through these traits alone.

mod brush;
mod carried_place;
mod cut;
mod flatten;
mod flow;
mod grab;
mod grip;
mod grow;
mod inflate;
mod key;
mod paint;
mod pin;
mod pinch;
mod pull;
mod region;
mod relax;
mod smooth;
mod stitch;
mod touch;
mod touch_by_law;
mod touch_stroke;

pub(crate) use brush::MIN_RADIUS_EDGES;
pub use brush::{Brush, BrushShape, Falloff};
pub use cut::{BladeEdge, CutAgain, CutStep, EdgeInside, HeldBody, STRIDE, SheetLayers};
pub(crate) use grip::GRIP_REACH;
pub use key::{DEFAULT_RADIUS, Key, KeyName, Strength};
pub(crate) use touch_stroke::INTERVAL as CHANGE_INTERVAL;

use crate::body::{Body, EmbeddedPoint, LatticeError};
use crate::plan::Edit;
use crate::tool::{Hand, Tool};
use pliant_solver::{StepTime, Vec3};
use std::fmt;

/// Every edit kind, in the order of the help text.
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
    &pin::PIN,
    &pin::UNPIN,
    &paint::Paint,
    &stitch::Stitch,
];

/// Name of the edit that undoes the last one.
pub const UNDO: &str = "undo";
/// Name of the edit that redoes the one undone last.
pub const REDO: &str = "redo";

/// Meaning of the key `kind` of an `[[edit]]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Command {
    /// An edit with a tool.
    Tool(&'static dyn EditKind),
    /// Undo the last edit.
    Undo,
    /// Redo the edit undone last.
    Redo,
}

impl Command {
    /// The command with this name; `None` if there is none.
    pub fn find(name: &str) -> Option<Self> {
        match name {
            UNDO => Some(Self::Undo),
            REDO => Some(Self::Redo),
            name => KINDS.iter().find(|kind| kind.name() == name).map(|kind| Self::Tool(*kind)),
        }
    }

    /// Every name with a one-sentence summary.
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
    /// Name in scene files.
    fn name(&self) -> &'static str;

    /// One-sentence summary, for help and the schema.
    fn summary(&self) -> &'static str;

    /// Keys of an `[[edit]]` that it reads besides those of every edit, with their defaults.
    fn keys(&self) -> &'static [Key] {
        &[]
    }

    /// Unit and default of the key `strength`; `None` if it does not read that key.
    fn strength(&self) -> Option<Strength> {
        None
    }

    /// Default of the key `param`; `None` if it does not read that key.
    fn param(&self) -> Option<&'static str> {
        None
    }

    /// Whether it cuts: its tool needs a `blade`, bodies keep a mesh that can be cut, and it can be undone even if its shape is not kept.
    fn cuts(&self) -> bool {
        false
    }

    /// Whether it grips a body and moves the gripped part with the hand.
    fn grips(&self) -> bool {
        false
    }

    /// Whether it rotates what it grips with the hand, so that the hand gets a torque.
    fn renders_torque(&self) -> bool {
        false
    }

    /// Whether it changes the rest shape, pins or parameters of a body while it is active. Such an edit can be undone, and the key `release` does not
    /// apply to it, because the elastic deformation by the tool always springs back.
    fn changes_body(&self) -> bool {
        false
    }

    /// Whether it changes the connectivity, as a cut does.
    fn changes_topology(&self) -> bool {
        self.cuts()
    }

    /// Whether it presses surfaces and changes nothing else, so that it should leave a visible dent; there is a warning if it does not.
    fn only_presses(&self) -> bool {
        false
    }

    /// The kind that does the opposite; `None` if there is none.
    fn opposite(&self) -> Option<&'static dyn EditKind> {
        None
    }

    /// Begins the edit with `tool` in a scene with `bodies` bodies.
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

/// Inputs of an action in a step.
pub struct Step<'a> {
    /// The hand that holds the tool.
    pub hand: &'a Hand,
    /// All bodies (b).
    pub bodies: &'a mut [Body],
    /// Largest displacement of a node of each body since the last step, m (b).
    pub moved: &'a [f64],
    /// Times of the step that follows.
    pub time: StepTime,
    /// Whether that step is explicit.
    pub is_explicit: bool,
}

/// Contact point of an action on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPoint {
    /// Index of the body.
    pub body: u32,
    /// Contact point in the rest shape, m.
    pub rest: Vec3,
}

/// A ball in the rest shape of a body in which cells must be simulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveBall {
    /// Index of the body.
    pub body: u32,
    /// Centre in the rest shape, m.
    pub centre: Vec3,
    /// Radius added to that of the body's settings, m.
    pub extra_radius: f64,
}

/// A request to tie the body that a tool touches to those that face it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StitchRequest {
    /// Surface point of a body that the tool touches.
    pub at: BodyPoint,
    /// Radius around it within which points are tied, m.
    pub radius: f64,
}

/// An active edit with one tool.
///
/// In every step [`Action::cut`] is called first, then [`Action::active_ball`], then [`Action::follow`]; then the bodies move.
pub trait Action: Send {
    /// Its contact point; `None` without contact.
    fn contact(&self, tool: &Tool) -> Option<BodyPoint> {
        tool.proxy.touch.map(|touch| BodyPoint { body: touch.body, rest: touch.rest })
    }

    /// The ball whose cells must be simulated for it; `None` without contact.
    fn active_ball(&self, tool: &Tool) -> Option<ActiveBall> {
        self.contact(tool).map(|at| ActiveBall { body: at.body, centre: at.rest, extra_radius: 0.0 })
    }

    /// What of a blade is in a body; `None` for what has no blade, or none in a body.
    fn edge_inside(&self) -> Option<EdgeInside> {
        None
    }

    /// Radius of the soft region around its contact on a body with this cell edge, both in m; it enlarges the simulated ball.
    fn extra_region_radius(&self, _edge: f64) -> f64 {
        0.0
    }

    /// Whether it grips a body now.
    fn is_gripping(&self) -> bool {
        false
    }

    /// Whether it rotates the gripped region with the hand, so that the device gets a torque.
    fn renders_torque(&self) -> bool {
        false
    }

    /// Whether its tool is in contact with sheets as a fingertip, by constraints or as a soft tip.
    fn is_fingertip(&self) -> bool {
        false
    }

    /// What it asks to be tied in this step, before it cuts.
    fn stitch_request(&self, _bodies: &[Body]) -> Option<StitchRequest> {
        None
    }

    /// Cuts meshes before bodies move; `last` is set if the edit ends with this step.
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    fn cut(&mut self, _tool: &Tool, _hand: &Hand, _bodies: &mut [Body], _last: bool) -> Result<CutStep, LatticeError> {
        Ok(CutStep::default())
    }

    /// Follows the hand: sets the position of the tool's proxy and the loads of the tool on the bodies. `contact` is the embedded position of
    /// [`Action::contact`].
    ///
    /// # Errors
    /// Returns the error of the grid or material plugin.
    fn follow(
        &mut self,
        tool: &mut Tool,
        step: &mut Step<'_>,
        contact: Option<EmbeddedPoint>,
    ) -> Result<(), LatticeError>;

    /// Ends all contacts and grips, as when the hand is absent.
    fn release(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_opposite_of_the_opposite_of_a_kind_is_the_kind() {
        let pairs = KINDS.iter().filter_map(|kind| Some((*kind, kind.opposite()?)));
        assert!(pairs.clone().all(|(kind, opposite)| opposite.opposite() == Some(kind) && opposite != kind));
        assert_eq!(pairs.count(), 6);
    }
}
