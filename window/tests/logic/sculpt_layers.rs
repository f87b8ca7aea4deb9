//! Sculpt layers, by their panel.

use crate::common::{MIDDLE, ball, saved, stroke, wait, window};
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use pliant_window::app::App;

#[test]
fn a_layer_takes_strokes_is_hidden_renamed_and_deleted() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let original = std::fs::read(&path).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    harness.get_by_label("New layer").click();
    wait(&mut harness, "a layer", |app| app.status().layers.first().is_some_and(|layer| layer.records));
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 2);
    assert_ne!(saved(&mut harness, &path), original, "the stroke is in the model");
    harness.get_by_label("show layer 1").click();
    wait(&mut harness, "a hidden layer", |app| app.status().layers[0].strength == 0.0 && app.status().done == 3);
    assert!(!harness.state().status().layers[0].records && harness.state().status().layers[0].vertices > 0);
    assert_eq!(saved(&mut harness, &path), original, "a hidden layer is not in the model, to the byte");
    harness.get_by_label("show layer 1").click();
    wait(&mut harness, "a shown layer", |app| app.status().layers[0].strength == 1.0);
    assert!(harness.state().is_unsaved(), "the shape is another one");
    assert_ne!(saved(&mut harness, &path), original);
    assert_eq!(harness.state().status().done, 3, "strengths right after each other are one stroke");
    harness.get_by_label("layer 1").click();
    wait(&mut harness, "the layer records", |app| app.status().layers[0].records);
    harness.get_by_label("base").click();
    wait(&mut harness, "the base records", |app| !app.status().layers[0].records);
    harness.get_by_label("Rename").click();
    harness.run_steps(3);
    harness.event(egui::Event::Text(" of wrinkles".into()));
    harness.step();
    harness.key_press(Key::Enter);
    wait(&mut harness, "a name", |app| &*app.status().layers[0].name == "layer 1 of wrinkles");
    harness.get_by_label("Delete").click();
    wait(&mut harness, "no layer", |app| app.status().layers.is_empty());
    assert_eq!(saved(&mut harness, &path), original);
    let done = harness.state().status().done;
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut harness, "undo", |app| app.status().done == done - 1 && app.status().layers.len() == 1);
    harness.get_by_label("Merge").click();
    wait(&mut harness, "no layer", |app| app.status().layers.is_empty());
    assert_ne!(saved(&mut harness, &path), original, "the stroke is a part of the base");
}
