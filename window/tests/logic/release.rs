//! Where a stroke ends.

use crate::common::{MIDDLE, ball, saved, wait, window};
use eframe::egui::{self, Key, Modifiers, PointerButton, Pos2};
use pliant_window::app::App;
use pliant_window::strings;

fn button(pos: Pos2, pressed: bool) -> egui::Event {
    egui::Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

/// The drawn line of a blade, from beside the ball to beside it: the press, the way and the release come in frames as rare as they like.
#[test]
fn a_stroke_ends_where_the_button_is_let_go_however_rare_frames_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let original = std::fs::read(&path).unwrap();
    let [from, middle, to] = [-330.0, 0.0, 330.0].map(|along| MIDDLE + egui::vec2(15.0, along));
    let moved = egui::Event::PointerMoved;
    let events = [button(from, true), moved(middle), moved(to), button(to, false)];
    // Each bit: whether a frame is shown between one event and the next.
    for frames in 0..8 {
        let mut harness = window(&path);
        wait(&mut harness, "the model", App::is_open);
        harness.hover_at(from);
        harness.key_press(Key::Num3);
        harness.step();
        for (place, event) in events.iter().enumerate() {
            harness.input_mut().events.push(event.clone());
            if place == 3 || frames >> place & 1 == 1 {
                harness.step();
            }
        }
        assert!(harness.state().is_stroke_under_way(), "the blade is on its way");
        wait(&mut harness, "the end of the stroke", |app| !app.is_stroke_under_way() && app.status().is_at_rest);
        assert_eq!(harness.state().status().done, 1, "frames {frames:03b}: the ball is cut");
        let [low, high] = cut_extent(&original, &saved(&mut harness, &path));
        // The ball has a radius of 100 mm; at the ends of the line the mesh may refuse a strip. A line that ended in the frame before would end in the middle.
        assert!(low < -0.05 && high > 0.05, "frames {frames:03b}: the cut goes from {low} to {high} m");
        drop(harness);
        std::fs::write(&path, &original).unwrap();
    }
}

/// Least and greatest height (m) of the vertices that a cut has added.
fn cut_extent(before: &[u8], after: &[u8]) -> [f64; 2] {
    let heights = |file: &[u8]| -> Vec<f64> {
        let text = String::from_utf8(file.to_vec()).unwrap();
        let height = |line: &str| line.strip_prefix("v ")?.split_whitespace().nth(1)?.parse().ok();
        text.lines().filter_map(height).collect()
    };
    let added = heights(after).split_off(heights(before).len());
    added.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| [low.min(*y), high.max(*y)])
}

/// A press of a key is never without an answer.
#[test]
fn an_undo_with_nothing_to_take_back_says_so_and_so_does_a_redo() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(folder.path()));
    wait(&mut harness, "the model", App::is_open);
    for (key, text) in [(Key::Z, strings::NOTHING_TO_UNDO), (Key::Y, strings::NOTHING_TO_REDO)] {
        harness.key_press_modifiers(Modifiers::COMMAND, key);
        wait(&mut harness, text, |app| app.last_message() == Some(text));
    }
}
