//! Scenes, plans, bodies, contact, tools and sessions: what a program embeds to edit shapes by touch.
//!
//! Data goes one way: text becomes a [`Scene`](scene::Scene), which says what there is; a [`Plan`](plan::Plan), which says what of it is
//! needed, what is left out and why; a [`Session`](session::Session), which is opened from both and stepped; and after every step a
//! [`Frame`](session::Frame), which holds positions, forces and energies. Inside a step [`tool`]s find their [`contact`]s, [`edit`]s act on
//! [`body`]s, and the crate `pliant-solver` moves them. `ARCHITECTURE.md` at the root of the repository lists the modules.
//!
//! This crate knows no window, no wall clock and no haptic thread (`pliant-live`), names no plugin, prints nothing and writes no files.
//!
//! # Example
//! A scene is read and planned without opening a plugin. Gravity on a block of foam that is simulated as a whole makes it a moving body;
//! probes and tools are not asked for, so nothing of them is opened:
//! ```
//! use pliant_engine::plan::Plan;
//! use pliant_engine::scene::load_text;
//! use std::path::Path;
//!
//! # fn main() -> Result<(), pliant_engine::scene::SceneError> {
//! let text = r#"
//! format = 1
//! gravity = [0, 0, -9.81]
//!
//! [[body]]
//! name = "block"
//! mesh = "block.obj"
//! size = "60 mm"
//! grid = { region = "whole" }
//! material = { plugin = "neo-hookean", params = { young = "20 kPa" } }
//! "#;
//! let (scene, source) = load_text(Path::new("block.toml"), text.into(), &[])?;
//! let plan = Plan::new(&scene, &source)?;
//! assert_eq!(plan.moving, [true]);
//! assert_eq!(plan.gravity.z, -9.81); // m/s^2
//! assert!(plan.tools.is_empty() && plan.probes.is_empty());
//!
//! // An error names the file, the line and what is allowed.
//! let error = load_text(Path::new("block.toml"), text.replace("format = 1", "format = 2"), &[]).unwrap_err();
//! assert!(error.to_string().starts_with("block.toml:2:"));
//! # Ok(())
//! # }
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]
#![deny(clippy::wildcard_enum_match_arm)]

pub mod body;
pub mod contact;
pub mod edit;
pub mod memory;
pub mod obstacle;
pub mod plan;
pub mod probe;
pub mod recording;
pub mod scene;
pub mod session;
pub mod shape;
pub mod tool;
