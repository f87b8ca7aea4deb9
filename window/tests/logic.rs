//! What happens in the window, without a graphics card: keys, pointer, panels and files, through the names that screen readers hear.

mod common;

use common::{MIDDLE, arguments, ball, pause, saved, stroke, wait, window_with};
use eframe::egui::{self, Key, Modifiers, PointerButton};
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use pliant_engine::body::PINNED_TINT;
use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{Options, Session, SessionCommand};
use pliant_host::SearchPath;
use pliant_mesh::generate;
use pliant_record::{Recording, state_digest, write_model_to};
use pliant_window::app::App;
use pliant_window::gl::Wireframe;
use pliant_window::strings;
use pliant_window::view::cube::{CubeFace, visible_faces};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

fn window(path: &Path) -> Harness<'static, App> {
    window_with(arguments(path))
}

/// A file that is dropped on the window.
#[derive(Debug)]
struct Dropped(PathBuf);

impl egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|error| error.to_string())
    }
}

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

/// What was done by hand, with strokes taken back and another size of tool, comes back to the bit from the saved session, also after
/// Save has written over the model.
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

#[test]
fn a_mirrored_stroke_is_one_stroke_and_symmetric() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let original = std::fs::read(&path).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    harness.hover_at(MIDDLE);
    harness.key_press(Key::X);
    harness.step();
    harness.get_by_label("mirror along Y").click();
    harness.run_steps(2);
    harness.hover_at(MIDDLE);
    harness.key_press(Key::Z);
    harness.step();
    assert_eq!(harness.state().tool().1.symmetry, [true; 3]);
    stroke(&mut harness, MIDDLE + egui::vec2(60.0, -40.0));
    wait(&mut harness, "one stroke for all images", |app| app.status().done == 1);
    std::thread::sleep(Duration::from_millis(1500));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    wait(&mut harness, "saving", |app| !app.is_unsaved());
    let moved = displaced(&original, &std::fs::read(&path).unwrap());
    let depth = |octant: usize| {
        let is_in =
            |at: &[f64; 3]| (0..3).all(|axis| at[axis].abs() > 0.01 && (at[axis] < 0.0) == (octant >> axis & 1 == 1));
        moved.iter().filter(|(at, _)| is_in(at)).map(|(_, by)| *by).fold(0.0, f64::max)
    };
    let depths: Vec<f64> = (0..8).map(depth).collect();
    // The numbers of the file are rounded, those of the shape are mirror images to the bit.
    assert!(depths[0] > 1e-3 && depths.iter().all(|depth| (depth / depths[0] - 1.0).abs() < 1e-4), "{depths:?}");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    wait(&mut harness, "one undo for all", |app| app.status().done == 0);
}

/// Places (file units) of the vertices that differ between two files, and by how much.
fn displaced(before: &[u8], after: &[u8]) -> Vec<([f64; 3], f64)> {
    let places = |file: &[u8]| -> Vec<[f64; 3]> {
        let lines = String::from_utf8(file.to_vec()).unwrap();
        let of_line = |line: &str| {
            let mut numbers = line.strip_prefix("v ")?.split_whitespace().map(|n| n.parse::<f64>().unwrap());
            Some([numbers.next()?, numbers.next()?, numbers.next()?])
        };
        lines.lines().filter_map(of_line).collect()
    };
    let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
    let pairs = places(before).into_iter().zip(places(after));
    pairs.map(|(a, b)| (a, distance(&a, &b))).filter(|(_, by)| *by > 0.0).collect()
}

#[test]
fn keys_and_panels_change_tool_view_and_size() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(folder.path()));
    wait(&mut harness, "the model", App::is_open);
    assert_eq!(harness.state().tool().0.name(), "touch");
    harness.hover_at(MIDDLE);
    harness.key_press(Key::Num2);
    harness.step();
    assert_eq!(harness.state().tool().0.name(), "pull");
    harness.get_by_label("3  cut").click();
    harness.step();
    assert_eq!(harness.state().tool().0.name(), "cut");
    harness.key_press(Key::W);
    harness.step();
    assert_eq!(harness.state().view().wireframe, Wireframe::Over);
    harness.get_by_label("only").click();
    harness.step();
    assert_eq!(harness.state().view().wireframe, Wireframe::Only);
    let size = harness.state().tool().1.size;
    harness.key_press(Key::CloseBracket);
    harness.step();
    assert!(harness.state().tool().1.size > size);
    let before = harness.state().camera().yaw;
    harness.event(egui::Event::PointerMoved(MIDDLE));
    harness.event(egui::Event::PointerButton {
        pos: MIDDLE,
        button: PointerButton::Middle,
        pressed: true,
        modifiers: Modifiers::NONE,
    });
    harness.step();
    harness.event(egui::Event::PointerMoved(MIDDLE + egui::vec2(80.0, 0.0)));
    harness.step();
    assert!((harness.state().camera().yaw - before).abs() > 0.1, "the middle button turns the view");
    harness.event(egui::Event::PointerButton {
        pos: MIDDLE,
        button: PointerButton::Middle,
        pressed: false,
        modifiers: Modifiers::NONE,
    });
    harness.get_by_label("look from +X").click();
    harness.step();
    harness.step();
    assert!(harness.state().camera().axes()[2].x > 0.999, "the axes in the corner are buttons");
}

#[test]
fn a_pin_and_a_painted_stroke_are_tinted_and_taken_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(folder.path()));
    wait(&mut harness, "the model", App::is_open);
    for (key, name) in [(Key::M, "pin"), (Key::P, "paint")] {
        harness.hover_at(MIDDLE);
        harness.key_press(key);
        harness.step();
        assert_eq!(harness.state().tool().0.name(), name);
        assert_eq!(harness.state().tints().count(), 0);
        stroke(&mut harness, MIDDLE);
        wait(&mut harness, "a tint", |app| app.tints().count() > 3);
        let tints: Vec<f32> = harness.state().tints().collect();
        let expected = if name == "pin" {
            tints.iter().all(|tint| *tint == PINNED_TINT)
        } else {
            tints.iter().all(|tint| *tint > 0.0 && *tint < 1.0)
        };
        assert!(expected, "{name}: {tints:?}");
        wait(&mut harness, "the stroke in the history", |app| app.status().done == 1);
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        wait(&mut harness, "no tint", |app| app.tints().count() == 0);
    }
}

/// With Ctrl what `paint` raises is lowered, and the panel chooses what is painted: of a sheet there is a thickness, of a solid none.
#[test]
fn paint_lowers_with_ctrl_and_paints_what_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(folder.path()));
    wait(&mut harness, "the model", App::is_open);
    harness.hover_at(MIDDLE);
    harness.key_press(Key::P);
    harness.run_steps(2);
    assert!(harness.query_by_label("thickness").is_none(), "a solid has no thickness");
    for (param, modifiers, raises) in [
        ("stiffness", Modifiers::COMMAND, false),
        ("density", Modifiers::NONE, true),
        ("density", Modifiers::COMMAND, false),
    ] {
        harness.get_by_label(param).click_accesskit();
        harness.run_steps(2);
        harness.event(egui::Event::ModifiersChanged(modifiers));
        stroke(&mut harness, MIDDLE);
        harness.event(egui::Event::ModifiersChanged(Modifiers::NONE));
        wait(&mut harness, "a tint", |app| app.tints().count() > 3);
        let tints: Vec<f32> = harness.state().tints().collect();
        let is_expected = tints.iter().all(|tint| if raises { *tint > 0.0 } else { *tint < 0.0 } && tint.abs() < 1.0);
        assert!(is_expected, "{param} {raises}: {tints:?}");
        wait(&mut harness, "the stroke in the history", |app| app.status().done == 1);
        harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        wait(&mut harness, "no tint", |app| app.tints().count() == 0);
    }
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
        (0..20).for_each(|_| pause(&mut harness));
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
    let radius = harness.state().tool_radius();
    harness.step();
    harness.get_by_label_contains("in: the model is").click();
    wait(&mut harness, "the model in inches", |app| app.is_open() && app.tool_radius() < 0.1 * radius);
    assert!((harness.state().tool_radius() / radius - 25.4e-3).abs() < 1e-6);
    assert!(!harness.state().asks_unit(), "it is asked for once");
}

/// Without a mouse: arrow keys bring the pointer over the model, Space presses and lets go, Tab and names reach the controls.
#[test]
fn a_stroke_is_made_by_keys_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(folder.path()));
    wait(&mut harness, "the model", App::is_open);
    let yaw = harness.state().camera().yaw;
    harness.key_down_modifiers(Modifiers::ALT, Key::ArrowRight);
    (0..10).for_each(|_| pause(&mut harness));
    harness.key_up_modifiers(Modifiers::ALT, Key::ArrowRight);
    harness.step();
    assert!((harness.state().camera().yaw - yaw).abs() > 0.01, "Alt and an arrow turn the view");
    harness.key_down(Key::ArrowLeft);
    (0..5).for_each(|_| pause(&mut harness));
    harness.key_up(Key::ArrowLeft);
    harness.key_press(Key::Space);
    harness.key_down(Key::ArrowRight);
    (0..30).for_each(|_| pause(&mut harness));
    harness.key_up(Key::ArrowRight);
    harness.key_press(Key::Space);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    harness.key_press(Key::Period);
    wait(&mut harness, "a stiffer material", |app| app.status().stiffness.now > 1.2);
    harness.key_press(Key::Comma);
    wait(&mut harness, "the stiffness of before", |app| (app.status().stiffness.now - 1.0).abs() < 1e-6);
}

#[test]
fn the_list_of_keys_is_on_screen_until_it_is_closed() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(folder.path()));
    wait(&mut harness, "the model", App::is_open);
    let shown = |harness: &mut Harness<'_, App>, is_shown: bool| {
        harness.run_steps(4);
        for (heading, keys) in strings::KEYS {
            let found = harness.query_by_label(heading).map(|node| node.rect());
            assert_eq!(found.is_some(), is_shown, "{heading}");
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1200.0, 800.0));
            assert!(found.is_none_or(|rect| screen.contains_rect(rect)), "{heading} at {found:?}");
            let effects = keys.iter().filter(|(_, effect)| harness.query_by_label(effect).is_some()).count();
            assert_eq!(effects, if is_shown { keys.len() } else { 0 }, "{heading}");
        }
    };
    shown(&mut harness, false);
    harness.key_press(Key::F1);
    shown(&mut harness, true);
    harness.key_press(Key::Escape);
    shown(&mut harness, false);
    harness.get_by_label(strings::KEYS_BUTTON).click();
    shown(&mut harness, true);
    harness.get_by_label("Close").click();
    shown(&mut harness, false);
}

/// What can be clicked has a name that screen readers say.
#[test]
fn every_control_has_a_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(folder.path()));
    wait(&mut harness, "the model", App::is_open);
    let mut count = 0;
    for role in [Role::Button, Role::CheckBox, Role::RadioButton, Role::Slider, Role::SpinButton, Role::ComboBox] {
        for control in harness.query_all_by_role(role) {
            let node = control.accesskit_node();
            let name = node.label().or(node.value()).unwrap_or_default();
            assert!(!name.trim().is_empty(), "{role:?} at {:?} has no name", node.bounding_box());
            count += 1;
        }
    }
    assert!(count > 40, "{count} controls");
}

/// Where frames are rare, a press, the way after it and its end come in one of them: the stroke is made where the button was pressed, and the view stays.
#[test]
fn a_line_that_is_drawn_within_one_frame_cuts_and_turns_no_view() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let mut harness = window_with(arguments(&path));
    wait(&mut harness, "the model", App::is_open);
    let view = *harness.state().camera();
    let [from, to] = [MIDDLE - egui::vec2(0.0, 330.0), MIDDLE + egui::vec2(0.0, 330.0)];
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    let events = &mut harness.input_mut().events;
    // The key of the knife comes in the same frame.
    let key = |pressed| egui::Event::Key {
        key: Key::Num3,
        physical_key: None,
        pressed,
        repeat: false,
        modifiers: Modifiers::NONE,
    };
    events.extend([key(true), key(false)]);
    events.extend([egui::Event::PointerMoved(from), button(from, true), egui::Event::PointerMoved(to)]);
    harness.step();
    harness.input_mut().events.push(button(to, false));
    wait(&mut harness, "the cut", |app| app.status().done == 1);
    assert_eq!(harness.state().status().strokes[0].name, "cut");
    assert_eq!(*harness.state().camera(), view, "the view has not turned");
}

#[test]
fn a_click_on_a_face_of_the_cube_looks_from_there() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(&ball(folder.path()));
    wait(&mut harness, "the model", App::is_open);
    harness.step();
    let picture = harness.get_by_label(strings::PICTURE_OF_MODEL).rect();
    // Where the axes are, in the upper right corner.
    let centre = picture.right_top() + egui::vec2(-56.0, 56.0);
    let turn = |harness: &mut Harness<'_, App>, round: usize| {
        let side = if round % 2 == 0 { 9.0 } else { -9.0 };
        harness.hover_at(MIDDLE);
        for step in 0..8 {
            let at = MIDDLE + egui::vec2(13.0 + 4.0 * round as f32, side) * step as f32;
            harness.event(egui::Event::PointerMoved(at));
            let (pressed, button) = (step < 7, PointerButton::Middle);
            if step == 0 || !pressed {
                harness.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers: Modifiers::NONE });
            }
            harness.step();
        }
    };
    let mut seen = std::collections::BTreeSet::new();
    for round in 0..24 {
        turn(&mut harness, round);
        let axes = harness.state().camera().axes();
        // The ends of the axes, 38 points from the middle, lie over the cube where they point towards the viewer or away.
        let ends: Vec<egui::Vec2> = (0..6)
            .map(|end| if end < 3 { 38.0 } else { -38.0 } * egui::vec2(axes[0][end % 3] as f32, -axes[1][end % 3] as f32))
            .collect();
        let middle_of = |face: &CubeFace| face.corners.iter().fold(egui::Vec2::ZERO, |sum, corner| sum + *corner) / 4.0;
        let is_free = |face: &CubeFace| ends.iter().all(|end| (*end - middle_of(face)).length() > 16.0);
        let faces: Vec<CubeFace> = visible_faces(axes, 15.0).into_iter().filter(is_free).collect();
        let Some(face) = faces.get((round / 2) % faces.len().max(1)).copied() else { continue };
        let middle = middle_of(&face);
        harness.hover_at(centre + middle);
        harness.step();
        harness.event(egui::Event::PointerButton {
            pos: centre + middle,
            button: PointerButton::Primary,
            pressed: true,
            modifiers: Modifiers::NONE,
        });
        harness.step();
        harness.event(egui::Event::PointerButton {
            pos: centre + middle,
            button: PointerButton::Primary,
            pressed: false,
            modifiers: Modifiers::NONE,
        });
        harness.run_steps(2);
        let back = harness.state().camera().axes()[2];
        // From above and below the view stops a little before the pole.
        assert!(back.dot(&face.normal()) > 0.99, "{face:?}: seen from {back:?}");
        seen.insert((face.axis, face.is_negative));
    }
    assert!(seen.len() >= 3, "{seen:?}");
    assert!(!harness.state().is_unsaved(), "no click was a stroke");
}

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
