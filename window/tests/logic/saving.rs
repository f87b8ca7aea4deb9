//! What is asked before anything is lost.

use crate::common::{Dropped, MIDDLE, ball, sheet, stroke, wait, window};
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use pliant_window::app::App;
use pliant_window::strings;
use std::sync::Arc;

#[test]
fn a_model_that_was_not_saved_can_be_saved_before_another_one_is_opened() {
    let folder = tempfile::tempdir().unwrap();
    let (path, other) = (ball(folder.path()), sheet(folder.path()));
    let original = std::fs::read(&path).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke at rest", |app| app.status().done == 1 && app.status().is_at_rest);
    let drop_other = |harness: &mut egui_kittest::Harness<'_, App>| {
        harness.input_mut().dropped_files.push(Arc::new(Dropped(other.clone())));
        harness.run_steps(3);
        harness.get_by_label(strings::UNSAVED);
    };
    drop_other(&mut harness);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert!(harness.query_by_label(strings::UNSAVED).is_none() && harness.state().is_unsaved());
    assert_eq!(harness.state().path(), path, "Escape is Cancel");
    drop_other(&mut harness);
    harness.get_by_label(strings::SAVE).click();
    wait(&mut harness, "the other model", |app| app.is_open() && app.path() == other);
    assert_ne!(std::fs::read(&path).unwrap(), original, "the stroke was saved");
}

#[test]
fn another_file_that_is_there_is_written_over_only_after_a_question() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let (taken, before) = (folder.path().join("ball.obj2"), b"v 1 2 3\n".to_vec());
    std::fs::write(&taken, &before).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    for (answer, is_replaced) in [(strings::CANCEL, false), (strings::REPLACE, true)] {
        harness.key_press_modifiers(Modifiers::COMMAND.plus(Modifiers::SHIFT), Key::S);
        harness.run_steps(3);
        harness.event(egui::Event::Text("2".into()));
        harness.run_steps(2);
        harness.key_press(Key::Enter);
        harness.run_steps(3);
        harness.get_by_label(&strings::replace(&taken));
        assert_eq!(std::fs::read(&taken).unwrap(), before, "not yet");
        harness.get_by_label(answer).click();
        harness.run_steps(3);
        if is_replaced {
            wait(&mut harness, "the file", |app| app.last_message() == Some(&*strings::model_saved(&taken)));
        }
        assert_eq!(std::fs::read(&taken).unwrap() != before, is_replaced);
    }
}
