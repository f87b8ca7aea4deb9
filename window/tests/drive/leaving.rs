//! The window is closed, or another model is opened, in the middle of work.

use crate::display::{Display, MIDDLE};
use crate::models::{ball, two_balls};
use crate::window::Window;
use std::time::Duration;

/// Places in the question in the middle of the window: its three buttons from the left.
pub const SAVE: [i32; 2] = [520, 409];
/// See [`SAVE`].
pub const DISCARD: [i32; 2] = [585, 409];
/// See [`SAVE`].
pub const CANCEL: [i32; 2] = [670, 409];

/// Clicks a button of the question that has just been asked.
pub fn click(display: &Display, at: [i32; 2]) {
    // It takes clicks from the frame after the first that shows it, which a hand cannot be too early for.
    std::thread::sleep(Duration::from_millis(500));
    display.move_to(at);
    display.xdotool(&["click", "1"]);
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn a_window_that_is_closed_with_unsaved_strokes_asks_and_does_what_is_answered() {
    let folder = tempfile::tempdir().unwrap();
    let model = ball(folder.path());
    let original = std::fs::read(&model).unwrap();
    let display = Display::start();
    let [x, y] = MIDDLE;

    let mut window = Window::start(&display, &model);
    window.stroke(&display, [MIDDLE, [x + 40, y]], 20, "1");
    // By the window manager, then by the key.
    display.close_window();
    window.wait("unsaved");
    click(&display, CANCEL);
    display.key("ctrl+q");
    window.wait("unsaved");
    assert!(std::fs::read(&model).unwrap() == original, "nothing is written without an answer");
    click(&display, SAVE);
    window.wait("saved");
    window.wait_for_end();
    let pressed = std::fs::read(&model).unwrap();
    assert!(pressed != original, "the stroke is saved");

    // In the middle of a stroke: it ends first, and is given up.
    let mut window = Window::start(&display, &model);
    display.move_to(MIDDLE);
    display.xdotool(&["mousedown", "1"]);
    window.wait("stroke begins");
    display.move_to([x + 20, y]);
    display.close_window();
    window.wait("stroke ends");
    window.wait("unsaved");
    display.xdotool(&["mouseup", "1"]);
    click(&display, DISCARD);
    window.wait_for_end();
    assert!(std::fs::read(&model).unwrap() == pressed, "what is given up is not written");

    let window = Window::start(&display, &model);
    display.close_window();
    window.wait_for_end();
}

#[test]
#[ignore = "needs Xvfb and xdotool"]
fn a_second_model_that_is_opened_in_a_stroke_waits_for_its_end_and_for_the_answer() {
    let folder = tempfile::tempdir().unwrap();
    let (model, other) = (ball(folder.path()), two_balls(folder.path()));
    let original = std::fs::read(&model).unwrap();
    let display = Display::start();
    let mut window = Window::start(&display, &model);
    let [x, y] = MIDDLE;
    display.move_to([x, y - 100]);
    display.xdotool(&["mousedown", "1"]);
    window.wait("stroke begins");
    display.move_to([x + 20, y - 100]);
    display.key("ctrl+o");
    window.wait("dialog");
    display.key("ctrl+a");
    display.xdotool(&["type", &other.to_string_lossy()]);
    display.key("Return");
    window.wait("stroke ends");
    window.wait("unsaved");
    display.xdotool(&["mouseup", "1"]);
    click(&display, SAVE);
    window.wait("saved");
    let opening = window.wait("opening");
    assert_eq!(opening["path"].as_str(), other.to_str());
    window.wait("opened");
    assert!(std::fs::read(&model).unwrap() != original, "the stroke is saved");
    // The second model is open: it is saved as it was.
    let before = std::fs::read(&other).unwrap();
    assert!(window.save(&display, &other) == before);
    window.close(&display);
}
