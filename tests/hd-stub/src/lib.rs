//! A stand-in for the driver library of a Phantom arm: the functions the plugin calls, with a simulated arm behind them.
//!
//! It keeps the rules of the real one as its public documents tell them (frames, the error stack, who may switch what when),
//! says what is done against them, and fails on demand. It was written from those documents, not from the plugin.
#![allow(non_snake_case, reason = "the library of the vendor is called so")]

pub mod arm;
pub mod kinematics;
mod stub;
