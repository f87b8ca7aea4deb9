//! Files that are dragged over the window and dropped on it.

use crate::common::{Dropped, MIDDLE, ball, sheet, stroke, wait, window, window_with};
use eframe::egui::HoveredFile;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use pliant_window::app::App;
use pliant_window::arguments::Arguments;
use pliant_window::strings;
use std::path::Path;
use std::sync::Arc;

fn drop_files(harness: &mut Harness<'_, App>, paths: &[&Path]) {
    for path in paths {
        harness.input_mut().dropped_files.push(Arc::new(Dropped(path.to_path_buf())));
    }
    harness.run_steps(3);
}

#[test]
fn a_file_that_is_no_model_is_named_and_the_open_model_stays() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let [notes, gone, inner] = ["notes.txt", "gone.obj", "folder.obj"].map(|name| folder.path().join(name));
    std::fs::write(&notes, "to do").unwrap();
    std::fs::create_dir(&inner).unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    let cases: [(&[&Path], &[&str]); 4] = [
        (&[&notes], &["notes.txt", "allowed are", ".obj", ".toml", ".png"]),
        (&[&gone], &["gone.obj", "there is no such file"]),
        (&[&inner], &["folder.obj", "a folder"]),
        (&[&notes, folder.path()], &["notes.txt", "allowed are"]),
    ];
    for (paths, words) in cases {
        drop_files(&mut harness, paths);
        let error = harness.state().error().expect("an error").to_owned();
        assert!(words.iter().all(|word| error.contains(word)), "{paths:?}: {error}");
        assert!(harness.query_by_label(strings::UNSAVED).is_none(), "{paths:?}: nothing is left for it");
        harness.get_by_label("Close").click();
        harness.run_steps(2);
        let state = harness.state();
        assert!(state.error().is_none() && state.is_open() && state.status().done == 1, "{paths:?}");
    }
}

/// What is said over the window while files are dragged over it is what becomes of them when they are dropped.
#[test]
fn files_that_are_dragged_over_the_window_are_announced() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let [notes, image, other] = ["notes.txt", "side.png", "other.obj"].map(|name| folder.path().join(name));
    let hover = |harness: &mut Harness<'_, App>, paths: &[&Path]| {
        let hovered = paths.iter().map(|path| HoveredFile { path: Some(path.to_path_buf()), ..HoveredFile::default() });
        harness.input_mut().hovered_files = hovered.collect();
        harness.run_steps(3);
    };
    let no_model = window_with(Arguments { path: None, ..crate::common::arguments(&path) });
    let mut with_model = window(&path);
    wait(&mut with_model, "the model", App::is_open);
    for (mut harness, of_image) in
        [(no_model, strings::image_without_model(&image)), (with_model, strings::drop_as_reference(&image))]
    {
        let cases = [
            (vec![&*other], strings::drop_to_open(&other)),
            (vec![&*image, &*other], strings::drop_to_open(&other)),
            (vec![&*image], of_image),
            (vec![&*notes], strings::not_dropped(&[&notes])),
        ];
        for (paths, text) in cases {
            hover(&mut harness, &paths);
            assert!(harness.query_by_label(&text).is_some(), "{paths:?}: {text}");
            hover(&mut harness, &[]);
            assert!(harness.query_by_label(&text).is_none(), "{paths:?}: they have gone");
        }
    }
}

#[test]
fn of_several_files_one_is_opened_and_the_others_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let (path, other) = (ball(folder.path()), sheet(folder.path()));
    let [image, second, materials] = ["side.png", "second.obj", "sheet.mtl"].map(|name| folder.path().join(name));
    image::RgbaImage::new(30, 20).save(&image).unwrap();
    std::fs::copy(&path, &second).unwrap();
    std::fs::write(&materials, "newmtl a\n").unwrap();
    let mut harness = window_with(Arguments { path: None, ..crate::common::arguments(&path) });
    drop_files(&mut harness, &[&image]);
    let error = harness.state().error().expect("an error").to_owned();
    assert!(error.contains("side.png") && error.contains("open a model first"), "{error}");
    // A model with what belongs to it: the texture is no reference image.
    drop_files(&mut harness, &[&materials, &image, &other, &second]);
    let told = harness.state().last_message().expect("a message").to_owned();
    assert!(["sheet.mtl", "side.png", "second.obj"].iter().all(|name| told.contains(name)), "{told}");
    wait(&mut harness, "the first model", |app| app.is_open() && app.path() == other);
    assert!(harness.state().reference().is_none() && harness.state().error().is_none());
    drop_files(&mut harness, &[&materials, &image]);
    wait(&mut harness, "an image", |app| app.reference().is_some());
    let told = harness.state().last_message().unwrap();
    assert!(told.contains("sheet.mtl") && told.contains("side.png"), "{told}");
}

#[test]
fn the_model_comes_back_where_another_one_cannot_be_opened() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let broken = folder.path().join("broken.obj");
    std::fs::write(&broken, "v 0 0 0\nv 1 0 0\nv 0 one 0\nf 1 2 3\n").unwrap();
    let mut harness = window(&path);
    wait(&mut harness, "the model", App::is_open);
    drop_files(&mut harness, &[&broken]);
    wait(&mut harness, "the error", |app| app.error().is_some_and(|error| error.contains("broken.obj")));
    wait(&mut harness, "the model", |app| app.is_open() && app.path() == path && !app.is_unsaved());
    assert!(harness.state().error().is_some(), "the error is still shown");
}

/// The unsaved shape is in no file of the user, and must not go with the session that cannot be opened.
#[test]
fn a_material_that_cannot_be_opened_leaves_the_present_shape() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let original = std::fs::read(&path).unwrap();
    let plugins = folder.path().join("plugins");
    std::fs::create_dir(&plugins).unwrap();
    let mut harness = window_with(Arguments { plugin_path: vec![plugins.clone()], ..crate::common::arguments(&path) });
    wait(&mut harness, "the model", App::is_open);
    stroke(&mut harness, MIDDLE);
    wait(&mut harness, "a stroke", |app| app.status().done == 1);
    let name = format!("{}pliant_cloth{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    std::fs::write(plugins.join(name), "no library").unwrap();
    harness.get_by_label(strings::SHEET).click();
    harness.run_steps(2);
    harness.get_by_label(strings::APPLY).click();
    wait(&mut harness, "the error", |app| app.error().is_some());
    wait(&mut harness, "the shape", App::is_open);
    assert!(harness.state().is_unsaved(), "it has the stroke, which is not in the file");
    crate::common::saved(&mut harness, &path);
    assert_ne!(std::fs::read(&path).unwrap(), original, "the stroke is saved");
}
