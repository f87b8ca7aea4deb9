//! The program under test, as its log tells what happens in it.

use crate::display::{Display, PATIENCE};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// The program, and its log.
pub struct Window {
    pub program: Child,
    log: PathBuf,
    pub read: usize,
}

impl Window {
    pub fn start(display: &Display, model: &Path) -> Self {
        let log = model.with_extension("log");
        // That of a program before would be taken for the log of this one.
        let _ = std::fs::remove_file(&log);
        let program = Command::new(env!("CARGO_BIN_EXE_pliant-window"))
            .env("DISPLAY", &display.name)
            .env_remove("WAYLAND_DISPLAY")
            .args(["--antialias", "0", "--level", "5", "--autosave"])
            .arg(model.with_file_name("autosave"))
            .arg("--log")
            .args([&log, model])
            .spawn()
            .expect("the program starts");
        let mut window = Self { program, log, read: 0 };
        window.wait("model shown");
        // There is no window manager to give it the keyboard.
        display.focus();
        window
    }

    /// Waits for an event that has not been waited for yet, and gives it.
    pub fn wait(&mut self, name: &str) -> Value {
        let began = Instant::now();
        loop {
            let text = std::fs::read_to_string(&self.log).unwrap_or_default();
            let complete = text.matches('\n').count();
            for (place, line) in text.lines().take(complete).enumerate().skip(self.read) {
                let event: Value = serde_json::from_str(line).unwrap();
                if event["event"] == name {
                    self.read = place + 1;
                    return event;
                }
                assert_ne!(event["event"], "failed", "{line}");
            }
            if let Some(status) = self.program.try_wait().unwrap() {
                panic!("waited for `{name}`, and the program ended with {status}:\n{text}");
            }
            assert!(began.elapsed() < PATIENCE, "waited for `{name}` in\n{text}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits until so many strokes can be taken back and made again.
    pub fn wait_for_history(&mut self, done: &str, undone: &str) {
        loop {
            let event = self.wait("history");
            if event["done"] == done && event["undone"] == undone {
                return;
            }
        }
    }

    /// Holds the left button from one place to another, with so many moves between, and waits until the stroke that makes `done` has ended.
    pub fn stroke(&mut self, display: &Display, [from, to]: [[i32; 2]; 2], moves: i32, done: &str) {
        display.move_to(from);
        display.xdotool(&["mousedown", "1"]);
        self.wait("stroke begins");
        for step in 1..=moves.max(1) {
            display.move_to([0, 1].map(|axis: usize| from[axis] + (to[axis] - from[axis]) * step / moves.max(1)));
        }
        display.xdotool(&["mouseup", "1"]);
        self.wait("stroke ends");
        self.wait_for_history(done, "0");
    }

    /// Waits until the model is at rest, as it is after everything that was waited for before.
    pub fn wait_for_rest(&mut self) {
        let began = Instant::now();
        let is_at_rest = |line: &str| line.contains(r#""event":"rest""#).then(|| line.contains(r#""true""#));
        loop {
            let text = std::fs::read_to_string(&self.log).unwrap_or_default();
            if text.lines().filter_map(is_at_rest).next_back() == Some(true) {
                return;
            }
            assert!(began.elapsed() < PATIENCE, "the model does not come to rest:\n{text}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits until the middle of the picture looks like one that was taken before, or does not: `is_alike`.
    pub fn wait_for_picture(&self, display: &Display, before: &[u8], is_alike: bool) {
        let began = Instant::now();
        loop {
            let now = display.picture();
            let differ = now.iter().zip(before).filter(|(now, before)| now != before).count();
            let share = differ as f64 / before.len() as f64;
            // A panel covers more, and the ring of a tool less.
            match is_alike {
                true if share < 0.05 => return,
                false if share > 0.2 => return,
                _ => {}
            }
            assert!(began.elapsed() < PATIENCE, "{share} of the picture differs; it should be alike: {is_alike}");
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Number of messages so far that hold these words.
    pub fn messages(&self, words: &str) -> usize {
        let text = std::fs::read_to_string(&self.log).unwrap_or_default();
        text.lines().filter(|line| line.contains(r#""event":"message""#) && line.contains(words)).count()
    }

    /// Saves once the model has come to rest, and gives the file.
    pub fn save_at_rest(&mut self, display: &Display, model: &Path) -> Vec<u8> {
        self.wait_for_rest();
        self.save(display, model)
    }

    /// Saves, and gives the file.
    pub fn save(&mut self, display: &Display, model: &Path) -> Vec<u8> {
        display.key("ctrl+s");
        self.wait("saved");
        std::fs::read(model).unwrap()
    }

    pub fn close(self, display: &Display) {
        display.key("ctrl+q");
        self.wait_for_end();
    }

    /// Waits until the program has closed its window and ended.
    pub fn wait_for_end(mut self) {
        let began = Instant::now();
        while self.program.try_wait().unwrap().is_none() {
            assert!(began.elapsed() < PATIENCE, "it does not close");
            std::thread::sleep(Duration::from_millis(20));
        }
        assert!(self.program.wait().unwrap().success());
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// The program beside the window, in a folder.
pub fn pliant(folder: &Path) -> Command {
    let path = Path::new(env!("CARGO_BIN_EXE_pliant-window")).with_file_name("pliant");
    assert!(path.is_file(), "{} is not there: build the workspace first", path.display());
    let mut command = Command::new(path);
    command.current_dir(folder);
    command
}
