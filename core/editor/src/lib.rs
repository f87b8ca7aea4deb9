//! Common parts of interactive editors: of a window, an extension of a modeler, and scripts.
//!
//! [`Draft`] makes a scene for a model without one, [`SOLIDS`] and [`fabrics`] are presets of materials, [`PointerStroke`] turns a pointer
//! into a hand, [`DeviceHand`] gives a haptic device the hand of a session, [`SessionScene`] writes a session as a scene, and [`surface`]
//! turns frames of a live session into a surface for drawing and picking.
//!
//! This crate uses no window system and no graphics library, and prints nothing.
//!
//! # Example
//! A draft for a model of jelly, as a scene that the engine reads:
//! ```
//! use pliant_editor::{BODY, Draft, DraftMaterial, TOOL_SHARE, solid};
//! use pliant_engine::scene::load_text;
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let preset = *solid("jelly").ok_or("no such preset")?;
//! let draft = Draft {
//!     mesh: "/models/hare.obj".into(),
//!     scale: 0.001,
//!     size: 0.1,
//!     subdivide: false,
//!     weld: None,
//!     material: DraftMaterial::Solid { plugin: "neo-hookean".into(), preset, level: 5 },
//!     dt: 1e-3,
//! };
//! let text = draft.to_toml(Path::new("/models"));
//! assert!(text.contains("mesh = \"hare.obj\""), "relative to the folder of the scene");
//!
//! let (scene, _) = load_text(Path::new("/models/hare.toml"), text, &[])?;
//! assert_eq!(scene.body[0].name.get_ref(), BODY);
//! // A tool of 4 % of the model's size, and a coupling twice as stiff as a ball of that radius pressed into a half-space, 2 E r.
//! let radius = TOOL_SHARE * 0.1; // m
//! assert_eq!(scene.tool[0].radius.as_ref().map(|r| r.get_ref().si), Some(radius));
//! assert!((draft.coupling() - 4.0 * preset.young * radius).abs() < 1e-9);
//! # Ok(())
//! # }
//! ```

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
    HAND, HandSettings, HandStroke, MAX_PAINTED, PaintStroke, device_button, give_hand, hand_strokes, has_release,
    opposite_kind, stroke_button,
};
pub use preset::{PlasticFlow, SOLIDS, SolidPreset, fabrics, solid, stiffness_word};
pub use session_scene::SessionScene;
pub use substance::{Substance, SubstanceChoice};
pub use units::{LengthUnit, format_length};
