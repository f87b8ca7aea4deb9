//! Changes of the stiffness, and their history.

use crate::common::{MIDDLE, ball, stroke, wait, window};
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use pliant_window::app::App;

#[test]
fn a_change_of_the_stiffness_is_taken_back_and_made_again_as_strokes_are() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(folder.path()));
    wait(&mut harness, "the model", App::is_open);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    // Two presses right after each other are one change.
    for _ in 0..2 {
        harness.key_press(Key::Period);
        harness.step();
    }
    let is_near = |app: &App, factor: f64| (app.status().stiffness.now / factor - 1.0).abs() < 1e-3;
    wait(&mut harness, "a stiffer material", |app| is_near(app, 1.69) && app.status().done == 2);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "another stroke", |app| app.status().done == 3);
    let names = |app: &App| app.status().strokes.iter().map(|stroke| stroke.name).collect::<Vec<_>>();
    assert_eq!(names(harness.state()), ["touch", "stiffness", "touch"]);
    for (key, done, factor) in
        [(Key::Z, 2, 1.69), (Key::Z, 1, 1.0), (Key::Z, 0, 1.0), (Key::Y, 1, 1.0), (Key::Y, 2, 1.69), (Key::Y, 3, 1.69)]
    {
        harness.key_press_modifiers(Modifiers::COMMAND, key);
        wait(&mut harness, "the history", |app| app.status().done == done && is_near(app, factor));
    }
    harness.get_by_label("as opened").click_accesskit();
    wait(&mut harness, "the model as it was opened", |app| app.status().done == 0 && is_near(app, 1.0));
    // What is asked for next begins where the history is.
    harness.hover_at(MIDDLE);
    harness.key_press(Key::Period);
    wait(&mut harness, "a stiffer material", |app| is_near(app, 1.3) && app.status().done == 1);
    assert_eq!(names(harness.state()), ["stiffness"]);
}
