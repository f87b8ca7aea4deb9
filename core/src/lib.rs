//! The engine behind `pliant`.
//!
//! Data goes one way: a scene is parsed, planned, opened as a session and stepped;
//! every step gives a frame. See `ARCHITECTURE.md` at the root of the repository.

pub mod host;
pub mod mesh;
pub mod step;
