//! Strokes that are mirrored.

use crate::common::{MIDDLE, ball, stroke, wait, window};
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use pliant_window::app::App;

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
    wait(&mut harness, "rest", |app| app.status().is_at_rest);
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
