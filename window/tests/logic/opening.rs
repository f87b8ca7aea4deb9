//! Opening and saving of models: what is asked, warned of and refused.

use crate::common::{MIDDLE, ball, stroke, wait, window};
use eframe::egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable;
use pliant_mesh::generate;
use pliant_window::app::App;
use pliant_window::strings;

#[test]
fn a_model_is_opened_pressed_undone_redone_saved_and_opened_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let original = std::fs::read(&path).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    assert!(!harness.state().is_unsaved());
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    assert!(harness.state().is_unsaved());
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saving", |app| !app.is_unsaved());
    let pressed = std::fs::read(&path).unwrap();
    assert_ne!(pressed, original, "the shape was kept");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut harness, "undo", |app| app.status().done == 0);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saving", |app| !app.is_unsaved());
    assert_eq!(std::fs::read(&path).unwrap(), original, "undo gives the model back to the byte");
    harness.get_by_label("Redo").click();
    wait(&mut harness, "redo", |app| app.status().done == 1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saving", |app| !app.is_unsaved());
    let mut again = window(&path);
    wait(&mut again, "the model", App::is_open);
    assert_eq!((again.state().status().done, again.state().is_unsaved()), (0, false));
}

#[test]
fn a_warning_of_the_session_is_a_line_with_its_code() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let body = |name: &str, x: f64| {
        format!(
            "[[body]]\nname = '{name}'\nshape = {{ kind = 'box', cells = 4, size = [0.1, 0.1, 0.1] }}\nposition = [{x}, 0, 0]\n\
             grid = {{ level = 3 }}\nmaterial = {{ plugin = 'mass-spring' }}\n"
        )
    };
    for (distance, is_warned) in [(0.05, true), (0.5, false)] {
        std::fs::write(&path, format!("format = 1\n{}{}", body("left", 0.0), body("right", distance))).unwrap();
        let mut harness = window(&path);
        wait(&mut harness, "the scene", App::is_open);
        wait(&mut harness, "a second of steps", |app| app.status().gauges.real_time_factor > 0.0);
        let codes: Vec<&str> = harness.state().status().warnings.iter().map(|warning| warning.code.name()).collect();
        assert_eq!(codes.contains(&"bodies-overlap"), is_warned, "{distance}: {codes:?}");
        assert_eq!(harness.query_by_label_contains("[bodies-overlap]").is_some(), is_warned, "{distance}");
    }
}

#[test]
fn a_broken_model_is_an_error_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 one 0\nf 1 2 3\n").unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "an error", |app| app.error().is_some());
    let error = harness.state().error().unwrap().to_owned();
    assert!(error.contains("broken.obj") && error.contains('3'), "{error}");
    // The frame that took the error may have been drawn before it.
    harness.step();
    harness.get_by_label("Close").click();
    harness.step();
    assert!(harness.state().error().is_none());
}

/// A cow of 1.8 m may be one of 4.6 cm whose file is in inches: the unit is asked for, and the answer opens it so.
#[test]
fn a_unit_that_is_unsure_is_asked_for_once() {
    let folder = tempfile::tempdir().unwrap();
    let sure = ball(folder.path());
    let mut harness = window(&sure);
    wait(&mut harness, "the model", App::is_open);
    assert!(!harness.state().asks_unit(), "20 cm in metres; in any other unit it would be a crumb");
    let unsure = folder.path().join("cow.obj");
    let document = generate::sphere(12, 0.9).unwrap();
    document.write(document.positions(), None, &mut std::fs::File::create(&unsure).unwrap()).unwrap();
    let mut harness = window(&unsure);
    wait(&mut harness, "the model", App::is_open);
    assert!(harness.state().asks_unit(), "1.8 m, or 4.6 cm in inches");
    let (radius, camera) = (harness.state().tool_radius(), *harness.state().camera());
    harness.step();
    harness.get_by_label_contains("in: the model is").click();
    wait(&mut harness, "the model in inches", |app| app.is_open() && app.tool_radius() < 0.1 * radius);
    assert!((harness.state().tool_radius() / radius - 25.4e-3).abs() < 1e-6);
    let seen = harness.state().camera();
    assert!((seen.distance / camera.distance - 25.4e-3).abs() < 1e-9, "it is as large in the picture as before");
    assert!((seen.target - 25.4e-3 * camera.target.coords).coords.norm() < 1e-9 * camera.distance);
    assert!(!harness.state().asks_unit(), "it is asked for once");
}

/// A closed model whose file has a vertex for each corner is filled, keeps its lines and may be taken apart.
#[test]
fn a_model_in_pieces_is_joined_unless_told_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pieces.obj");
    let ball = generate::sphere(12, 0.1).unwrap();
    let (mut rows, mut faces, mut next) = (String::new(), String::new(), 1);
    for face in ball.faces() {
        faces += "f";
        for corner in face.corners {
            let [x, y, z]: [f64; 3] = ball.positions()[corner.v as usize].into();
            rows += &format!("v {x:?} {y:?} {z:?}\n");
            faces += &format!(" {next}");
            next += 1;
        }
        faces += "\n";
    }
    let original = rows + &faces;
    std::fs::write(&path, &original).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    harness.step();
    harness.get_by_label(&strings::substance_reason(0, false));
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saving", |app| !app.is_unsaved());
    let saved = std::fs::read_to_string(&path).unwrap();
    let kinds = |text: &str| text.lines().map(|line| line.split(' ').next().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(kinds(&saved), kinds(&original), "no line is added");
    assert!(saved != original && saved.ends_with(&faces), "faces name the vertices that they named");
    let places = |text: &str| {
        let mut rows: Vec<String> = text.lines().filter(|line| line.starts_with("v ")).map(str::to_owned).collect();
        rows.sort_unstable();
        rows.dedup();
        rows.len()
    };
    assert_eq!(places(&saved), places(&original), "pieces still lie together");
    harness.get_by_label(strings::WELD).click();
    harness.step();
    harness.get_by_label(strings::APPLY).click();
    wait(&mut harness, "the model in pieces", |app| app.is_open() && app.status().done == 0);
    harness.step();
    let count = ball.face_count();
    harness.get_by_label(&strings::substance_reason(count, false));
}
