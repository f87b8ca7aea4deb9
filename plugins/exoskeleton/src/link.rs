//! The host's end of a session with the device: a UDP socket, the last state received, and the commands sent.
//!
//! A session begins with a command that renders nothing and carries 0 as the receiver's nonce. The device answers with poses that carry
//! a nonce of its own, and from then on renders only commands that return this nonce. A sender that does not receive the device's
//! datagrams cannot know it, and a recording of an earlier session carries another one.

use crate::key::Key;
use crate::receiver::{ReceiveCounts, Receiver};
use crate::wire::{
    self, EFFECTOR_COUNT, FingerCommand, FingerState, Header, MAX_DATAGRAM_BYTES, MAX_VALID_US, TaxelLayout,
};
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// Address and port of the device if the scene gives none.
pub const DEFAULT_PEER: &str = "127.0.0.1:48620";
/// Most datagrams one call of [`Link::receive`] processes, so that a flood of them cannot stop the haptic loop.
const MAX_DATAGRAMS_PER_CALL: usize = 256;
/// Time between two attempts to begin a session.
const CONNECT_INTERVAL: Duration = Duration::from_millis(2);
/// Bytes of the receive buffer: one more than a valid datagram has, so that a longer one is not taken for a valid one when cut off.
const BUFFER_BYTES: usize = MAX_DATAGRAM_BYTES + 1;

/// A random number other than 0, from the generator of the operating system, so that no other process can guess it.
///
/// # Errors
/// If the system has no random number; the message names its cause.
pub fn nonce() -> io::Result<u64> {
    let number = getrandom::u64().map_err(|cause| {
        io::Error::other(format!("the system has no random number for the nonce of a session: {cause}"))
    })?;
    Ok(number.max(1))
}

/// What was received from the device.
struct ReceiveState {
    /// Sequence numbers and clock offset of the session.
    receiver: Receiver,
    /// Counters of datagrams.
    counts: ReceiveCounts,
    /// The newest pose.
    fingers: [FingerState; EFFECTOR_COUNT],
    /// Arrival of the newest pose, ns on the link's clock.
    arrived_ns: u64,
    /// Time at which it expires, ns on the link's clock.
    expires_ns: u64,
}

/// A socket and a session with the device at one address.
pub struct Link {
    /// Non-blocking UDP socket, by which datagrams are received and sent.
    socket: UdpSocket,
    /// Address of the device.
    peer: SocketAddr,
    /// Size of the tactile arrays.
    layout: TaxelLayout,
    /// Key of both sides; `None` without authentication.
    key: Option<Key>,
    /// Origin of the link's clock.
    start: Instant,
    /// Nonce of the host in this session.
    own_nonce: u64,
    /// Nonce of the device in this session; 0 before it has answered.
    peer_nonce: AtomicU64,
    /// Sequence number of the last command.
    sequence: AtomicU64,
    /// Commands that the system did not send.
    unsent: AtomicU64,
    /// What was received.
    state: Mutex<ReceiveState>,
}

/// The newest state of the device.
#[derive(Clone, Copy, Debug)]
pub struct LatestState {
    /// The fingertips as the device sensed them.
    pub fingers: [FingerState; EFFECTOR_COUNT],
    /// Whether the state has not expired.
    pub is_valid: bool,
    /// Time since its arrival, ns.
    pub age_ns: u64,
}

/// What a command asks of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandKind {
    /// To render the forces and taxels in it.
    Render,
    /// To render nothing, at once.
    Stop,
    /// To render nothing, at once, and to end the session.
    Goodbye,
}

impl Link {
    /// Binds a socket for a device at `peer`; bound to the loopback interface if `peer` is a loopback address. Sends nothing.
    ///
    /// # Errors
    /// If the system refuses the socket, or has no random number for the nonce.
    pub fn new(peer: SocketAddr, layout: TaxelLayout, key: Option<Key>) -> io::Result<Self> {
        let local: SocketAddr = match peer {
            SocketAddr::V4(a) if a.ip().is_loopback() => (Ipv4Addr::LOCALHOST, 0).into(),
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(a) if a.ip().is_loopback() => (Ipv6Addr::LOCALHOST, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let socket = UdpSocket::bind(local)?;
        socket.set_nonblocking(true)?;
        let state = ReceiveState {
            receiver: Receiver::default(),
            counts: ReceiveCounts::default(),
            fingers: [FingerState::default(); EFFECTOR_COUNT],
            arrived_ns: 0,
            expires_ns: 0,
        };
        Ok(Self {
            socket,
            peer,
            layout,
            key,
            start: Instant::now(),
            own_nonce: nonce()?,
            peer_nonce: AtomicU64::new(0),
            sequence: AtomicU64::new(0),
            unsent: AtomicU64::new(0),
            state: Mutex::new(state),
        })
    }

    /// Sends commands that render nothing until the device answers.
    ///
    /// # Errors
    /// If it does not answer within `timeout`. The message names the address and what was received instead.
    pub fn connect(&self, timeout: Duration) -> Result<(), String> {
        let begin = Instant::now();
        loop {
            self.receive();
            if self.peer_nonce.load(Ordering::Relaxed) != 0 {
                return Ok(());
            }
            if begin.elapsed() >= timeout {
                return Err(format!("no exoskeleton answers at {}{}", self.peer, self.rejection_hint()));
            }
            self.send(&[FingerCommand::default(); EFFECTOR_COUNT], 0, CommandKind::Render);
            std::thread::sleep(CONNECT_INTERVAL);
        }
    }

    /// The probable reason why all datagrams were rejected; empty if none arrived.
    fn rejection_hint(&self) -> &'static str {
        let counts = self.counts();
        if counts.unauthentic > 0 {
            ": a device answers with another key, or one side has no key"
        } else if counts.malformed > 0 {
            ": a device answers with another protocol version or other taxels"
        } else if counts.foreign > 0 {
            ": a device answers that is in a session with another host"
        } else {
            ""
        }
    }

    /// Time since the link was made, ns.
    pub fn now_ns(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    /// The address the socket is bound to; none if the system does not tell.
    pub fn local_address(&self) -> Option<SocketAddr> {
        self.socket.local_addr().ok()
    }

    /// Number of commands given to the system, including those it did not send.
    pub fn sent_count(&self) -> u64 {
        self.sequence.load(Ordering::Relaxed)
    }

    /// Number of commands that the system did not send.
    pub fn unsent_count(&self) -> u64 {
        self.unsent.load(Ordering::Relaxed)
    }

    /// Counters of the received datagrams.
    pub fn counts(&self) -> ReceiveCounts {
        self.lock_state().counts
    }

    /// The lock is never contended in the haptic loop: only `read` takes it there, and the host calls the functions of a device one
    /// after the other.
    fn lock_state(&self) -> MutexGuard<'_, ReceiveState> {
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    /// Processes the datagrams that have arrived, without waiting, and returns the newest state.
    pub fn receive(&self) -> LatestState {
        let state = &mut *self.lock_state();
        let mut bytes = [0; BUFFER_BYTES];
        for _ in 0..MAX_DATAGRAMS_PER_CALL {
            match self.socket.recv_from(&mut bytes) {
                Ok((length, from)) => self.process_datagram(&bytes[..length], from, state),
                Err(e) if e.kind() == ErrorKind::WouldBlock => break,
                // If the device is gone, the system reports one "connection refused" per command; the datagrams are behind them.
                Err(_) => {}
            }
        }
        let now_ns = self.now_ns();
        LatestState {
            fingers: state.fingers,
            is_valid: now_ns < state.expires_ns,
            age_ns: now_ns.saturating_sub(state.arrived_ns),
        }
    }

    /// Counts a datagram, and stores its poses if it is the newest of this session and has not expired.
    fn process_datagram(&self, bytes: &[u8], from: SocketAddr, state: &mut ReceiveState) {
        let counts = &mut state.counts;
        if from != self.peer {
            counts.foreign += 1;
            return;
        }
        let (header, fingers) = match wire::read_pose(bytes, self.layout, self.key.as_ref()) {
            Ok(pose) => pose,
            Err(rejection) => return rejection.count(counts),
        };
        if header.receiver_nonce != self.own_nonce {
            counts.foreign += 1;
            return;
        }
        if header.sender_nonce != self.peer_nonce.load(Ordering::Relaxed) {
            // A new session begins only after the poses of the old one have expired: another device cannot take over during a contact.
            if self.now_ns() < state.expires_ns {
                counts.foreign += 1;
                return;
            }
            self.peer_nonce.store(header.sender_nonce, Ordering::Relaxed);
            state.receiver = Receiver::default();
        }
        if !state.receiver.accept(header.sequence, counts) {
            return;
        }
        let now_ns = self.now_ns();
        state.arrived_ns = now_ns;
        state.expires_ns = state.receiver.expiry_ns(header.time_ns, u64::from(header.valid_us) * 1000, now_ns);
        if header.last {
            state.expires_ns = 0;
        }
        if state.expires_ns <= now_ns {
            counts.stale += 1;
            return;
        }
        state.fingers = fingers;
    }

    /// Sends a command that is valid for `valid_ns`, at most [`MAX_VALID_US`]. Does not wait; a command that the system does not send is
    /// counted.
    pub fn send(&self, fingers: &[FingerCommand; EFFECTOR_COUNT], valid_ns: u64, kind: CommandKind) {
        let header = Header {
            sender_nonce: self.own_nonce,
            receiver_nonce: self.peer_nonce.load(Ordering::Relaxed),
            sequence: self.sequence.fetch_add(1, Ordering::Relaxed) + 1,
            time_ns: self.now_ns(),
            valid_us: u32::try_from(valid_ns / 1000).unwrap_or(u32::MAX).min(MAX_VALID_US),
            stop: kind != CommandKind::Render,
            last: kind == CommandKind::Goodbye,
        };
        let mut bytes = [0; MAX_DATAGRAM_BYTES];
        let length = wire::write_command(&mut bytes, self.layout, &header, fingers, self.key.as_ref());
        if self.socket.send_to(&bytes[..length], self.peer).is_err() {
            self.unsent.fetch_add(1, Ordering::Relaxed);
        }
    }
}
