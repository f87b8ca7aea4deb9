//! Reference images beside the model.

use crate::common::{Dropped, ball, wait, window};
use eframe::egui::{self, Key, Modifiers};
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use pliant_window::app::App;
use std::path::Path;
use std::sync::Arc;

/// Asks for a reference image by its button and types its path.
fn open_reference(harness: &mut Harness<'_, App>, path: &Path) {
    harness.get_by_role_and_label(Role::Button, "Reference image...").click_accesskit();
    harness.run_steps(2);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
    harness.event(egui::Event::Text(path.to_string_lossy().into_owned()));
    harness.run_steps(2);
    harness.key_press(Key::Enter);
}

#[test]
fn a_reference_image_is_shown_again_with_its_model_and_a_broken_one_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let image = folder.path().join("side.png");
    image::RgbaImage::new(30, 20).save(&image).unwrap();
    let broken = folder.path().join("broken.jpg");
    std::fs::write(&broken, "no image").unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    open_reference(&mut harness, &broken);
    wait(&mut harness, "an error", |app| app.error().is_some());
    let text = harness.state().error().unwrap().to_owned();
    assert!(text.contains("broken.jpg") && text.contains("allowed are PNG and JPEG"), "{text}");
    harness.run_steps(2);
    harness.get_by_label("Close").click_accesskit();
    harness.run_steps(2);
    harness.input_mut().dropped_files.push(Arc::new(Dropped(image.clone())));
    wait(&mut harness, "an image", |app| app.reference().is_some());
    let settings = harness.state().reference().unwrap().settings.clone();
    assert_eq!((settings.path, settings.height), (image.clone(), 200.0), "as high as the ball, in mm");
    harness.get_by_label("side.png").click_accesskit();
    wait(&mut harness, "a hidden image", |app| !app.reference().unwrap().settings.visible);
    harness.run_steps(2);
    drop(harness);
    let mut again = window(&path);
    wait(&mut again, "the image", |app| app.reference().is_some());
    assert!(!again.state().reference().unwrap().settings.visible, "as it was left");
    again.get_by_label("Remove").click_accesskit();
    wait(&mut again, "no image", |app| app.reference().is_none());
    again.run_steps(2);
    drop(again);
    let mut last = window(&path);
    wait(&mut last, "the model", App::is_open);
    last.run_steps(10);
    assert!(last.state().reference().is_none(), "what was removed stays away");
}
