//! A replacement of the driver library of a Phantom arm, for tests: it exports the functions that the plugin calls, and simulates the arm.
//!
//! It keeps the rules of the driver's public documents (frames, the error stack, when capabilities may be switched), counts violations
//! of them, and fails when a test asks for it. It was written from those documents, not from the plugin, and defines its constants anew.
#![allow(non_snake_case, reason = "the vendor's library is named HD")]

pub mod arm;
mod constants;
mod control;
mod hdapi;
pub mod kinematics;
mod scheduler;
mod state;
