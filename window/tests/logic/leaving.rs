//! The window is closed, or another model is opened, while there is work that is not saved or a stroke is in the hand.

use crate::common::{Dropped, MIDDLE, arguments, ball, pause, sheet, stroke, wait, window, window_with};
use eframe::egui::{Key, Modifiers, ViewportCommand, ViewportEvent, ViewportId, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use pliant_window::app::App;
use pliant_window::strings;
use std::path::Path;
use std::sync::Arc;

type Window = Harness<'static, App>;

/// Asks the window to close, as a window manager does; gives whether it lets that happen at once.
fn ask_to_close(harness: &mut Window) -> bool {
    let root = harness.input_mut().viewports.get_mut(&ViewportId::ROOT).unwrap();
    root.events.push(ViewportEvent::Close);
    harness.step();
    !sent(harness).contains(&ViewportCommand::CancelClose)
}

/// What the last frame asked the system's window to do.
fn sent(harness: &Window) -> Vec<ViewportCommand> {
    harness.output().viewport_output[&ViewportId::ROOT].commands.clone()
}

/// Waits until the window asks to be closed, and lets it.
fn wait_for_close(harness: &mut Window) {
    // The command is sent for one frame, so it is looked for in each.
    for _ in 0..500 {
        if sent(harness).contains(&ViewportCommand::Close) {
            assert!(ask_to_close(harness), "the window has asked for it");
            return;
        }
        pause(harness);
    }
    panic!("the window does not ask to be closed: {:?}", harness.state().error());
}

/// Shows frames until the question about work that is not saved is asked.
fn wait_for_question(harness: &mut Window) {
    for _ in 0..500 {
        if harness.query_by_label(strings::UNSAVED).is_some() {
            return;
        }
        pause(harness);
    }
    panic!("nothing is asked: {:?}", harness.state().status());
}

/// Presses on the model and draws, with the button still down.
fn hold(harness: &mut Window) {
    harness.hover_at(MIDDLE);
    (0..5).for_each(|_| pause(harness));
    harness.drag_at(MIDDLE);
    draw(harness, 0..20);
    wait(harness, "a stroke under way", |app| app.is_stroke_under_way() && app.status().begun > app.status().done);
}

fn draw(harness: &mut Window, steps: std::ops::Range<i32>) {
    for n in steps {
        harness.hover_at(MIDDLE + vec2(n as f32, 0.0));
        pause(harness);
    }
}

fn drop_file(harness: &mut Window, path: &Path) {
    harness.input_mut().dropped_files.push(Arc::new(Dropped(path.to_owned())));
    harness.step();
}

#[test]
fn a_window_without_changes_closes_and_one_with_unsaved_strokes_asks_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let original = std::fs::read(&path).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    ask_to_close(&mut harness);
    wait_for_close(&mut harness);

    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    assert!(!ask_to_close(&mut harness));
    wait_for_question(&mut harness);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert!(harness.query_by_label(strings::UNSAVED).is_none() && harness.state().is_unsaved(), "Escape is Cancel");
    assert!(!ask_to_close(&mut harness));
    wait_for_question(&mut harness);
    assert_eq!(std::fs::read(&path).unwrap(), original, "nothing is written without an answer");
    harness.get_by_label(strings::SAVE).click();
    wait_for_close(&mut harness);
    assert_ne!(std::fs::read(&path).unwrap(), original, "the stroke is saved");
}

#[test]
fn a_stroke_in_the_hand_ends_when_the_window_is_closed_and_its_press_turns_no_view() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    let camera = *harness.state().camera();
    hold(&mut harness);
    assert!(!ask_to_close(&mut harness));
    draw(&mut harness, 20..60);
    wait_for_question(&mut harness);
    assert!(!harness.state().is_stroke_under_way(), "it has ended with the button down");
    wait(&mut harness, "the stroke", |app| app.status().done == 1);
    draw(&mut harness, 60..90);
    assert_eq!(*harness.state().camera(), camera, "the button that is still down turns nothing");
    harness.drop_at(MIDDLE);
    pause(&mut harness);
    harness.get_by_label(strings::CANCEL).click();
    harness.run_steps(2);
    // The next press is a stroke again.
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "another stroke", |app| app.status().done == 2);
}

#[test]
fn another_model_that_is_dropped_in_a_stroke_waits_for_its_end_and_for_the_answer() {
    let folder = tempfile::tempdir().unwrap();
    let (path, other) = (ball(folder.path()), sheet(folder.path()));
    let original = std::fs::read(&path).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    hold(&mut harness);
    drop_file(&mut harness, &other);
    wait_for_question(&mut harness);
    wait(&mut harness, "the stroke", |app| app.status().done == 1);
    assert_eq!(harness.state().path(), path);
    harness.drop_at(MIDDLE);
    pause(&mut harness);
    harness.get_by_label(strings::SAVE).click();
    wait(&mut harness, "the other model", |app| app.is_open() && app.path() == other);
    assert_ne!(std::fs::read(&path).unwrap(), original, "the stroke is saved");
    assert!(!harness.state().is_unsaved());
}

/// What springs back leaves nothing to save.
#[test]
fn a_stroke_that_springs_back_is_let_go_without_a_question() {
    let folder = tempfile::tempdir().unwrap();
    let (path, other) = (ball(folder.path()), sheet(folder.path()));
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    harness.key_press(Key::K);
    harness.hover_at(MIDDLE);
    (0..5).for_each(|_| pause(&mut harness));
    harness.drag_at(MIDDLE);
    draw(&mut harness, 0..20);
    assert!(harness.state().is_stroke_under_way());
    drop_file(&mut harness, &other);
    wait(&mut harness, "the other model", |app| app.is_open() && app.path() == other);
}

#[test]
fn a_save_in_a_stroke_is_of_the_whole_stroke() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let original = std::fs::read(&path).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    hold(&mut harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    draw(&mut harness, 20..50);
    assert_eq!(std::fs::read(&path).unwrap(), original, "it waits for the end of the stroke");
    assert!(harness.state().is_unsaved());
    harness.drop_at(MIDDLE);
    wait(&mut harness, "saving", |app| !app.is_unsaved());
    assert_ne!(std::fs::read(&path).unwrap(), original);
}

#[test]
fn undo_and_redo_come_back_to_the_saved_shape_and_another_stroke_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saving", |app| !app.is_unsaved());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut harness, "undo", |app| app.status().done == 0 && app.is_unsaved());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Y);
    wait(&mut harness, "redo", |app| app.status().done == 1);
    assert!(!harness.state().is_unsaved(), "this is the saved shape");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut harness, "undo", |app| app.status().done == 0);
    stroke(&mut harness, MIDDLE + vec2(40.0, 30.0));
    wait(&mut harness, "another stroke", |app| app.status().done == 1);
    assert!(harness.state().is_unsaved(), "as many strokes, another shape");
}

/// The offer of a kept shape stands beside the model while strokes are made.
#[test]
fn a_kept_shape_takes_the_place_of_unsaved_strokes_only_after_a_question() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let kept = folder.path().join("autosave/1-0");
    std::fs::create_dir_all(&kept).unwrap();
    std::fs::copy(&path, kept.join("shape.obj")).unwrap();
    std::fs::write(kept.join("session.json"), format!(r#"{{"path": {path:?}, "unit": null}}"#)).unwrap();
    std::fs::write(kept.join("lock"), "").unwrap();
    let mut harness = window_with(arguments(&path));
    wait(&mut harness, "the model", App::is_open);
    harness.get_by_label(strings::RECOVER);
    // Beside the question.
    stroke(&mut harness, MIDDLE - vec2(0.0, 110.0));
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    harness.get_by_label(strings::RECOVER).click();
    wait_for_question(&mut harness);
    assert_eq!(harness.state().status().done, 1, "the strokes are still there");
    harness.get_by_label(strings::DISCARD).click();
    wait(&mut harness, "the kept shape", |app| app.is_open() && app.status().done == 0 && app.is_unsaved());
}
