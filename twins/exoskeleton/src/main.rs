//! `pliant device emulate exoskeleton`: the twin behind a socket.
//!
//! One line of JSON on standard output for each thing that happens: `ready`, `met`, `zero` (a force that ended, and how long
//! after the last command), `end` with every counter.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program of its own")]

use clap::{Parser, ValueEnum};
use pliant_exoskeleton::key::Key;
use pliant_exoskeleton::link::DEFAULT_PEER;
use pliant_exoskeleton::wire::{HEADER, Layout, MOST_BYTES, MOST_TAXELS};
use pliant_twin_exoskeleton::{Ended, Fingers, Hand, Injected, Limits, Network, Path, Twin, Weather};
use serde_json::{Map, Value, json};
use std::io::{ErrorKind, Write};
use std::net::{SocketAddr, UdpSocket};
use std::process::ExitCode;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

/// A stand-in for a hand exoskeleton, with a clock of its own and a network as bad as you like
#[derive(Parser)]
#[command(name = "pliant device emulate exoskeleton", version)]
struct Args {
    /// Where it listens
    #[arg(long, default_value = DEFAULT_PEER)]
    address: SocketAddr,
    /// A file with 32 hexadecimal digits the host knows too
    #[arg(long, value_name = "FILE")]
    key: Option<String>,
    /// Poses a second
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, value_parser = number(10.0, 4000.0))]
    rate: f64,
    /// Share of datagrams that get lost, both ways
    #[arg(long, default_value_t = 0.0, value_parser = number(0.0, 1.0))]
    loss: f64,
    /// Of every datagram, both ways
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = number(0.0, 1e4))]
    delay: f64,
    /// At most, on top of the delay
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = number(0.0, 1e4))]
    jitter: f64,
    /// Share that arrives twice
    #[arg(long, default_value_t = 0.0, value_parser = number(0.0, 1.0))]
    duplicates: f64,
    /// Share that is held back for 3 ms
    #[arg(long, default_value_t = 0.0, value_parser = number(0.0, 1.0))]
    reorder: f64,
    /// Of all that is random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How the fingers follow their path
    #[arg(long, value_enum, default_value_t = HandArg::Simulated)]
    hand: HandArg,
    /// Keyframes, a CSV file of rows time,x,y,z,x,y,z; by default a pinch
    #[arg(long, value_name = "FILE")]
    path: Option<String>,
    /// Most force of a fingertip
    #[arg(long, value_name = "N", default_value_t = 5.0, value_parser = number(0.0, 1e3))]
    peak_force: f64,
    /// Most force of a taxel
    #[arg(long, value_name = "N", default_value_t = 0.073, value_parser = number(0.0, 10.0))]
    taxel_force: f64,
    /// Taxels along a finger
    #[arg(long, default_value_t = 5)]
    taxel_rows: u8,
    /// Taxels across a finger
    #[arg(long, default_value_t = 6)]
    taxel_columns: u8,
    /// Ends after this time
    #[arg(long = "for", value_name = "S", value_parser = number(0.0, 1e7))]
    seconds: Option<f64>,
    /// Ends when its host goes
    #[arg(long)]
    once: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum HandArg {
    /// A mass on a spring and a damper: what it feels moves it
    Simulated,
    /// Goes where the path says
    Keyframed,
}

fn number(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| match text.parse() {
        Ok(value) if (least..=most).contains(&value) => Ok(value),
        _ => Err(format!("allowed is {least} to {most}")),
    }
}

fn main() -> ExitCode {
    match run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(text) => {
            eprintln!("error: {text}");
            ExitCode::from(2)
        }
    }
}

/// ns
fn ms(ms: f64) -> u64 {
    (ms * 1e6) as u64
}

fn set_up(args: &Args) -> Result<(Twin, UdpSocket, [Network; 2]), String> {
    let layout = Layout { rows: args.taxel_rows, columns: args.taxel_columns };
    if layout.taxels() > MOST_TAXELS {
        return Err(format!("{} taxels; allowed is up to {MOST_TAXELS}", layout.taxels()));
    }
    let path = match &args.path {
        None => Path::default(),
        Some(file) => {
            let text = std::fs::read_to_string(file).map_err(|e| format!("{file}: {e}"))?;
            Path::parse(&text).map_err(|e| format!("{file}: {e}"))?
        }
    };
    let hand = match args.hand {
        HandArg::Keyframed => Hand::Keyframed,
        HandArg::Simulated => Hand::Simulated { mass: 0.045, stiffness: 150.0, damping: 3.0 },
    };
    let key = args.key.as_deref().map(Key::from_file).transpose()?;
    let limits = Limits { force: args.peak_force, taxel: args.taxel_force as f32 };
    let twin = Twin::new(layout, key, limits, Fingers::new(path, hand, 5e-5));
    let socket = UdpSocket::bind(args.address).map_err(|e| format!("{}: {e}", args.address))?;
    let weather = Weather {
        loss: args.loss,
        delay: ms(args.delay),
        jitter: ms(args.jitter),
        duplicates: args.duplicates,
        reorder: args.reorder,
    };
    Ok((twin, socket, [Network::new(weather, args.seed), Network::new(weather, !args.seed)]))
}

fn run(args: &Args) -> Result<(), String> {
    let (mut twin, socket, [mut out, mut back]) = set_up(args)?;
    let start = Instant::now();
    let now = || start.elapsed().as_nanos() as u64;
    let tick = (1e9 / args.rate) as u64;
    let end = args.seconds.map_or(u64::MAX, |s| (s * 1e9) as u64);
    say(json!({ "event": "ready", "address": socket.local_addr().map_err(|e| e.to_string())?.to_string() }));
    let (mut due, mut late, mut met) = (tick, 0, false);
    let mut bytes = [0; MOST_BYTES];
    let heard = listen(&socket, start)?;
    loop {
        let wake = [Some(due), out.next(), back.next(), Some(end)].into_iter().flatten().min().unwrap_or(due);
        let mut wait = Duration::from_nanos(wake.saturating_sub(now()));
        while let Ok((bytes, from, arrived)) = heard.recv_timeout(wait) {
            back.send(&bytes, (sequence(&bytes), from), arrived);
            wait = Duration::ZERO;
        }
        let time = now();
        while let Some((packet, from)) = back.pass(time) {
            if twin.take(&packet, from, time) {
                out.begin();
            }
        }
        if twin.is_met() && !met {
            say(json!({ "event": "met", "peer": twin.peer().map(|p| p.to_string()) }));
        }
        let gone = met && twin.peer().is_none();
        met = twin.is_met();
        if time >= due {
            late = late.max(time - due);
            due = time.max(due + tick);
            if let Some(zero) = twin.advance(time) {
                let us = |ns: u64| ns as f64 * 1e-3;
                say(json!({
                    "event": "zero",
                    "why": if zero.ended == Ended::Expired { "expired" } else { "stopped" },
                    "after_us": us(zero.after), "past_us": us(zero.past), "valid_us": us(zero.valid),
                }));
            }
            if let Some((length, peer)) = twin.tell(&mut bytes, time, false) {
                out.send(&bytes[..length], (twin.told(), peer), time);
            }
        }
        while let Some((packet, peer)) = out.pass(time) {
            let _ = socket.send_to(&packet, peer);
        }
        if time >= end || (gone && args.once) {
            break;
        }
    }
    // What is still on its way arrives, and the last word is not lost.
    while let Some((packet, peer)) = out.pass(u64::MAX) {
        let _ = socket.send_to(&packet, peer);
    }
    if let Some((length, peer)) = twin.tell(&mut bytes, now(), true) {
        out.passed_by(twin.told());
        let _ = socket.send_to(&bytes[..length], peer);
    }
    while let Some((packet, from)) = back.pass(u64::MAX) {
        twin.take(&packet, from, now());
    }
    say(end_of(&twin, &out, &back, late));
    Ok(())
}

/// Datagrams as they arrive, with who sent them and when, ns: a socket's own time-out is too coarse for a kilohertz.
fn listen(socket: &UdpSocket, start: Instant) -> Result<Receiver<(Vec<u8>, SocketAddr, u64)>, String> {
    let socket = socket.try_clone().map_err(|e| e.to_string())?;
    let (send, receive) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let mut packet = [0; MOST_BYTES + 1];
        loop {
            match socket.recv_from(&mut packet) {
                Ok((length, from)) => {
                    let arrived = start.elapsed().as_nanos() as u64;
                    if send.send((packet[..length].to_vec(), from, arrived)).is_err() {
                        return;
                    }
                }
                // A host that has gone away.
                Err(e) if matches!(e.kind(), ErrorKind::ConnectionRefused | ErrorKind::Interrupted) => {}
                Err(_) => return,
            }
        }
    });
    Ok(receive)
}

/// The sequence number of a datagram, 0 where there is none.
fn sequence(bytes: &[u8]) -> u64 {
    let at = bytes.get(32..40).filter(|_| bytes.len() >= HEADER);
    at.and_then(|b| b.try_into().ok()).map_or(0, u64::from_le_bytes)
}

fn end_of(twin: &Twin, out: &Network, back: &Network, late: u64) -> Value {
    let (counts, obeyed, clamped) = twin.counts();
    let injected = |i: Injected| json!({ "sent": i.sent, "lost": i.lost, "lost_last": i.lost_last, "duplicate": i.duplicate, "late": i.late });
    let received: Map<String, Value> = counts.named().into_iter().map(|(n, v)| (n.into(), v.into())).collect();
    json!({
        "event": "end", "received": received, "obeyed": obeyed, "clamped": clamped,
        "injected": { "poses": injected(out.injected()), "commands": injected(back.injected()) },
        "latest_tick_us": late as f64 * 1e-3,
    })
}

fn say(line: Value) {
    let mut out = std::io::stdout().lock();
    let _ = writeln!(out, "{line}");
    let _ = out.flush();
}
