//! A display in memory, and the hand that moves, clicks and types on it.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::CURRENT_TIME;
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{AtomEnum, ClientMessageEvent, ConnectionExt, EventMask, ImageFormat};

/// Longest time that anything is waited for.
pub const PATIENCE: Duration = Duration::from_secs(120);
/// Time between two moves of the pointer: the speed of the hand is a part of what is tested.
const PACE: Duration = Duration::from_millis(30);
/// The middle of the picture in the window, between the panels.
pub const MIDDLE: [i32; 2] = [600, 400];

/// Width and height of the rectangle in which pictures are compared, pixels.
const SEEN: [i32; 2] = [300, 140];

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

    /// Asks the program to close its window, as the button of a window manager does.
    pub fn close_window(&self) {
        let (server, screen) = x11rb::connect(Some(&self.name)).unwrap();
        let root = server.setup().roots[screen].root;
        let atom = |name: &[u8]| server.intern_atom(false, name).unwrap().reply().unwrap().atom;
        let [protocols, delete] = [&b"WM_PROTOCOLS"[..], b"WM_DELETE_WINDOW"].map(atom);
        // There is no window manager, so the window of the program is a child of the root.
        for window in server.query_tree(root).unwrap().reply().unwrap().children {
            let known = server.get_property(false, window, protocols, AtomEnum::ATOM, 0, 64).unwrap().reply().unwrap();
            if known.value32().is_some_and(|mut known| known.any(|protocol| protocol == delete)) {
                let message = ClientMessageEvent::new(32, window, protocols, [delete, CURRENT_TIME, 0, 0, 0]);
                server.send_event(false, window, EventMask::NO_EVENT, message).unwrap().check().unwrap();
            }
        }
    }

    /// What is seen in a rectangle about the middle of the picture, where no gauge is: bytes of its pixels.
    pub fn picture(&self) -> Vec<u8> {
        let (server, screen) = x11rb::connect(Some(&self.name)).unwrap();
        let root = server.setup().roots[screen].root;
        let [x, y] = [MIDDLE[0] - SEEN[0] / 2, MIDDLE[1] - SEEN[1] / 2].map(|place| place as i16);
        let [width, height] = SEEN.map(|edge| edge as u16);
        server.get_image(ImageFormat::Z_PIXMAP, root, x, y, width, height, u32::MAX).unwrap().reply().unwrap().data
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
