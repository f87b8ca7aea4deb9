//! A program that is killed in a stroke.

use crate::display::{Display, MIDDLE, PATIENCE};
use crate::models::ball;
use crate::window::Window;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn killed_in_a_stroke_it_offers_the_shape_before() {
    let folder = tempfile::tempdir().unwrap();
    let model = ball(folder.path());
    let original = std::fs::read(&model).unwrap();
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let [x, y] = MIDDLE;
    window.stroke(&display, [MIDDLE, [x + 40, y]], 20, "1");
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
