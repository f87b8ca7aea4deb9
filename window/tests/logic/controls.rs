//! Keys, buttons and their names.

use crate::common::{MIDDLE, ball, pause, wait, window};
use eframe::egui::{self, Key, Modifiers, PointerButton};
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use pliant_window::app::App;
use pliant_window::gl::Wireframe;
use pliant_window::strings;

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
