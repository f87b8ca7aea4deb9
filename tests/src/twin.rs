//! Running a twin as a process and reading its events.

use crate::program;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::{Child, ChildStdout, Command, Stdio};

/// The cases of the conformance suite that only devices have.
pub const CASES_OF_A_DEVICE: [&str; 6] = [
    "limits-are-valid",
    "poses-are-valid",
    "force-stays-within-limits",
    "stop-is-immediate",
    "stale-force-expires",
    "reopened-device-is-silent",
];

/// A running twin; killed when dropped.
pub struct Twin {
    child: Child,
    lines: BufReader<ChildStdout>,
    /// Address and port it listens at.
    pub address: String,
}

impl Twin {
    /// Starts the twin of the exoskeleton with `pliant device emulate`, on a free port of the loopback interface.
    ///
    /// # Panics
    /// If it does not start.
    pub fn exoskeleton(args: &[&str]) -> Self {
        Self::at("127.0.0.1:0", args)
    }

    /// Starts the twin of the exoskeleton at an address.
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

    /// Waits for the next event of a kind and returns it; skips other events.
    ///
    /// # Panics
    /// If the twin ends before.
    pub fn until(&mut self, event: &str) -> Value {
        loop {
            let mut line = String::new();
            let read = self.lines.read_line(&mut line).expect("readable");
            assert!(read > 0, "the twin ended before `{event}`");
            let value: Value = serde_json::from_str(&line).unwrap_or_else(|e| panic!("{e} in {line}"));
            if value["event"] == event {
                return value;
            }
        }
    }

    /// Its process id: `pliant device emulate` replaces itself by the twin.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Kills it with SIGKILL.
    ///
    /// # Panics
    /// If the system refuses.
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
