//! A tetrahedral mesh that is opened in the window by itself.

mod common;

use common::{MIDDLE, arguments, stroke, wait, window_with};
use eframe::egui::accesskit::Role;
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use pliant_window::app::App;
use pliant_window::opening::{OpenRequest, open};
use pliant_window::tools::ToolKind;
use std::path::{Path, PathBuf};

/// A copy of the beam of the shipped scene in a folder.
fn beam(folder: &Path) -> PathBuf {
    let path = folder.join("beam.msh");
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/beam.msh"), &path).unwrap();
    path
}

/// It is a solid on its own elements, and tools that it refuses say why.
#[test]
fn a_tetrahedral_mesh_is_opened_without_a_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = beam(folder.path());
    let opened = open(&OpenRequest { threads: 1, ..OpenRequest::new(path) }).unwrap_or_else(|why| panic!("{why}"));
    assert!(opened.facts.is_tetrahedral && opened.session.bodies[0].discretization.lattice().is_some());
    assert!(opened.scene.body[0].is_tetrahedral());
    for tool in ToolKind::all() {
        let divides = ["cut", "stitch"].contains(&tool.name());
        assert_eq!(opened.facts.why_idle(tool).is_some(), divides, "{}", tool.name());
    }
}

/// It is pressed, Save asks for a name, and a name that only a mesh could have is refused in words, which the list of messages shows too.
#[test]
fn a_tetrahedral_mesh_is_sculpted_and_saved_as_its_surface() {
    let folder = tempfile::tempdir().unwrap();
    let path = beam(folder.path());
    let original = std::fs::read(&path).unwrap();
    let mut harness = window_with(arguments(&path));
    wait(&mut harness, "the model", App::is_open);
    // The knife does nothing here, and a message says so.
    harness.key_press(Key::Num3);
    stroke(&mut harness, MIDDLE);
    harness.key_press(Key::Num1);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    let count = harness.state().message_count();
    harness.get_by_role_and_label(Role::Button, &pliant_window::strings::messages(count)).click_accesskit();
    harness.run_steps(3);
    let shown = harness.query_all_by_label_contains("neither cut nor stitched").count();
    assert!(shown > 0, "the message is in the list, whole");
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    for (name, is_written) in [("other.msh", false), ("beam.obj", true)] {
        harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
        harness.run_steps(3);
        let field = harness.get_by_role(Role::TextInput);
        field.focus();
        let wanted = folder.path().join(name);
        harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
        harness.get_by_role(Role::TextInput).type_text(&wanted.display().to_string());
        harness.run_steps(2);
        harness.get_all_by_role_and_label(Role::Button, "Save as...").last().unwrap().click_accesskit();
        harness.run_steps(3);
        if is_written {
            wait(&mut harness, "saving", |app| !app.is_unsaved());
        } else {
            let error = harness.state().error().expect("a sentence").to_owned();
            assert!(error.contains("other.msh") && error.contains(".obj"), "{error}");
            harness.key_press(Key::Escape);
            harness.run_steps(2);
        }
        assert_eq!(wanted.is_file(), is_written, "{name}");
    }
    assert_eq!(std::fs::read(&path).unwrap(), original, "the file that was opened is as it was");
}
