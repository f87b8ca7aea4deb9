//! The emulated device without its socket: its session with a host, what it renders, and until when.

use crate::fingers::Fingers;
use crate::network::Datagram;
use pliant_exoskeleton::key::Key;
use pliant_exoskeleton::link::nonce;
use pliant_exoskeleton::receiver::{ReceiveCounts, Receiver};
use pliant_exoskeleton::wire::{self, EFFECTOR_COUNT, FingerCommand, Header, MAX_DATAGRAM_BYTES, TaxelLayout};
use std::io;
use std::net::SocketAddr;

/// Silence of its host after which the device accepts another one, ns.
const SILENCE_LIMIT_NS: u64 = 1_000_000_000;
/// The same for a host that has not returned the device's nonce yet, ns: a single forged datagram must not keep others out for long.
const UNCONFIRMED_LIMIT_NS: u64 = 250_000_000;
/// How long a pose is valid, us.
const POSE_VALID_US: u32 = 50_000;

/// The largest forces the device renders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Norm of the force on one fingertip, N.
    pub force: f64,
    /// Force of one taxel, N.
    pub taxel_force: f32,
}

/// Why a force ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndReason {
    /// The last command expired.
    Expired,
    /// The host commanded a stop.
    Stopped,
}

/// The end of a rendered force. Times are ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForceEnd {
    /// Why the force ended.
    pub reason: EndReason,
    /// Time since the arrival of the last command that was applied.
    pub since_command_ns: u64,
    /// Time since the expiry of that command, or since the stop.
    pub since_expiry_ns: u64,
    /// The validity that the command claimed.
    pub valid_ns: u64,
}

/// Counters of a twin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TwinCounts {
    /// What became of the received datagrams.
    pub received: ReceiveCounts,
    /// Commands that were applied; stops are among them.
    pub commands_applied: u64,
    /// Forces that were scaled down to the limit.
    pub forces_clamped: u64,
}

/// The host of the current session.
struct Host {
    address: SocketAddr,
    nonce: u64,
    /// Nonce of the device in the session with it.
    device_nonce: u64,
    /// Whether it has returned the device's nonce.
    is_confirmed: bool,
    /// Arrival of the first datagram, then of the last that returned the device's nonce, ns.
    heard_ns: u64,
    receiver: Receiver,
}

impl Host {
    /// Whether it has been silent for so long that another host may begin a session.
    fn has_expired(&self, now_ns: u64) -> bool {
        let limit_ns = if self.is_confirmed { SILENCE_LIMIT_NS } else { UNCONFIRMED_LIMIT_NS };
        now_ns.saturating_sub(self.heard_ns) > limit_ns
    }
}

/// The emulated device. Its functions take the time `now_ns` of its own clock, which must not fall.
pub struct Twin {
    layout: TaxelLayout,
    key: Option<Key>,
    limits: Limits,
    host: Option<Host>,
    /// Nonce of the last host that said goodbye: its datagrams that arrive later must not begin a session.
    ended_host_nonce: u64,
    /// Sequence number of the last pose.
    sequence: u64,
    /// The last command that was applied.
    commands: [FingerCommand; EFFECTOR_COUNT],
    /// Its arrival, its claimed validity and its expiry, ns.
    command_arrived_ns: u64,
    command_valid_ns: u64,
    command_expires_ns: u64,
    /// Whether a force or a taxel is rendered whose end is not reported yet.
    is_rendering: bool,
    /// Whether the last command was a stop.
    is_stopped: bool,
    counts: TwinCounts,
    fingers: Fingers,
    /// When the fingers were advanced last, ns.
    fingers_advanced_ns: Option<u64>,
}

impl Twin {
    /// A device without a session.
    pub fn new(layout: TaxelLayout, key: Option<Key>, limits: Limits, fingers: Fingers) -> Self {
        Self {
            layout,
            key,
            limits,
            host: None,
            ended_host_nonce: 0,
            sequence: 0,
            commands: [FingerCommand::default(); EFFECTOR_COUNT],
            command_arrived_ns: 0,
            command_valid_ns: 0,
            command_expires_ns: 0,
            is_rendering: false,
            is_stopped: false,
            counts: TwinCounts::default(),
            fingers,
            fingers_advanced_ns: None,
        }
    }

    /// What became of datagrams and commands so far.
    pub fn counts(&self) -> TwinCounts {
        self.counts
    }

    /// Force rendered on each fingertip, N.
    pub fn force(&self, now_ns: u64) -> [[f64; 3]; EFFECTOR_COUNT] {
        if now_ns < self.command_expires_ns { self.commands.map(|c| c.force) } else { [[0.0; 3]; EFFECTOR_COUNT] }
    }

    /// Forces rendered by the taxels of each fingertip, N, row by row; empty if no command is valid.
    pub fn taxels(&self, now_ns: u64) -> [&[f32]; EFFECTOR_COUNT] {
        let count = if now_ns < self.command_expires_ns { self.layout.taxel_count() } else { 0 };
        self.commands.each_ref().map(|command| &command.taxels[..count])
    }

    /// Address of the host of the current session.
    pub fn host_address(&self) -> Option<SocketAddr> {
        self.host.as_ref().map(|host| host.address)
    }

    /// Whether a host has returned the device's nonce.
    pub fn is_connected(&self) -> bool {
        self.host.as_ref().is_some_and(|host| host.is_confirmed)
    }

    /// Processes a datagram. Returns whether it began a session.
    ///
    /// # Errors
    /// If it would begin a session and the system has no random number for the device's nonce.
    pub fn receive(&mut self, bytes: &[u8], address: SocketAddr, now_ns: u64) -> io::Result<bool> {
        let (header, commands) = match wire::read_command(bytes, self.layout, self.key.as_ref()) {
            Ok(command) => command,
            Err(rejection) => {
                rejection.count(&mut self.counts.received);
                return Ok(false);
            }
        };
        let is_free = self.host.as_ref().is_none_or(|host| host.has_expired(now_ns));
        let same_host = self.host.as_ref().filter(|host| host.address == address && host.nonce == header.sender_nonce);
        let is_host = same_host.is_some();
        let continues = same_host.is_some_and(|host| host.device_nonce == header.receiver_nonce);
        let begins = is_free && !continues && header.sender_nonce != self.ended_host_nonce;
        if begins && !header.last {
            let device_nonce = nonce()?;
            self.sequence = 0;
            self.host = Some(Host {
                address,
                nonce: header.sender_nonce,
                device_nonce,
                is_confirmed: false,
                heard_ns: now_ns,
                receiver: Receiver::default(),
            });
        } else if !is_host || (header.receiver_nonce != 0 && !continues) {
            self.counts.received.foreign += 1;
            return Ok(false);
        }
        let Some(host) = &mut self.host else { return Ok(false) };
        if !host.receiver.accept(header.sequence, &mut self.counts.received) {
            return Ok(begins);
        }
        let expires_ns = host.receiver.expiry_ns(header.time_ns, u64::from(header.valid_us) * 1000, now_ns);
        if header.receiver_nonce == host.device_nonce {
            (host.is_confirmed, host.heard_ns) = (true, now_ns);
            self.apply(&header, commands, expires_ns, now_ns);
        }
        Ok(begins)
    }

    /// Applies a command of the host of this session.
    fn apply(&mut self, header: &Header, mut commands: [FingerCommand; EFFECTOR_COUNT], expires_ns: u64, now_ns: u64) {
        if header.last {
            self.host = None;
            self.ended_host_nonce = header.sender_nonce;
        }
        if header.stop {
            self.is_stopped = true;
            self.command_expires_ns = now_ns;
            self.counts.commands_applied += 1;
            return;
        }
        if expires_ns <= now_ns {
            self.counts.received.stale += 1;
            return;
        }
        for command in &mut commands {
            let norm = command.force.iter().map(|f| f * f).sum::<f64>().sqrt();
            if norm > self.limits.force {
                // The norm of finite numbers can overflow.
                let scale = if norm.is_finite() { self.limits.force / norm } else { 0.0 };
                command.force = command.force.map(|f| f * scale);
                self.counts.forces_clamped += 1;
            }
            command.taxels.iter_mut().for_each(|t| *t = t.clamp(0.0, self.limits.taxel_force));
        }
        let is_nonzero = |c: &FingerCommand| c.force != [0.0; 3] || c.taxels.iter().any(|t| *t != 0.0);
        self.is_rendering = commands.iter().any(is_nonzero);
        self.is_stopped = false;
        self.commands = commands;
        self.command_arrived_ns = now_ns;
        self.command_valid_ns = u64::from(header.valid_us) * 1000;
        self.command_expires_ns = expires_ns;
        self.counts.commands_applied += 1;
    }

    /// Advances the fingers to `now_ns` while a host is connected. Returns a force that has ended since the last call.
    pub fn advance(&mut self, now_ns: u64) -> Option<ForceEnd> {
        let force = self.force(now_ns);
        if self.is_connected() {
            let elapsed_ns = now_ns.saturating_sub(self.fingers_advanced_ns.replace(now_ns).unwrap_or(now_ns));
            self.fingers.advance(elapsed_ns as f64 * 1e-9, &force);
        }
        if !self.is_rendering || now_ns < self.command_expires_ns {
            return None;
        }
        self.is_rendering = false;
        Some(ForceEnd {
            reason: if self.is_stopped { EndReason::Stopped } else { EndReason::Expired },
            since_command_ns: now_ns - self.command_arrived_ns,
            since_expiry_ns: now_ns - self.command_expires_ns,
            valid_ns: self.command_valid_ns,
        })
    }

    /// The next pose for the host; none without a session. With `last` it says that the device ends the session, and expires at once.
    pub fn next_pose(&mut self, now_ns: u64, last: bool) -> Option<Datagram> {
        let host = self.host.as_ref()?;
        self.sequence += 1;
        let header = Header {
            sender_nonce: host.device_nonce,
            receiver_nonce: host.nonce,
            sequence: self.sequence,
            time_ns: now_ns,
            valid_us: if last { 0 } else { POSE_VALID_US },
            stop: false,
            last,
        };
        let mut fingers = self.fingers.sensed();
        for ((finger, force), taxels) in fingers.iter_mut().zip(self.force(now_ns)).zip(self.taxels(now_ns)) {
            finger.force = force;
            finger.taxel_force_sum = taxels.iter().map(|t| f64::from(*t)).sum();
        }
        let mut bytes = [0; MAX_DATAGRAM_BYTES];
        let length = wire::write_pose(&mut bytes, self.layout, &header, &fingers, self.key.as_ref());
        Some(Datagram { sequence: self.sequence, address: host.address, bytes: bytes[..length].to_vec() })
    }
}
