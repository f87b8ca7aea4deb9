//! An emulated hand exoskeleton, its *twin*: two moving fingers that render commands, behind an emulated network that loses, delays,
//! repeats and reorders datagrams.
//!
//! It has a clock of its own and speaks the protocol of the device. The parts are a library, so that tests can hand a twin one datagram
//! after the other; the program `pliant-twin-exoskeleton` adds the socket.

mod fingers;
mod network;
mod twin;

pub use fingers::{FingerPath, Fingers, HandModel};
pub use network::{Datagram, Impairments, InjectedCounts, Network};
pub use twin::{EndReason, ForceEnd, Limits, Twin, TwinCounts};
