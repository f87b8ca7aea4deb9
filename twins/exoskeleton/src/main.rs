//! `pliant device emulate exoskeleton`: the twin behind a socket.
//!
//! It prints one line of JSON to standard output per event: `ready` when it listens, `connected` when a host has answered, `force-ended`
//! when a force has expired or was stopped, and `end` with all counters.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "a program of its own")]

mod emulator;

use clap::{Parser, ValueEnum};
use emulator::{Emulator, Schedule};
use pliant_exoskeleton::key::{Key, require_key};
use pliant_exoskeleton::link::DEFAULT_PEER;
use pliant_exoskeleton::wire::{MAX_TAXELS, TaxelLayout};
use pliant_twin_exoskeleton::{FingerPath, Fingers, HandModel, Impairments, Limits, Network, Twin};
use std::net::{SocketAddr, UdpSocket};
use std::process::ExitCode;

/// Position step of the emulated sensors, m; the default of the plugin's parameter `resolution`.
const POSITION_QUANTUM: f64 = 5e-5;

/// An emulated hand exoskeleton with a clock of its own and a network with adjustable impairments
#[derive(Parser)]
#[command(name = "pliant device emulate exoskeleton", version)]
struct Args {
    /// Address and port to listen at
    #[arg(long, default_value = DEFAULT_PEER)]
    address: SocketAddr,
    /// A file with 32 hexadecimal digits that the host knows too, for its owner alone; needed at an address of a network
    #[arg(long, value_name = "FILE")]
    key: Option<String>,
    /// Poses per second
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, value_parser = number(10.0, 4000.0))]
    rate: f64,
    /// Share of datagrams that are lost, in both directions
    #[arg(long, default_value_t = 0.0, value_parser = number(0.0, 1.0))]
    loss: f64,
    /// Delay of every datagram, in both directions
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = number(0.0, 1e4))]
    delay: f64,
    /// Largest additional delay, uniformly distributed
    #[arg(long, value_name = "MS", default_value_t = 0.0, value_parser = number(0.0, 1e4))]
    jitter: f64,
    /// Share of datagrams that arrive twice
    #[arg(long, default_value_t = 0.0, value_parser = number(0.0, 1.0))]
    duplicates: f64,
    /// Share of datagrams that are delayed by a further 3 ms
    #[arg(long, default_value_t = 0.0, value_parser = number(0.0, 1.0))]
    reorder: f64,
    /// Seed of the random numbers
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How the fingers follow their path
    #[arg(long, value_enum, default_value_t = HandArg::Simulated)]
    hand: HandArg,
    /// Path of the fingers, a CSV file of rows time,x,y,z,x,y,z in s and m; by default a pinch
    #[arg(long, value_name = "FILE")]
    path: Option<String>,
    /// Largest force on a fingertip
    #[arg(long, value_name = "N", default_value_t = 5.0, value_parser = number(0.0, 1e3))]
    peak_force: f64,
    /// Largest force of a taxel
    #[arg(long, value_name = "N", default_value_t = 0.073, value_parser = number(0.0, 10.0))]
    taxel_force: f64,
    /// Taxels along a finger
    #[arg(long, default_value_t = 5)]
    taxel_rows: u8,
    /// Taxels across a finger
    #[arg(long, default_value_t = 6)]
    taxel_columns: u8,
    /// End after this time
    #[arg(long = "for", value_name = "S", value_parser = number(0.0, 1e7))]
    seconds: Option<f64>,
    /// End when the host ends its session
    #[arg(long)]
    once: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum HandArg {
    /// As a mass on a spring and a damper, pushed away by the rendered force
    Simulated,
    /// Exactly, whatever force is rendered
    Keyframed,
}

impl HandArg {
    /// The simulated hand is a fingertip of 45 g at 150 N/m, damped at 0.58 of critical.
    fn model(self) -> HandModel {
        match self {
            Self::Keyframed => HandModel::Keyframed,
            Self::Simulated => HandModel::Simulated { mass: 0.045, stiffness: 150.0, damping: 3.0 },
        }
    }
}

/// Parses a number from `min` to `max`.
fn number(min: f64, max: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| match text.parse() {
        Ok(value) if (min..=max).contains(&value) => Ok(value),
        _ => Err(format!("allowed is {min} to {max}")),
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

fn run(args: &Args) -> Result<(), String> {
    let twin = twin(args)?;
    let socket = UdpSocket::bind(args.address).map_err(|e| format!("{}: {e}", args.address))?;
    let impairments = Impairments {
        loss: args.loss,
        delay_ns: ms_to_ns(args.delay),
        jitter_ns: ms_to_ns(args.jitter),
        duplicates: args.duplicates,
        reorder: args.reorder,
    };
    // The directions draw different random numbers.
    let to_host = Network::new(impairments, args.seed);
    let from_host = Network::new(impairments, !args.seed);
    let schedule = Schedule {
        tick_ns: (1e9 / args.rate) as u64,
        end_ns: args.seconds.map_or(u64::MAX, |s| (s * 1e9) as u64),
        end_with_host: args.once,
    };
    Emulator::new(twin, socket, to_host, from_host)?.run(&schedule)
}

fn twin(args: &Args) -> Result<Twin, String> {
    let layout = TaxelLayout { rows: args.taxel_rows, columns: args.taxel_columns };
    if layout.taxel_count() > MAX_TAXELS {
        return Err(format!("{} taxels; allowed is up to {MAX_TAXELS}", layout.taxel_count()));
    }
    let path = match &args.path {
        None => FingerPath::default(),
        Some(file) => {
            let text = std::fs::read_to_string(file).map_err(|e| format!("{file}: {e}"))?;
            FingerPath::parse(&text).map_err(|e| format!("{file}: {e}"))?
        }
    };
    let key = args.key.as_deref().map(Key::from_file).transpose()?;
    require_key(args.address.ip(), key.as_ref())?;
    let limits = Limits { force: args.peak_force, taxel_force: args.taxel_force as f32 };
    Ok(Twin::new(layout, key, limits, Fingers::new(path, args.hand.model(), POSITION_QUANTUM)))
}

fn ms_to_ns(ms: f64) -> u64 {
    (ms * 1e6) as u64
}
