//! The host's end of a conversation: a socket, what was heard last, and what is being rendered.
//!
//! A conversation begins with a command that renders nothing and names no receiver. The device answers with poses that carry
//! a number of its own, and obeys only commands that give that number back: a sender that does not hear the device cannot
//! know it, and a recording of an earlier conversation has another one.

use crate::key::Key;
use crate::receiver::{Counts, Receiver};
use crate::wire::{self, EFFECTORS, Feel, Finger, Header, Layout, MOST_BYTES, Refused};
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher, Hasher};
use std::io::ErrorKind;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// Where a device is when nothing else is said.
pub const DEFAULT_PEER: &str = "127.0.0.1:48620";
/// Most datagrams one call takes in.
const MOST_AT_ONCE: usize = 256;
/// Largest datagram there is, so that a longer one is told from a whole one.
const BUFFER: usize = MOST_BYTES + 1;

/// A number nobody can guess and that is not 0: the seed of a hash map of the standard library.
pub fn nonce() -> u64 {
    RandomState::new().build_hasher().finish().max(1)
}

/// What was heard.
struct Heard {
    receiver: Receiver,
    counts: Counts,
    fingers: [Finger; EFFECTORS],
    /// ns, since the start
    arrived: u64,
    deadline: u64,
}

/// A socket and a conversation on it.
pub struct Link {
    socket: UdpSocket,
    peer: SocketAddr,
    layout: Layout,
    key: Option<Key>,
    start: Instant,
    /// Our number of this conversation, and the device's; 0 before it is known.
    own: u64,
    theirs: AtomicU64,
    sequence: AtomicU64,
    /// Datagrams the system did not take.
    unsent: AtomicU64,
    heard: Mutex<Heard>,
}

/// The newest of the device.
#[derive(Clone, Copy, Debug)]
pub struct News {
    /// As it was sensed.
    pub fingers: [Finger; EFFECTORS],
    /// Whether it still holds.
    pub holds: bool,
    /// ns, since it arrived
    pub age: u64,
}

impl Link {
    /// Binds a socket that reaches `peer`: on loopback where that is one.
    ///
    /// # Errors
    /// What the system says.
    pub fn new(peer: SocketAddr, layout: Layout, key: Option<Key>) -> std::io::Result<Self> {
        let local: SocketAddr = match peer {
            SocketAddr::V4(a) if a.ip().is_loopback() => (Ipv4Addr::LOCALHOST, 0).into(),
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(a) if a.ip().is_loopback() => (Ipv6Addr::LOCALHOST, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let socket = UdpSocket::bind(local)?;
        socket.set_nonblocking(true)?;
        let heard = Heard {
            receiver: Receiver::default(),
            counts: Counts::default(),
            fingers: [Finger::default(); EFFECTORS],
            arrived: 0,
            deadline: 0,
        };
        Ok(Self {
            socket,
            peer,
            layout,
            key,
            start: Instant::now(),
            own: nonce(),
            theirs: AtomicU64::new(0),
            sequence: AtomicU64::new(0),
            unsent: AtomicU64::new(0),
            heard: Mutex::new(heard),
        })
    }

    /// Says hello until the device answers.
    ///
    /// # Errors
    /// It does not, within `patience`.
    pub fn meet(&self, patience: Duration) -> Result<(), String> {
        let begun = Instant::now();
        loop {
            self.hear();
            if self.theirs.load(Ordering::Relaxed) != 0 {
                return Ok(());
            }
            if begun.elapsed() >= patience {
                return Err(format!("no exoskeleton answers at {}{}", self.peer, self.why_not()));
            }
            self.send(&[Feel::default(); EFFECTORS], 0, Say::Feel);
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn why_not(&self) -> &'static str {
        let counts = self.counts();
        match counts {
            Counts { unauthentic: 1.., .. } => ": something is there, with another key or none",
            Counts { malformed: 1.., .. } => ": something is there, of another version or with other taxels",
            Counts { foreign: 1.., .. } => ": something is there, in conversation with another host",
            _ => "",
        }
    }

    /// ns, since the link was made
    pub fn now(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    /// Our own address.
    pub fn local(&self) -> Option<SocketAddr> {
        self.socket.local_addr().ok()
    }

    /// Datagrams handed to the system, those it did not take among them.
    pub fn sent(&self) -> u64 {
        self.sequence.load(Ordering::Relaxed)
    }

    /// Datagrams the system did not take.
    pub fn unsent(&self) -> u64 {
        self.unsent.load(Ordering::Relaxed)
    }

    /// What became of what was received.
    pub fn counts(&self) -> Counts {
        self.heard().counts
    }

    /// Never waited for inside of a servo loop: only `read` takes it there, and nothing else runs beside it.
    fn heard(&self) -> MutexGuard<'_, Heard> {
        self.heard.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Takes in what has arrived, and gives the newest.
    pub fn hear(&self) -> News {
        let heard = &mut *self.heard();
        let mut bytes = [0; BUFFER];
        for _ in 0..MOST_AT_ONCE {
            match self.socket.recv_from(&mut bytes) {
                Ok((length, from)) => self.take(&bytes[..length], from, heard),
                Err(e) if e.kind() == ErrorKind::WouldBlock => break,
                // A device that has gone away: the system gives its refusals one by one.
                Err(_) => {}
            }
        }
        let now = self.now();
        News { fingers: heard.fingers, holds: now < heard.deadline, age: now.saturating_sub(heard.arrived) }
    }

    fn take(&self, bytes: &[u8], from: SocketAddr, heard: &mut Heard) {
        let counts = &mut heard.counts;
        if from != self.peer {
            counts.foreign += 1;
            return;
        }
        let (header, fingers) = match wire::read_pose(bytes, self.layout, self.key.as_ref()) {
            Ok(read) => read,
            Err(Refused::Key) => return counts.unauthentic += 1,
            Err(_) => return counts.malformed += 1,
        };
        if header.to != self.own {
            counts.foreign += 1;
            return;
        }
        if header.from != self.theirs.load(Ordering::Relaxed) {
            // Only after it has fallen silent: else a device could be replaced in the middle of a touch.
            if self.now() < heard.deadline {
                counts.foreign += 1;
                return;
            }
            self.theirs.store(header.from, Ordering::Relaxed);
            heard.receiver = Receiver::default();
        }
        if !heard.receiver.is_newest(header.sequence, counts) {
            return;
        }
        let now = self.now();
        heard.arrived = now;
        heard.deadline = heard.receiver.deadline(header.time, u64::from(header.valid) * 1000, now);
        if header.last {
            heard.deadline = 0;
        }
        if heard.deadline <= now {
            counts.stale += 1;
            return;
        }
        heard.fingers = fingers;
    }

    /// Sends what to render for `valid` (ns).
    pub fn send(&self, feels: &[Feel; EFFECTORS], valid: u64, say: Say) {
        let theirs = self.theirs.load(Ordering::Relaxed);
        let header = Header {
            from: self.own,
            to: theirs,
            sequence: self.sequence.fetch_add(1, Ordering::Relaxed) + 1,
            time: self.now(),
            valid: u32::try_from(valid / 1000).unwrap_or(u32::MAX).min(wire::MOST_VALID),
            stop: say != Say::Feel,
            last: say == Say::Goodbye,
        };
        let mut bytes = [0; MOST_BYTES];
        let length = wire::write_command(&mut bytes, self.layout, &header, feels, self.key.as_ref());
        if self.socket.send_to(&bytes[..length], self.peer).is_err() {
            self.unsent.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// What a command says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Say {
    /// Render this.
    Feel,
    /// Render nothing, at once.
    Stop,
    /// The same, and the host goes.
    Goodbye,
}
