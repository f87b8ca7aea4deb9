//! Saved sessions give the same states again.

use crate::common::{MIDDLE, ball, stroke, wait, window};
use eframe::egui::{self, Key, Modifiers};
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session, SessionCommand};
use pliant_host::SearchPath;
use pliant_record::{Recording, state_digest, write_model_to};
use pliant_window::app::App;
use std::path::Path;

/// A recording, whose session gave the same states when it was taken again.
fn replayed(file: &Path) -> Recording {
    let recording = Recording::read(file).unwrap();
    let header = &recording.header;
    let (scene, source) = scene::load_text(&header.scene, header.text.clone(), &recording.settings).unwrap();
    let plan = Plan::new(&scene, &source).unwrap();
    let search = SearchPath::new(&[]);
    let recorded = Some(recording.devices.clone());
    let options = Options { mesh: header.mesh.clone(), recorded, ..Options::new(search, 1) };
    let mut session = Session::open(&scene, &source, plan, &options).unwrap();
    session.drive_tips();
    session.keep_history();
    for step in &recording.steps {
        for repeat in 0..step.count {
            step.commands.iter().filter(|_| repeat == 0).for_each(|command| _ = session.apply(command.clone()));
            session.step_with(&step.poses);
            session.report_device_forces(&step.device_forces);
            assert_eq!(state_digest(&session), step.digest, "at {} s", session.time());
        }
    }
    recording
}

/// Saves the session beside its model by the keys of the dialog.
fn save_session(harness: &mut Harness<'_, App>, file: &Path) {
    harness.key_press_modifiers(Modifiers::COMMAND.plus(Modifiers::ALT), Key::S);
    harness.step();
    harness.step();
    harness.key_press(Key::Enter);
    let scene = file.with_extension("session.toml");
    wait(harness, "the session", |_| file.is_file() && scene.is_file());
}

#[test]
fn a_session_in_another_material_is_there_after_the_window_has_closed() {
    let folder = tempfile::tempdir().unwrap();
    let model = ball(folder.path());
    let mut harness = window(&model);
    wait(&mut harness, "the model", App::is_open);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    harness.get_by_role_and_label(Role::CheckBox, "Divide large faces").click_accesskit();
    harness.run_steps(2);
    harness.get_by_role_and_label(Role::Button, "Apply").click_accesskit();
    wait(&mut harness, "the shape in another material", |app| app.is_open() && app.status().done == 0);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "another stroke", |app| app.status().done == 1);
    let file = folder.path().join("ball.rec");
    save_session(&mut harness, &file);
    let files = Recording::read(&file).unwrap().header.files.clone();
    let shape = &files.iter().find(|file| !file.plugin).expect("a model").path;
    assert!(shape.is_file() && *shape != model);
    drop(harness);
    assert!(!shape.exists(), "{} is gone with the window", shape.display());
    assert!(replayed(&file).step_count() > 10);
    let (scene, source) = scene::load(&file.with_extension("session.toml"), &[]).unwrap();
    let plan = Plan::new(&scene, &source).unwrap();
    Session::open(&scene, &source, plan, &Options::new(SearchPath::new(&[]), 1)).unwrap();
}

/// What was done by hand, with strokes taken back and another size of tool, comes back to the bit from the saved session, also after
/// Save has written over the model.
#[test]
fn a_saved_session_gives_the_same_states_again() {
    let folder = tempfile::tempdir().unwrap();
    let model = ball(folder.path());
    let before = std::fs::read(&model).unwrap();
    let mut harness = window(&model);
    wait(&mut harness, "the model", App::is_open);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut harness, "undo", |app| app.status().done == 0);
    harness.key_press(Key::CloseBracket);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "another stroke", |app| app.status().done == 1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "the file", |app| !app.is_unsaved());
    assert_ne!(std::fs::read(&model).unwrap(), before);
    let file = folder.path().join("ball.rec");
    save_session(&mut harness, &file);
    assert_eq!(std::fs::read(folder.path().join("ball.original.obj")).unwrap(), before);
    let recording = replayed(&file);
    let undone = |command: &SessionCommand| *command == SessionCommand::Undo;
    assert!(recording.steps.iter().flat_map(|step| &step.commands).any(undone));

    // The scene beside it takes its hands from the recording; its steps are the same, and the model is the one that Save wrote.
    let (scene, source) = scene::load(&file.with_extension("session.toml"), &[]).unwrap();
    let plan = Plan::new(&scene, &source).unwrap();
    let options = Options::new(SearchPath::new(&[]), 2);
    let mut session = Session::open(&scene, &source, plan, &options).unwrap();
    assert_eq!(scene.time.steps(), recording.step_count());
    for step in recording.steps.iter().flat_map(|step| (0..step.count).map(move |_| step)) {
        session.step();
        assert_eq!(state_digest(&session), step.digest, "at {} s", session.time());
    }
    session.update_surface();
    let mut written = Vec::new();
    write_model_to(&session.bodies[0], &session.plan().cap_material, &mut written).unwrap();
    assert!(written == std::fs::read(&model).unwrap(), "the bytes of the model that was saved");
}
