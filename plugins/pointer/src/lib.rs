//! A hand for anyone: whatever can send a line of text over UDP moves it, and gets back what it would feel.
//!
//! A datagram is `x y z`, or `x y z mask`: metres in device axes (x right, y up, z towards the user) and buttons. The newest to
//! arrive counts. The answer to each write is `fx fy fz`, in newtons, to whoever sent last. It listens on loopback.

mod text;

use core::ffi::CStr;
use pliant_plugin_api::abi::{DeviceInfo, Output, POSE_VALID, Pose};
use pliant_plugin_api::{AsDevice, Device, Fault, Finding, Info, Param, Params, export_plugins};
use std::io::ErrorKind;
use std::net::{SocketAddr, ToSocketAddrs, UdpSocket};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Where it listens when nothing else is said.
const ADDRESS: &str = "127.0.0.1:48630";

const PARAMS: &[Param] = &[
    Param::text(c"address", c"where it listens; 127.0.0.1:48630 when not given"),
    Param::number(c"hold", c"s", (0.01, 3600.0), 0.5, c"how long a place stands without a new one"),
    Param::number(c"reach", c"m", (1e-3, 100.0), 0.1, c"half an edge of its workspace"),
    Param::number(c"peak-force", c"N", (1e-3, 1e4), 3.3, c"largest force it tells"),
    Param::number(c"stiffness", c"N/m", (1e-3, 1e6), 700.0, c"largest stiffness it pretends to render"),
];

/// What came last.
struct Newest {
    place: Option<([f64; 3], u32, Instant)>,
    from: Option<SocketAddr>,
}

/// A socket that is a hand.
pub struct Pointer {
    socket: UdpSocket,
    facts: DeviceInfo,
    hold: Duration,
    newest: Mutex<Newest>,
    /// N, as bits, and until when, ns.
    force: [AtomicU64; 3],
    until: AtomicU64,
    taken: AtomicU64,
    refused: AtomicU64,
}

/// Most datagrams one read takes in.
const MOST_AT_ONCE: usize = 256;

impl Pointer {
    /// Where it listens.
    pub fn address(&self) -> Option<SocketAddr> {
        self.socket.local_addr().ok()
    }

    /// Never waited for inside of a servo loop: nothing else runs beside `read` and `write`.
    fn newest(&self) -> MutexGuard<'_, Newest> {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn keep(&self, force: [f64; 3], until: u64) {
        self.force.iter().zip(force).for_each(|(to, f)| to.store(f.to_bits(), Ordering::Relaxed));
        self.until.store(until, Ordering::Relaxed);
    }
}

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
        summary: c"a hand moved by lines of text over UDP",
        params: PARAMS,
    };

    fn new(params: &Params<'_>) -> Result<Self, Fault> {
        let (reach, peak) = (params.number("reach"), params.number("peak-force"));
        let facts = DeviceInfo {
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
        };
        Ok(Self {
            socket: bind(params)?,
            facts,
            hold: Duration::from_secs_f64(params.number("hold")),
            newest: Mutex::new(Newest { place: None, from: None }),
            force: Default::default(),
            until: AtomicU64::new(0),
            taken: AtomicU64::new(0),
            refused: AtomicU64::new(0),
        })
    }

    fn describe(&self) -> DeviceInfo {
        self.facts
    }

    fn read(&self, time: u64, poses: &mut [Pose]) -> Result<(), Fault> {
        let newest = &mut *self.newest();
        let mut bytes = [0; text::MOST_BYTES + 1];
        for _ in 0..MOST_AT_ONCE {
            match self.socket.recv_from(&mut bytes) {
                Ok((length, from)) => match text::place(&bytes[..length]) {
                    Some((place, mask)) => {
                        // A hand does not leave its workspace.
                        let reach = self.facts.workspace[3];
                        newest.place = Some((place.map(|c| c.clamp(-reach, reach)), mask, Instant::now()));
                        newest.from = Some(from);
                        self.taken.fetch_add(1, Ordering::Relaxed);
                    }
                    None => {
                        self.refused.fetch_add(1, Ordering::Relaxed);
                    }
                },
                Err(e) if e.kind() == ErrorKind::WouldBlock => break,
                Err(_) => {}
            }
        }
        let held = newest.place.filter(|(.., since)| since.elapsed() < self.hold);
        for pose in poses {
            *pose = held.map_or_else(Pose::default, |(position, buttons, since)| {
                let time_ns = time.saturating_sub(since.elapsed().as_nanos() as u64);
                Pose { time_ns, flags: POSE_VALID, buttons, position, ..Pose::default() }
            });
        }
        Ok(())
    }

    fn write(&self, _time: u64, outputs: &[Output]) -> Result<(), Fault> {
        let Some(output) = outputs.first() else { return Ok(()) };
        let size = output.force.iter().map(|f| f * f).sum::<f64>().sqrt();
        let scale = if !size.is_finite() { 0.0 } else { (self.facts.peak_force / size).min(1.0) };
        let force = if scale > 0.0 { output.force.map(|f| scale * f) } else { [0.0; 3] };
        self.keep(force, output.valid_until_ns);
        if let Some(to) = self.newest().from {
            let mut bytes = [0; text::MOST_BYTES];
            let length = text::force(force, &mut bytes);
            // Whoever moves the hand may not care.
            let _ = self.socket.send_to(&bytes[..length], to);
        }
        Ok(())
    }

    fn stop(&self) {
        self.keep([0.0; 3], 0);
    }

    fn rendered(&self, time: u64, outputs: &mut [Output]) -> Result<(), Fault> {
        let holds = time < self.until.load(Ordering::Relaxed);
        for output in outputs {
            let kept = |c: usize| if holds { f64::from_bits(self.force[c].load(Ordering::Relaxed)) } else { 0.0 };
            output.force = std::array::from_fn(kept);
        }
        Ok(())
    }

    fn counter(&self, index: u32) -> Option<(&'static CStr, u64)> {
        let all = [(c"places taken", &self.taken), (c"lines refused", &self.refused)];
        all.get(index as usize).map(|(name, count)| (*name, count.load(Ordering::Relaxed)))
    }

    fn probe(params: &Params<'_>) -> Vec<Finding> {
        let given = params.text("address").unwrap_or(ADDRESS);
        vec![match bind(params) {
            Ok(_) => Finding::present("port", format!("{given} is free")),
            Err(fault) => Finding::missing("port", fault.reason, "end what uses it, or give another `address`"),
        }]
    }
}

export_plugins!(AsDevice<Pointer>);
