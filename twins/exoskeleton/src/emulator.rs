//! The loop of the twin: it receives datagrams, sends a pose per tick, and prints events.

use pliant_exoskeleton::wire::{HEADER_BYTES, MAX_DATAGRAM_BYTES, SEQUENCE_OFFSET};
use pliant_twin_exoskeleton::{Datagram, EndReason, ForceEnd, InjectedCounts, Network, Twin};
use serde_json::{Map, Value, json};
use std::io::{ErrorKind, Write};
use std::net::UdpSocket;
use std::sync::mpsc::{Receiver, TrySendError, sync_channel};
use std::time::{Duration, Instant};

/// Received datagrams that wait for the loop of the twin: a quarter of a second of the fastest host.
const ARRIVAL_CAPACITY: usize = 1024;

/// When the twin acts. Times are ns since its start.
pub(crate) struct Schedule {
    /// Time between two poses.
    pub tick_ns: u64,
    /// When the twin ends.
    pub end_ns: u64,
    /// Whether the twin also ends when its host ends the session.
    pub end_with_host: bool,
}

/// A received datagram with its time of arrival, ns since the start.
struct Arrival {
    datagram: Datagram,
    time_ns: u64,
}

/// A twin with a socket and an emulated network in each direction.
pub(crate) struct Emulator {
    twin: Twin,
    socket: UdpSocket,
    arrivals: Receiver<Arrival>,
    to_host: Network,
    from_host: Network,
    start: Instant,
    /// Longest delay of a tick, ns.
    longest_delay_ns: u64,
}

impl Emulator {
    /// Begins to receive from `socket`.
    pub(crate) fn new(twin: Twin, socket: UdpSocket, to_host: Network, from_host: Network) -> Result<Self, String> {
        let start = Instant::now();
        let arrivals = spawn_receiver(&socket, start)?;
        Ok(Self { twin, socket, arrivals, to_host, from_host, start, longest_delay_ns: 0 })
    }

    fn now_ns(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    /// Runs until the end of the schedule.
    pub(crate) fn run(mut self, schedule: &Schedule) -> Result<(), String> {
        let address = self.socket.local_addr().map_err(|e| e.to_string())?;
        print_event(&json!({ "event": "ready", "address": address.to_string() }));
        let mut tick_due_ns = schedule.tick_ns;
        let mut was_connected = false;
        loop {
            self.wait_for_arrivals(tick_due_ns.min(schedule.end_ns));
            let now_ns = self.now_ns();
            while let Some(Datagram { address, bytes, .. }) = self.from_host.deliver(now_ns) {
                if self.twin.receive(&bytes, address, now_ns).map_err(|e| e.to_string())? {
                    self.to_host.begin_session();
                }
            }
            if self.twin.is_connected() && !was_connected {
                let peer = self.twin.host_address().map(|p| p.to_string());
                print_event(&json!({ "event": "connected", "peer": peer }));
            }
            let host_ended = was_connected && self.twin.host_address().is_none();
            was_connected = self.twin.is_connected();
            if now_ns >= tick_due_ns {
                self.longest_delay_ns = self.longest_delay_ns.max(now_ns - tick_due_ns);
                // Missed ticks are skipped.
                tick_due_ns = now_ns.max(tick_due_ns + schedule.tick_ns);
                self.tick(now_ns);
            }
            self.deliver_to_host(now_ns);
            if now_ns >= schedule.end_ns || (host_ended && schedule.end_with_host) {
                break;
            }
        }
        self.end_session()?;
        print_event(&self.end_event());
        Ok(())
    }

    /// Waits until `until_ns` or until a datagram of either direction is due; received datagrams enter the network from the host.
    fn wait_for_arrivals(&mut self, until_ns: u64) {
        let releases = [self.to_host.next_release_ns(), self.from_host.next_release_ns()];
        let wake_ns = releases.into_iter().flatten().fold(until_ns, u64::min);
        let mut timeout = Duration::from_nanos(wake_ns.saturating_sub(self.now_ns()));
        // In a flood the ticks go on.
        for _ in 0..ARRIVAL_CAPACITY {
            let Ok(Arrival { datagram, time_ns }) = self.arrivals.recv_timeout(timeout) else { return };
            self.from_host.send(datagram, time_ns);
            timeout = Duration::ZERO;
        }
    }

    /// Advances the twin and sends a pose.
    fn tick(&mut self, now_ns: u64) {
        if let Some(end) = self.twin.advance(now_ns) {
            print_event(&force_ended_event(&end));
        }
        if let Some(pose) = self.twin.next_pose(now_ns, false) {
            self.to_host.send(pose, now_ns);
        }
    }

    fn deliver_to_host(&mut self, now_ns: u64) {
        while let Some(Datagram { address, bytes, .. }) = self.to_host.deliver(now_ns) {
            // A send error is a lost datagram.
            let _ = self.socket.send_to(&bytes, address);
        }
    }

    /// Delivers what is still on its way in both directions, and sends the last pose past the network, so that it is not lost and the
    /// counters of host and twin can be compared.
    fn end_session(&mut self) -> Result<(), String> {
        self.deliver_to_host(u64::MAX);
        if let Some(pose) = self.twin.next_pose(self.now_ns(), true) {
            self.to_host.bypass(pose.sequence);
            let _ = self.socket.send_to(&pose.bytes, pose.address);
        }
        while let Some(Datagram { address, bytes, .. }) = self.from_host.deliver(u64::MAX) {
            self.twin.receive(&bytes, address, self.now_ns()).map_err(|e| e.to_string())?;
        }
        Ok(())
    }

    fn end_event(&self) -> Value {
        let counts = self.twin.counts();
        let received: Map<String, Value> =
            counts.received.named().into_iter().map(|(name, value)| (name.into(), value.into())).collect();
        json!({
            "event": "end",
            "received": received,
            "commands_applied": counts.commands_applied,
            "forces_clamped": counts.forces_clamped,
            "injected": {
                "poses": injected_json(self.to_host.counts()),
                "commands": injected_json(self.from_host.counts()),
            },
            "longest_tick_delay_us": ns_to_us(self.longest_delay_ns),
        })
    }
}

/// Receives on a thread of its own: the time-out of a blocking socket is too coarse for ticks of 1 ms.
fn spawn_receiver(socket: &UdpSocket, start: Instant) -> Result<Receiver<Arrival>, String> {
    let socket = socket.try_clone().map_err(|e| e.to_string())?;
    let (sender, receiver) = sync_channel(ARRIVAL_CAPACITY);
    std::thread::spawn(move || {
        // One byte more than a valid datagram has, so that a longer one is not taken for a valid one when cut off.
        let mut buffer = [0; MAX_DATAGRAM_BYTES + 1];
        loop {
            match socket.recv_from(&mut buffer) {
                Ok((length, address)) => {
                    let time_ns = start.elapsed().as_nanos() as u64;
                    let bytes = buffer[..length].to_vec();
                    let datagram = Datagram { sequence: sequence(&bytes), address, bytes };
                    // What does not fit is lost, as in the socket's own queue.
                    if let Err(TrySendError::Disconnected(_)) = sender.try_send(Arrival { datagram, time_ns }) {
                        return;
                    }
                }
                // "Connection refused" reports that the host of an earlier pose is gone; others may come.
                Err(e) if matches!(e.kind(), ErrorKind::ConnectionRefused | ErrorKind::Interrupted) => {}
                Err(_) => return,
            }
        }
    });
    Ok(receiver)
}

/// The sequence number of a datagram, 0 if it is too short to have one.
fn sequence(bytes: &[u8]) -> u64 {
    let field = bytes.get(SEQUENCE_OFFSET..SEQUENCE_OFFSET + 8).filter(|_| bytes.len() >= HEADER_BYTES);
    field.and_then(|b| b.try_into().ok()).map_or(0, u64::from_le_bytes)
}

fn ns_to_us(ns: u64) -> f64 {
    ns as f64 * 1e-3
}

fn force_ended_event(end: &ForceEnd) -> Value {
    json!({
        "event": "force-ended",
        "reason": match end.reason {
            EndReason::Expired => "expired",
            EndReason::Stopped => "stopped",
        },
        "since_command_us": ns_to_us(end.since_command_ns),
        "since_expiry_us": ns_to_us(end.since_expiry_ns),
        "valid_us": ns_to_us(end.valid_ns),
    })
}

fn injected_json(counts: InjectedCounts) -> Value {
    json!({
        "sent": counts.sent,
        "lost": counts.lost,
        "lost_last": counts.lost_last,
        "duplicate": counts.duplicate,
        "late": counts.late,
        "overflow": counts.overflow,
    })
}

/// Prints a line at once. An error is ignored: whoever read the events has closed the pipe.
fn print_event(event: &Value) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{event}");
    let _ = out.flush();
}
