//! The window of pliant: a model is opened, seen from all sides, and sculpted physically with a mouse.
//!
//! Three threads take part, and none waits for another. The *simulation* ([`sim`]) opens the model and steps it in real time; the haptic
//! thread of the live session moves the hand; the *window* ([`app`]) turns the pointer into a hand, and frames of the session into a
//! picture ([`gl`]). Frames come through a triple buffer, commands go through a queue that the simulation empties between two steps.
//!
//! This is a program of its own, started by `pliant edit`, so that `pliant` itself needs no graphics library.

pub mod app;
pub mod arguments;
pub mod drops;
pub mod gl;
pub mod materials;
pub mod opening;
pub mod picture;
pub mod recent;
pub mod reference;
pub mod sim;
pub mod strings;
pub mod stroke;
pub mod symmetry;
pub mod tools;
pub mod view;
