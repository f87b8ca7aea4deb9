//! The device itself: who it is in conversation with, what it renders, and until when.

use crate::fingers::Fingers;
use pliant_exoskeleton::key::Key;
use pliant_exoskeleton::link::nonce;
use pliant_exoskeleton::receiver::{Counts, Receiver};
use pliant_exoskeleton::wire::{self, EFFECTORS, Feel, Header, Layout, MOST_BYTES, Refused};
use std::net::SocketAddr;

/// What it can render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// N, of one fingertip
    pub force: f64,
    /// N, of one taxel
    pub taxel: f32,
}

/// Why nothing is rendered any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// What it was told holds no longer.
    Expired,
    /// It was told to stop.
    Stopped,
}

/// A force that went to zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Zero {
    /// Why.
    pub ended: Ended,
    /// ns, since the last command that was obeyed arrived
    pub after: u64,
    /// ns, since its deadline
    pub past: u64,
    /// ns, that command's own time to hold
    pub valid: u64,
}

struct Peer {
    address: SocketAddr,
    from: u64,
    confirmed: bool,
    heard: u64,
    receiver: Receiver,
}

/// A device without a socket.
pub struct Twin {
    layout: Layout,
    key: Option<Key>,
    limits: Limits,
    peer: Option<Peer>,
    own: u64,
    /// The host that has said goodbye: what of it was still on its way begins nothing.
    gone: u64,
    sequence: u64,
    feels: [Feel; EFFECTORS],
    /// ns
    arrived: u64,
    valid: u64,
    deadline: u64,
    feeling: bool,
    stopped: bool,
    counts: Counts,
    obeyed: u64,
    clamped: u64,
    fingers: Fingers,
    /// ns, when the fingers were moved last
    moved: Option<u64>,
}

/// ns, silence after which another host may come; of one that has not answered yet
const LET_GO: u64 = 1_000_000_000;
const UNCONFIRMED: u64 = 250_000_000;
/// us, how long a pose holds
const POSE_VALID: u32 = 50_000;

impl Twin {
    /// In conversation with nobody.
    pub fn new(layout: Layout, key: Option<Key>, limits: Limits, fingers: Fingers) -> Self {
        Self {
            layout,
            key,
            limits,
            peer: None,
            own: nonce(),
            gone: 0,
            sequence: 0,
            feels: [Feel::default(); EFFECTORS],
            arrived: 0,
            valid: 0,
            deadline: 0,
            feeling: false,
            stopped: false,
            counts: Counts::default(),
            obeyed: 0,
            clamped: 0,
            fingers,
            moved: None,
        }
    }

    /// What became of what arrived, how many commands were obeyed, and forces that were cut to the limits.
    pub fn counts(&self) -> (Counts, u64, u64) {
        (self.counts, self.obeyed, self.clamped)
    }

    /// N, what each fingertip renders at `now` (ns).
    pub fn force(&self, now: u64) -> [[f64; 3]; EFFECTORS] {
        if now < self.deadline { self.feels.map(|f| f.force) } else { [[0.0; 3]; EFFECTORS] }
    }

    /// N, what the taxels of each fingertip render at `now` (ns).
    pub fn taxels(&self, now: u64) -> [&[f32]; EFFECTORS] {
        let count = if now < self.deadline { self.layout.taxels() } else { 0 };
        [&self.feels[0].taxels[..count], &self.feels[1].taxels[..count]]
    }

    /// The sequence number of what it told last.
    pub fn told(&self) -> u64 {
        self.sequence
    }

    /// Whom it answers.
    pub fn peer(&self) -> Option<SocketAddr> {
        self.peer.as_ref().map(|p| p.address)
    }

    /// Whether its host has answered.
    pub fn is_met(&self) -> bool {
        self.peer.as_ref().is_some_and(|p| p.confirmed)
    }

    /// Takes in a datagram at `now` (ns); gives whether a conversation began.
    pub fn take(&mut self, bytes: &[u8], address: SocketAddr, now: u64) -> bool {
        let (header, feels) = match wire::read_command(bytes, self.layout, self.key.as_ref()) {
            Ok(read) => read,
            Err(Refused::Key) => {
                self.counts.unauthentic += 1;
                return false;
            }
            Err(_) => {
                self.counts.malformed += 1;
                return false;
            }
        };
        let silence = |p: &Peer| now.saturating_sub(p.heard);
        let free = self.peer.as_ref().is_none_or(|p| silence(p) > if p.confirmed { LET_GO } else { UNCONFIRMED });
        let known = self.peer.as_ref().is_some_and(|p| p.address == address && p.from == header.from);
        let begins = free && !(known && header.to == self.own) && header.from != self.gone;
        if begins && !header.last {
            self.own = nonce();
            self.sequence = 0;
            let receiver = Receiver::default();
            self.peer = Some(Peer { address, from: header.from, confirmed: false, heard: now, receiver });
        } else if !known || (header.to != 0 && header.to != self.own) {
            self.counts.foreign += 1;
            return false;
        }
        let Some(peer) = &mut self.peer else { return false };
        if !peer.receiver.is_newest(header.sequence, &mut self.counts) {
            return begins;
        }
        let deadline = peer.receiver.deadline(header.time, u64::from(header.valid) * 1000, now);
        if header.to == self.own {
            (peer.confirmed, peer.heard) = (true, now);
            self.obey(&header, feels, deadline, now);
        }
        begins
    }

    fn obey(&mut self, header: &Header, mut feels: [Feel; EFFECTORS], deadline: u64, now: u64) {
        if header.last {
            self.peer = None;
            self.gone = header.from;
            self.own = nonce();
        }
        if header.stop {
            self.stopped = true;
            (self.deadline, self.obeyed) = (now, self.obeyed + 1);
            return;
        }
        if deadline <= now {
            self.counts.stale += 1;
            return;
        }
        for feel in &mut feels {
            let size = feel.force.iter().map(|f| f * f).sum::<f64>().sqrt();
            if size > self.limits.force {
                let scale = if size.is_finite() { self.limits.force / size } else { 0.0 };
                feel.force = feel.force.map(|f| f * scale);
                self.clamped += 1;
            }
            feel.taxels.iter_mut().for_each(|t| *t = t.clamp(0.0, self.limits.taxel));
        }
        let feels_something = |f: &Feel| f.force != [0.0; 3] || f.taxels.iter().any(|t| *t != 0.0);
        self.feeling = feels.iter().any(feels_something);
        (self.feels, self.arrived, self.deadline, self.stopped) = (feels, now, deadline, false);
        self.valid = u64::from(header.valid) * 1000;
        self.obeyed += 1;
    }

    /// Moves on to `now` (ns); gives a force that has gone to zero since the last time.
    pub fn advance(&mut self, now: u64) -> Option<Zero> {
        let force = self.force(now);
        if self.is_met() {
            let since = now.saturating_sub(self.moved.replace(now).unwrap_or(now));
            self.fingers.advance(since as f64 * 1e-9, &force);
        }
        if !self.feeling || now < self.deadline {
            return None;
        }
        self.feeling = false;
        let ended = if self.stopped { Ended::Stopped } else { Ended::Expired };
        Some(Zero { ended, after: now - self.arrived, past: now - self.deadline, valid: self.valid })
    }

    /// Writes its poses for its host; gives the length and where to. `last` when it goes.
    pub fn tell(&mut self, bytes: &mut [u8; MOST_BYTES], now: u64, last: bool) -> Option<(usize, SocketAddr)> {
        let peer = self.peer.as_ref()?;
        self.sequence += 1;
        let valid = if last { 0 } else { POSE_VALID };
        let (from, to, sequence) = (self.own, peer.from, self.sequence);
        let header = Header { from, to, sequence, time: now, valid, stop: false, last };
        let mut fingers = self.fingers.sensed();
        let (force, taxels) = (self.force(now), self.taxels(now));
        for (i, finger) in fingers.iter_mut().enumerate() {
            finger.force = force[i];
            finger.touch = taxels[i].iter().map(|t| f64::from(*t)).sum();
        }
        let length = wire::write_pose(bytes, self.layout, &header, &fingers, self.key.as_ref());
        Some((length, peer.address))
    }
}
