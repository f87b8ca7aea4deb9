//! Strokes that pin and paint, and their tints.

use crate::common::{MIDDLE, ball, stroke, wait, window};
use eframe::egui::{self, Key, Modifiers};
use egui_kittest::kittest::Queryable;
use pliant_engine::body::PINNED_TINT;
use pliant_window::app::App;

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
