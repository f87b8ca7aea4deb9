//! An editing session for a user interface: what a window, a modeler's extension and a script share.
//!
//! A model without a scene becomes one ([`Draft`]); a pointer becomes a hand ([`PointerStroke`]); frames of the live session become
//! a surface that can be drawn and pointed at ([`surface`]).
//!
//! This crate knows no window system and no graphics library, and prints nothing.

pub mod surface;

mod draft;
mod hand;
mod hand_scene;
mod preset;
mod substance;
mod units;

pub use draft::{BODY, Draft, DraftMaterial, HAND, MIRROR, TOOL_SHARE};
pub use hand::{Gesture, HandPlace, PointerRay, PointerStroke, StrokeStart, SurfacePoint};
pub use hand_scene::{HandSettings, give_hand, stroke_button, stroke_kinds};
pub use preset::{PlasticFlow, SOLIDS, SolidPreset, fabrics, solid, stiffness_word};
pub use substance::{Substance, SubstanceChoice};
pub use units::{LengthUnit, format_length};
