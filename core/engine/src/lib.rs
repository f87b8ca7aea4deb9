//! The engine behind `pliant`.
//!
//! Data goes one way: a scene is parsed, planned, opened as a session and stepped;
//! every step gives a frame. See `ARCHITECTURE.md` at the root of the repository.

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
