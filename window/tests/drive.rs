//! A whole drive: the program on a display of its own, moved by a mouse and a keyboard that the X server takes for real ones.

use pliant_mesh::Surface;
use serde_json::Value;
use std::fmt::Write;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest time that anything is waited for.
const PATIENCE: Duration = Duration::from_secs(120);
/// The middle of the picture in the window, between the panels.
const MIDDLE: [i32; 2] = [600, 400];

/// A display in memory.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn start() -> Self {
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
    fn xdotool(&self, arguments: &[&str]) {
        let run = Command::new("xdotool").env("DISPLAY", &self.name).args(arguments).output().expect("xdotool starts");
        assert!(run.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&run.stderr));
    }

    /// Gives the keyboard to the window, once it can be seen.
    fn focus(&self) {
        let began = Instant::now();
        let search = ["search", "--name", "^pliant$", "windowfocus", "--sync"];
        while !Command::new("xdotool").env("DISPLAY", &self.name).args(search).output().unwrap().status.success() {
            assert!(began.elapsed() < PATIENCE, "the window takes no focus");
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    fn move_to(&self, [x, y]: [i32; 2]) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string()]);
        std::thread::sleep(Duration::from_millis(30));
    }

    /// Holds the left button from one place to another.
    fn stroke(&self, from: [i32; 2], to: [i32; 2], steps: i32) {
        self.move_to(from);
        std::thread::sleep(Duration::from_millis(200));
        self.xdotool(&["mousedown", "1"]);
        for step in 0..=steps {
            let at = [0, 1].map(|axis: usize| from[axis] + (to[axis] - from[axis]) * step / steps.max(1));
            self.move_to(at);
        }
        std::thread::sleep(Duration::from_millis(300));
        self.xdotool(&["mouseup", "1"]);
    }

    fn key(&self, keys: &str) {
        self.xdotool(&["key", keys]);
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// The program, and its log.
struct Window {
    program: Child,
    log: PathBuf,
    read: usize,
}

impl Window {
    fn start(display: &Display, model: &Path) -> Self {
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
        window.wait("opened");
        // There is no window manager to give it the keyboard.
        display.focus();
        // The first frame of the model.
        std::thread::sleep(Duration::from_millis(500));
        window
    }

    /// Waits for an event that has not been waited for yet, and gives it.
    fn wait(&mut self, name: &str) -> Value {
        let began = Instant::now();
        loop {
            let text = std::fs::read_to_string(&self.log).unwrap_or_default();
            let complete = text.matches('\n').count();
            for (place, line) in text.lines().take(complete).enumerate().skip(self.read) {
                let event: Value = serde_json::from_str(line).unwrap();
                assert_ne!(event["event"], "failed", "{line}");
                if event["event"] == name {
                    self.read = place + 1;
                    return event;
                }
            }
            if let Some(status) = self.program.try_wait().unwrap() {
                panic!("waited for `{name}`, and the program ended with {status}:\n{text}");
            }
            assert!(began.elapsed() < PATIENCE, "waited for `{name}` in\n{text}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits until so many strokes can be taken back and made again.
    fn wait_for_history(&mut self, done: &str, undone: &str) {
        loop {
            let event = self.wait("history");
            if event["done"] == done && event["undone"] == undone {
                return;
            }
        }
    }

    /// Waits until a stroke that makes so many has ended, and the model has come to rest.
    fn wait_for_stroke(&mut self, done: &str) {
        self.wait_for_history(done, "0");
        self.wait("stroke ends");
        std::thread::sleep(Duration::from_millis(1500));
    }

    /// Saves, and gives the file.
    fn save(&mut self, display: &Display, model: &Path) -> Vec<u8> {
        display.key("ctrl+s");
        self.wait("saved");
        std::fs::read(model).unwrap()
    }

    fn close(mut self, display: &Display) {
        display.key("ctrl+q");
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

/// How far (m) a vertex has moved at most among those on one side of the plane x = 0.
fn farthest(before: &[u8], after: &[u8], side: f64) -> f64 {
    let points = |file: &[u8]| -> Vec<[f64; 3]> {
        let text = String::from_utf8_lossy(file).into_owned();
        let numbers = |line: &str| line.split_whitespace().skip(1).map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
        text.lines().filter(|line| line.starts_with("v ")).map(|line| numbers(line)[..3].try_into().unwrap()).collect()
    };
    let pairs = points(before).into_iter().zip(points(after)).filter(|(a, _)| side * a[0] > 0.02);
    pairs.map(|(a, b)| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()).fold(0.0, f64::max)
}

/// Two balls beside each other in one file, in parts of their own.
fn two_balls(folder: &Path) -> PathBuf {
    let path = folder.join("balls.obj");
    let ball = pliant_mesh::generate::sphere(16, 0.1).unwrap();
    let count = ball.positions().len();
    let mut text = String::new();
    for side in [-0.13, 0.13] {
        for p in ball.positions() {
            writeln!(text, "v {} {} {}", p[0] + side, p[1], p[2]).unwrap();
        }
    }
    for first in [1, 1 + count] {
        for corners in &Surface::from_document(&ball).triangles {
            let [a, b, c] = corners.map(|v| v as usize + first);
            writeln!(text, "f {a} {b} {c}").unwrap();
        }
    }
    std::fs::write(&path, text).unwrap();
    path
}

/// A ball of radius 100 mm.
fn ball(folder: &Path) -> PathBuf {
    let path = folder.join("ball.obj");
    let document = pliant_mesh::generate::sphere(16, 0.1).unwrap();
    let points = document.positions().to_vec();
    document.write(&points, None, &mut std::fs::File::create(&path).unwrap()).unwrap();
    path
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn open_press_grab_cut_undo_redo_save_reopen() {
    let folder = tempfile::tempdir().unwrap();
    let model = ball(folder.path());
    let original = std::fs::read(&model).unwrap();
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let [x, y] = MIDDLE;

    display.stroke(MIDDLE, [x + 40, y], 20);
    window.wait_for_stroke("1");
    let pressed = window.save(&display, &model);
    assert_ne!(pressed, original, "a press whose shape is kept changes the model");
    assert_eq!(vertices(&pressed), vertices(&original), "and no topology");

    // On both sides of the plane x = 0, as one stroke.
    display.key("x");
    display.key("4");
    display.stroke([x + 130, y - 60], [x + 210, y - 110], 30);
    window.wait_for_stroke("2");
    display.key("x");
    let grabbed = window.save(&display, &model);
    assert_eq!(vertices(&grabbed), vertices(&original), "a grab moves vertices");
    let [right, left] = [1.0, -1.0].map(|side| farthest(&pressed, &grabbed, side));
    // Nearly as far: the press before was on one side.
    assert!(right > 5e-3 && (right / left - 1.0).abs() < 0.02, "both sides are drawn out: {right} m, {left} m");

    display.key("3");
    display.stroke([x, y - 320], [x, y + 320], 60);
    window.wait_for_stroke("3");
    let cut = window.save(&display, &model);
    assert!(vertices(&cut) > vertices(&original), "a cut adds vertices");
    assert!(String::from_utf8_lossy(&cut).contains("usemtl cut"), "and faces inside of the ball");

    for (keys, done, undone, expected) in [
        ("ctrl+z", "2", "1", &grabbed),
        ("ctrl+z", "1", "2", &pressed),
        ("ctrl+z", "0", "3", &original),
        ("ctrl+shift+z", "1", "2", &pressed),
        ("ctrl+y", "2", "1", &grabbed),
        ("ctrl+y", "3", "0", &cut),
    ] {
        display.key(keys);
        window.wait_for_history(done, undone);
        assert!(window.save(&display, &model) == *expected, "{keys}: the model is what it was, to the byte");
    }
    display.key("ctrl+alt+s");
    std::thread::sleep(Duration::from_millis(500));
    display.key("Return");
    let said = window.wait("message")["text"].as_str().unwrap().to_owned();
    assert!(said.contains("pliant run") && said.contains("ball.session.toml"), "{said}");
    window.close(&display);
    let session = folder.path().join("ball");
    for arguments in [&["run", "ball.session.toml", "--out"][..], &["replay", "ball.rec", "--verify", "--out"]] {
        let ran = pliant(folder.path()).args(arguments).arg(&session).output().unwrap();
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        let made = std::fs::read(session.join("final.obj")).unwrap();
        assert!(made == cut, "{arguments:?}: the pipeline makes the bytes that the hand made");
    }

    let mut again = Window::start(&display, &model);
    let reopened = again.save(&display, &model);
    assert!(reopened == cut, "a model that nothing was done to is saved as it was");
    again.close(&display);
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn a_part_is_split_off_saved_and_joined_again_by_undo() {
    let folder = tempfile::tempdir().unwrap();
    let model = two_balls(folder.path());
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let [x, y] = MIDDLE;
    // A press, so that there is a shape to save.
    display.stroke([x - 180, y], [x - 150, y], 20);
    window.wait_for_stroke("1");
    let whole = window.save(&display, &model);
    display.move_to([x - 180, y]);
    display.key("b");
    window.wait_for_history("2", "0");
    std::thread::sleep(Duration::from_millis(1500));
    let rest = window.save(&display, &model);
    let others = || {
        let files = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
        let mut others: Vec<PathBuf> =
            files.filter(|path| path.extension().is_some_and(|e| e == "obj") && *path != model).collect();
        others.sort();
        others
    };
    let part = std::fs::read(others().first().expect("the part has a file of its own")).unwrap();
    let faces = |file: &[u8]| file.split(|byte| *byte == b'\n').filter(|line| line.starts_with(b"f ")).count();
    assert_eq!(faces(&rest) + faces(&part), faces(&whole), "the faces of the parts are those of the whole");
    assert!(vertices(&rest) < vertices(&whole) && vertices(&part) < vertices(&whole));
    display.key("ctrl+z");
    window.wait_for_history("1", "1");
    std::thread::sleep(Duration::from_millis(1500));
    assert!(window.save(&display, &model) == whole, "undo makes it one body, to the byte");
    window.close(&display);
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn killed_in_a_stroke_it_offers_the_shape_before() {
    let folder = tempfile::tempdir().unwrap();
    let model = ball(folder.path());
    let original = std::fs::read(&model).unwrap();
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let [x, y] = MIDDLE;
    display.stroke(MIDDLE, [x + 40, y], 20);
    window.wait_for_stroke("1");
    // Autosave comes a second after the stroke.
    let shape = wait_for_shape(&folder.path().join("autosave"));
    display.move_to([x - 60, y]);
    display.xdotool(&["mousedown", "1"]);
    window.wait("stroke begins");
    window.program.kill().unwrap();
    window.program.wait().unwrap();
    display.xdotool(&["mouseup", "1"]);
    assert!(std::fs::read(&model).unwrap() == original, "only Save writes the model");
    let kept = std::fs::read(&shape).unwrap();
    assert!(kept != original, "the stroke that was finished is kept");

    let mut again = Window::start(&display, &model);
    again.read = 0;
    again.wait("recovery offered");
    // The first button of the question in the middle of the window.
    display.move_to([540, 409]);
    display.xdotool(&["click", "1"]);
    again.wait("opening");
    again.wait("opened");
    let saved = again.save(&display, &model);
    assert!(saved == kept, "what is offered back is the shape after the last stroke that was finished");
    again.close(&display);
    assert!(!shape.exists(), "once it is saved it is kept no longer");
}

/// The shape in the only session's folder, once it is whole.
fn wait_for_shape(states: &Path) -> PathBuf {
    let began = Instant::now();
    loop {
        let folders = std::fs::read_dir(states).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
        // The note is written after the shape.
        if let Some(folder) = folders.into_iter().find(|folder| folder.join("session.json").is_file()) {
            return folder.join("shape.obj");
        }
        assert!(began.elapsed() < PATIENCE, "no shape was kept");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// The program beside the window, in a folder.
fn pliant(folder: &Path) -> Command {
    let path = Path::new(env!("CARGO_BIN_EXE_pliant-window")).with_file_name("pliant");
    assert!(path.is_file(), "{} is not there: build the workspace first", path.display());
    let mut command = Command::new(path);
    command.current_dir(folder);
    command
}

fn vertices(file: &[u8]) -> usize {
    file.split(|byte| *byte == b'\n').filter(|line| line.starts_with(b"v ")).count()
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn doctor_says_what_a_window_draws_with() {
    let folder = tempfile::tempdir().unwrap();
    let display = Display::start();
    let run = pliant(folder.path()).arg("doctor").env("DISPLAY", &display.name).env_remove("WAYLAND_DISPLAY").output();
    let said = run.unwrap();
    let out = String::from_utf8_lossy(&said.stdout);
    assert!(said.status.success() && out.contains("it draws with") && out.contains("OpenGL"), "{out}");
    let run = pliant(folder.path()).arg("doctor").env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").output().unwrap();
    let out = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.code() == Some(1) && out.contains("missing  window: there is no display"), "{out}");
}

#[test]
fn without_a_display_it_says_so_and_ends_with_2() {
    let run = Command::new(env!("CARGO_BIN_EXE_pliant-window"))
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(2), "{said}");
    assert!(said.contains("no display") && said.lines().count() == 1, "{said}");
}
