//! A stand-in for the hand exoskeleton: fingers, what they are told to feel, and a bad network.
//!
//! It keeps its own time and answers over the same datagrams as a device would. The parts are a library so that tests can hand
//! them datagrams one by one; the program puts a socket around them.

mod fingers;
mod network;
mod twin;

pub use fingers::{Fingers, Hand, Path};
pub use network::{Injected, Network, Weather};
pub use twin::{Ended, Limits, Twin, Zero};
