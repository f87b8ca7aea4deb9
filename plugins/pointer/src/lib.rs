//! A device driven by lines of text over UDP, from any program.
//!
//! A datagram is `x y z` or `x y z mask`: a position in m, device axes (x right, y up, z towards the user), and a button mask. The last one
//! to arrive counts. Each write answers the last sender with `fx fy fz`, the force in N. By default it listens on the loopback
//! interface.

#![cfg_attr(not(test), deny(clippy::disallowed_methods))]

mod text;

use core::ffi::CStr;
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, Pose};
use pliant_plugin_api::{AsDevice, Device, Fault, Finding, Info, Param, Params, export_plugins};
use std::io::ErrorKind;
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The default address.
const ADDRESS: &str = "127.0.0.1:48630";

const PARAMS: &[Param] = &[
    Param::text(c"address", c"address and port it listens on; default: 127.0.0.1:48630"),
    Param::number(c"hold", c"s", 0.01..=3600.0, 0.5, c"time for which a position is valid without a new one"),
    Param::number(c"reach", c"m", 1e-3..=100.0, 0.1, c"half the edge of its workspace"),
    Param::number(c"peak-force", c"N", 1e-3..=1e4, 3.3, c"peak force it declares and sends"),
    Param::number(c"stiffness", c"N/m", 1e-3..=1e6, 700.0, c"largest stable stiffness it declares"),
];

/// A position and buttons, and when they arrived.
#[derive(Clone, Copy)]
struct Sample {
    /// Position, m, device axes.
    position: [f64; 3],
    /// Pressed buttons: button i is bit i.
    buttons: u32,
    /// Time of arrival.
    received: Instant,
}

/// The last valid datagram.
struct Latest {
    /// Its content; `None` before the first.
    sample: Option<Sample>,
    /// Its sender, to whom forces are sent.
    sender: Option<SocketAddr>,
}

/// A hand that datagrams of text move.
pub struct Pointer {
    /// Non-blocking UDP socket, by which samples are received and forces sent.
    socket: UdpSocket,
    /// Limits that it declares.
    info: DeviceInfo,
    /// Time for which a sample is valid.
    hold: Duration,
    /// The last valid datagram.
    latest: Mutex<Latest>,
    /// Rendered force, N, as bits of f64.
    force: [AtomicU64; 3],
    /// Time at which the force expires, ns on the host's clock.
    valid_until_ns: AtomicU64,
    /// Number of datagrams accepted.
    accepted: AtomicU64,
    /// Number of datagrams that could not be parsed.
    rejected: AtomicU64,
}

/// The most datagrams one read receives, so that a flood cannot hold up the servo loop.
const MAX_DATAGRAMS: usize = 256;

impl Pointer {
    /// The address it listens on.
    pub fn address(&self) -> Option<SocketAddr> {
        self.socket.local_addr().ok()
    }

    /// The lock is free in a servo loop: `read` and `write` are called one at a time, and nothing else takes it.
    fn latest(&self) -> MutexGuard<'_, Latest> {
        self.latest.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stores the rendered force (N) and the time at which it expires (ns).
    fn set_force(&self, force: [f64; 3], valid_until_ns: u64) {
        self.force.iter().zip(force).for_each(|(bits, f)| bits.store(f.to_bits(), Ordering::Relaxed));
        self.valid_until_ns.store(valid_until_ns, Ordering::Relaxed);
    }
}

/// A non-blocking socket on the parameter `address`.
fn bind(params: &Params<'_>) -> Result<UdpSocket, Fault> {
    let given = params.text("address").unwrap_or(ADDRESS);
    let found = given.to_socket_addrs().ok().and_then(|mut all| all.next());
    let wrong = || Fault::bad_argument(format!("`address` is `{given}`; allowed is ADDRESS:PORT, as {ADDRESS}"));
    let address = found.ok_or_else(wrong)?;
    let socket = UdpSocket::bind(address).map_err(|e| Fault::io(format!("{address}: {e}")))?;
    socket.set_nonblocking(true).map_err(|e| Fault::io(e.to_string()))?;
    Ok(socket)
}

impl Device for Pointer {
    const INFO: Info = Info {
        id: c"pointer",
        name: c"Pointer",
        version: c"0.1.0",
        summary: c"a device driven by lines of text over UDP",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let (reach, peak) = (params.number("reach"), params.number("peak-force"));
        let info = DeviceInfo {
            size: size_of::<DeviceInfo>(),
            effectors: 1,
            buttons: 32,
            driven_axes: 0,
            taxel_rows: 0,
            taxel_columns: 0,
            rate: 1000.0,
            peak_force: peak,
            continuous_force: peak,
            stiffness: params.number("stiffness"),
            damping: 5.0,
            resolution: 0.0,
            workspace: [-reach, -reach, -reach, reach, reach, reach],
            taxel_pitch: 0.0,
            taxel_force: 0.0,
            peak_torque: 0.0,
        };
        Ok(Self {
            socket: bind(params)?,
            info,
            hold: Duration::from_secs_f64(params.number("hold")),
            latest: Mutex::new(Latest { sample: None, sender: None }),
            force: Default::default(),
            valid_until_ns: AtomicU64::new(0),
            accepted: AtomicU64::new(0),
            rejected: AtomicU64::new(0),
        })
    }

    fn describe(&self) -> DeviceInfo {
        self.info
    }

    fn read(&self, time_ns: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let latest = &mut *self.latest();
        // One byte more than the longest line, so that a longer datagram is recognised.
        let mut bytes = [0; text::MAX_BYTES + 1];
        for _ in 0..MAX_DATAGRAMS {
            match self.socket.recv_from(&mut bytes) {
                Ok((length, sender)) => match text::parse_pose(&bytes[..length]) {
                    Some(text::PoseLine { position, buttons }) => {
                        let reach = self.info.workspace[3];
                        let position = position.map(|c| c.clamp(-reach, reach));
                        latest.sample = Some(Sample { position, buttons, received: Instant::now() });
                        latest.sender = Some(sender);
                        self.accepted.fetch_add(1, Ordering::Relaxed);
                    }
                    None => {
                        self.rejected.fetch_add(1, Ordering::Relaxed);
                    }
                },
                Err(e) if e.kind() == ErrorKind::WouldBlock => break,
                // For instance an earlier answer that could not be delivered.
                Err(_) => {}
            }
        }
        let valid = latest.sample.filter(|sample| sample.received.elapsed() < self.hold);
        for pose in poses {
            *pose = valid.map_or_else(Pose::default, |Sample { position, buttons, received }| {
                let time_ns = time_ns.saturating_sub(received.elapsed().as_nanos() as u64);
                Pose { time_ns, flags: POSE_VALID, buttons, position, ..Pose::default() }
            });
        }
        Ok(())
    }

    fn write(&self, _time_ns: u64, outputs: &[Output]) -> Result<(), Fault> {
        let Some(output) = outputs.first() else { return Ok(()) };
        let norm = output.force.iter().map(|f| f * f).sum::<f64>().sqrt();
        let scale = if !norm.is_finite() { 0.0 } else { (self.info.peak_force / norm).min(1.0) };
        let force = if scale > 0.0 { output.force.map(|f| scale * f) } else { [0.0; 3] };
        self.set_force(force, output.valid_until_ns);
        if let Some(sender) = self.latest().sender {
            let mut bytes = [0; text::MAX_BYTES];
            let length = text::format_force(force, &mut bytes);
            // The sender need not listen for forces.
            let _ = self.socket.send_to(&bytes[..length], sender);
        }
        Ok(())
    }

    fn stop(&self) {
        self.set_force([0.0; 3], 0);
    }

    fn rendered(&self, time_ns: u64, outputs: &mut [Output]) -> Result<(), Fault> {
        let is_valid = time_ns < self.valid_until_ns.load(Ordering::Relaxed);
        for output in outputs {
            let component =
                |c: usize| if is_valid { f64::from_bits(self.force[c].load(Ordering::Relaxed)) } else { 0.0 };
            output.force = std::array::from_fn(component);
        }
        Ok(())
    }

    fn counter(&self, index: u32) -> Option<(&'static CStr, u64)> {
        let all = [(c"lines accepted", &self.accepted), (c"lines rejected", &self.rejected)];
        all.get(index as usize).map(|(name, count)| (*name, count.load(Ordering::Relaxed)))
    }

    fn probe(params: &Params<'_>) -> Vec<Finding> {
        let given = params.text("address").unwrap_or(ADDRESS);
        vec![match bind(params) {
            Ok(_) => Finding::present("port", format!("{given} is free")),
            Err(fault) => {
                Finding::missing("port", fault.reason, "end the program that uses it, or give another `address`")
            }
        }]
    }
}

export_plugins!(AsDevice<Pointer>);
