//! Sessions in real time with live hands.
//!
//! Three threads run without waiting for each other. The *haptic thread* runs at the rate of the devices: it reads them, renders the newest contact
//! models of the simulation, and writes the forces ([`Servo`]). The *simulation* steps in wall-clock time on the caller's thread ([`LiveSession`]). A
//! viewer reads sixty frames per second ([`ViewReader`], or a [`Viewer`] on its own thread). They exchange snapshots through triple buffers, of which only
//! the newest is read. A fourth thread, the watchdog, stops the devices if the haptic thread hangs.
//!
//! This crate knows neither scene files nor meshes nor plugins: a device is a [`HapticDevice`].
//!
//! # Example
//! A session in real time for ten seconds, moved by the program instead of a device:
//! ```no_run
//! use pliant_engine::session::Session;
//! use pliant_live::{LiveSession, LiveSettings, PointerDevice};
//!
//! # fn run(mut session: Session) -> std::io::Result<()> {
//! let (device, mut hand) = PointerDevice::new(session.devices[0].facts);
//! let settings = LiveSettings::default();
//! let mut live = LiveSession::start_with_devices(&mut session, vec![Box::new(device)], settings)?;
//! while live.is_alive() && live.seconds() < 10.0 {
//!     hand.move_to([0.0, 0.0, -1e-3 * live.seconds()].into(), 0);
//!     live.step(&mut session);
//!     println!("{:?} N", hand.force());
//! }
//! let summary = live.finish();
//! println!("{} of {} ticks missed", summary.missed, summary.ticks);
//! # Ok(())
//! # }
//! ```

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]
#![deny(clippy::wildcard_enum_match_arm)]

mod deadline;
mod device;
mod guided;
mod handover;
mod haptic_thread;
mod histogram;
mod pointer;
mod priority;
mod realtime;
mod servo;
mod servo_session;
mod servo_torque;
mod session;
mod snapshots;
mod summary;
mod thread;
mod view;
mod watchdog;

pub use device::{HapticDevice, StopDevice};
pub use guided::{DeviceScale, Guide, GuideHandle, GuidedDevice, GuidedHand, Rescaling};
pub use histogram::{Histogram, Percentiles};
pub use pointer::{PointerDevice, PointerHandle};
pub use realtime::{RealtimeStatus, ThreadUsage};
pub use servo::Servo;
pub use session::{LiveGauges, LiveSession, LiveSettings};
pub use snapshots::{DeviceLoss, HandSamples, SimulationPort};
pub use summary::{DeviceCounts, HandSummary, LiveSummary};
pub use view::{
    BladeEdgeView, BodyTopology, BodyView, ContactPoint, TopologyPatch, ViewFrame, ViewReader, ViewWriter, Viewer,
    ViewerThread, view_buffer,
};
