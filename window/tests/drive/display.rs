//! A display in memory, and the hand that moves, clicks and types on it.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time that anything is waited for.
pub const PATIENCE: Duration = Duration::from_secs(120);
/// Time between two moves of the pointer: the speed of the hand is a part of what is tested.
const PACE: Duration = Duration::from_millis(30);
/// The middle of the picture in the window, between the panels.
pub const MIDDLE: [i32; 2] = [600, 400];

/// A display in memory.
pub struct Display {
    server: Child,
    pub name: String,
}

impl Display {
    pub fn start() -> Self {
        let mut server = Command::new("Xvfb")
            // It stays as it is when the program, its only client, is killed.
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp", "-noreset"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        Self { server, name: format!(":{}", number.trim()) }
    }

    /// Moves, clicks and types as a hand does.
    pub fn xdotool(&self, arguments: &[&str]) {
        let run = Command::new("xdotool").env("DISPLAY", &self.name).args(arguments).output().expect("xdotool starts");
        assert!(run.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&run.stderr));
    }

    /// Gives the keyboard to the window, once it can be seen.
    pub fn focus(&self) {
        let began = Instant::now();
        let search = ["search", "--name", "^pliant$", "windowfocus", "--sync"];
        while !Command::new("xdotool").env("DISPLAY", &self.name).args(search).output().unwrap().status.success() {
            assert!(began.elapsed() < PATIENCE, "the window takes no focus");
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Moves the pointer, as often in a second as a hand that is sampled by the window.
    pub fn move_to(&self, [x, y]: [i32; 2]) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
        std::thread::sleep(PACE);
    }

    pub fn key(&self, keys: &str) {
        self.xdotool(&["key", keys]);
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
