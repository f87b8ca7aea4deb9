//! Common parts of interactive editors: of a window, an extension of a modeler, and scripts.
//!
//! [`Draft`] makes a scene for a model, [`PointerStroke`] turns a pointer into a hand, and [`surface`] turns frames of a live session into a surface for
//! drawing and picking.
//!
//! This crate uses no window system and no graphics library, and prints nothing.

#![deny(clippy::wildcard_enum_match_arm)]

pub mod surface;

mod device;
mod device_hand;
mod draft;
mod hand;
mod hand_scene;
mod preset;
mod session_scene;
mod substance;
mod units;

pub use device::{DeviceChoice, DeviceRequest, device_choices};
pub use device_hand::{DeviceHand, DeviceHandState, DeviceView, DeviceWish, HandNews};
pub use draft::{BODY, Draft, DraftMaterial, TOOL_SHARE};
pub use hand::{Gesture, HandPlace, PointerRay, PointerStroke, StrokeStart, SurfacePoint};
pub use hand_scene::{
    HAND, HandSettings, HandStroke, MAX_PAINTED, PaintStroke, give_hand, hand_strokes, has_release, opposite_kind,
    stroke_button,
};
pub use preset::{PlasticFlow, SOLIDS, SolidPreset, fabrics, solid, stiffness_word};
pub use session_scene::SessionScene;
pub use substance::{Substance, SubstanceChoice};
pub use units::{LengthUnit, format_length};
