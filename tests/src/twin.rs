//! A twin as a process of its own, and what it says.

use crate::program;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStdout, Command, Stdio};

/// What the conformance suite asks of a device besides what it asks of every plugin.
pub const CASES_OF_A_DEVICE: [&str; 6] = [
    "limits-are-valid",
    "poses-are-valid",
    "force-stays-within-limits",
    "stop-is-immediate",
    "stale-force-expires",
    "reopened-device-is-silent",
];

/// A running twin; ended when dropped.
pub struct Twin {
    child: Child,
    lines: BufReader<ChildStdout>,
    /// Where it listens.
    pub address: String,
}

impl Twin {
    /// Starts the twin of the exoskeleton through the program, on a free port.
    ///
    /// # Panics
    /// If it does not start.
    pub fn exoskeleton(args: &[&str]) -> Self {
        Self::at("127.0.0.1:0", args)
    }

    /// The same at an address.
    ///
    /// # Panics
    /// If it does not start.
    pub fn at(address: &str, args: &[&str]) -> Self {
        let mut command = Command::new(program());
        command.args(["device", "emulate", "exoskeleton", "--address", address]).args(args);
        let mut child = command.stdout(Stdio::piped()).spawn().expect("the twin starts");
        let lines = BufReader::new(child.stdout.take().expect("piped"));
        let mut twin = Self { child, lines, address: String::new() };
        twin.address = twin.until("ready")["address"].as_str().expect("an address").to_owned();
        twin
    }

    /// What it says of the next event of a kind; others are passed over.
    ///
    /// # Panics
    /// If it ends before.
    pub fn until(&mut self, event: &str) -> Value {
        loop {
            let mut line = String::new();
            let read = self.lines.read_line(&mut line).expect("readable");
            assert!(read > 0, "the twin ended before `{event}`");
            let said: Value = serde_json::from_str(&line).unwrap_or_else(|e| panic!("{e} in {line}"));
            if said["event"] == event {
                return said;
            }
        }
    }

    /// Its process number; that of the program that started it, which it took over.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Kills it, as kill -9 does.
    ///
    /// # Panics
    /// If it cannot be.
    pub fn kill(&mut self) {
        self.child.kill().expect("killed");
        self.child.wait().expect("gone");
    }
}

impl Drop for Twin {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
