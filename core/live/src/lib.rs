//! A session in real time: a hand that moves by itself, and feels at once.
//!
//! Three threads, none of which waits for another. The haptic thread runs at the rate of the devices: it reads them, renders
//! the last contacts the simulation told, and writes to them. The simulation steps after the wall clock. A viewer is shown a
//! picture sixty times a second. Between them go whole snapshots through triple buffers. A fourth thread, the watchdog, stops
//! the devices if the haptic thread is stuck.

mod deadline;
mod exchange;
mod footing;
mod haptic;
mod histogram;
mod picture;
mod pointer;
mod priority;
mod run;
mod servo;
mod summary;
mod thread;
mod watchdog;

pub use deadline::{Deadlines, Pacer};
pub use exchange::{Exchange, Models, Samples};
pub use footing::{Footing, Took};
pub use haptic::{Haptic, StopNow};
pub use histogram::{Histogram, Spread};
pub use picture::{Picture, Viewer};
pub use pointer::{Pointer, PointerHand};
pub use run::{Live, LiveSettings};
pub use servo::{Servo, servo};
pub use summary::{DeviceCounts, HandSummary, LiveSummary};
