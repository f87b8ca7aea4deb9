//! A session in real time: hands that move by themselves and feel at once.
//!
//! Three threads, none of which waits for another. The *haptic thread* runs at the rate of the devices: it reads them, renders
//! the newest contacts the simulation has published, and writes to them ([`Servo`]). The *simulation* steps after the wall clock on the
//! caller's thread ([`LiveSession`]). A [`Viewer`] is shown sixty frames a second. Whole snapshots go between them through triple
//! buffers, the newest wins. A fourth thread, the watchdog, stops the devices if the haptic thread is stuck.
//!
//! This crate knows no scene files, no meshes and no plugins: a device is anything that is a [`HapticDevice`].
//!
//! # Example
//! The arithmetic of deadlines, which takes its time from the caller: a tick that ends 3.2 periods late misses three.
//! ```
//! use pliant_live::Deadlines;
//! let mut deadlines = Deadlines::new(0, 1000.0); // 1 kHz from 0 ns on
//! deadlines.finish_tick(3_200_000);
//! assert_eq!((deadlines.missed, deadlines.due()), (3, 4_000_000));
//! ```
//! An opened session in real time, for ten seconds:
//! ```no_run
//! use pliant_engine::session::Session;
//! use pliant_live::{LiveSession, LiveSettings};
//!
//! # fn run(mut session: Session) -> std::io::Result<()> {
//! let mut live = LiveSession::start(&mut session, LiveSettings::default())?;
//! while live.is_alive() && live.seconds() < 10.0 {
//!     live.step(&mut session);
//! }
//! let summary = live.finish();
//! println!("{} of {} ticks missed", summary.missed, summary.ticks);
//! # Ok(())
//! # }
//! ```

mod deadline;
mod device;
mod haptic_thread;
mod histogram;
mod pointer;
mod priority;
mod realtime;
mod servo;
mod session;
mod snapshots;
mod summary;
mod viewer;
mod watchdog;

pub use deadline::{Deadlines, Pacer};
pub use device::{HapticDevice, StopDevice};
pub use histogram::{Histogram, Percentiles};
pub use pointer::{PointerDevice, PointerHandle};
pub use realtime::{RealtimeStatus, ThreadUsage};
pub use servo::Servo;
pub use session::{LiveSession, LiveSettings};
pub use snapshots::{ContactModels, DeviceLoss, HandSamples, SimulationPort};
pub use summary::{DeviceCounts, HandSummary, LiveSummary};
pub use viewer::{ViewFrame, Viewer};
