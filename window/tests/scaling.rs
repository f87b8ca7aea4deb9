//! Screens of any density: every control is on screen or can be scrolled there, and the pointer meets what it points at.

mod common;

use common::{arguments, ball, pause, wait, window_scaled};
use eframe::egui::{self, Key, Modifiers, Pos2, Rect, pos2};
use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use nalgebra::{Point3, Vector4};
use pliant_window::app::App;
use pliant_window::strings;
use pliant_window::view::Eye;
use std::path::Path;

/// Pixels of the screens on which the window is shown.
const SCREEN: [f32; 2] = [1920.0, 1200.0];
/// Pixels of a point.
const SCALES: [f32; 4] = [1.0, 1.5, 2.0, 3.0];
/// Roles of what can be used.
const CONTROLS: [Role; 9] = [
    Role::Button,
    Role::CheckBox,
    Role::RadioButton,
    Role::Slider,
    Role::SpinButton,
    Role::ComboBox,
    Role::Link,
    Role::TextInput,
    Role::Switch,
];

/// A control of the window.
#[derive(Debug)]
struct Control {
    role: Role,
    name: String,
    /// Its place among those of this role and name.
    place: usize,
}

fn controls(harness: &Harness<'_, App>) -> Vec<Control> {
    let mut found: Vec<Control> = Vec::new();
    for node in harness.query_all_by(|node| CONTROLS.contains(&node.role())) {
        let node = node.accesskit_node();
        let (role, name) = (node.role(), node.label().unwrap_or_default());
        let place = found.iter().filter(|other| other.role == role && other.name == name).count();
        found.push(Control { role, name, place });
    }
    found
}

fn rect_of(harness: &Harness<'_, App>, control: &Control) -> Option<Rect> {
    let Control { role, name, .. } = control;
    let mut all = harness.query_all_by(|node| node.role() == *role && node.label().unwrap_or_default() == *name);
    all.nth(control.place).map(|node| node.rect())
}

fn picture(harness: &Harness<'_, App>) -> Rect {
    harness.get_by_label(strings::PICTURE_OF_MODEL).rect()
}

fn window_at(path: &Path, scale: f32) -> (Harness<'static, App>, Rect) {
    let size = egui::vec2(SCREEN[0], SCREEN[1]) / scale;
    let mut harness = window_scaled(arguments(path), size, scale);
    wait(&mut harness, "the model", App::is_open);
    harness.run_steps(3);
    (harness, Rect::from_min_size(Pos2::ZERO, size))
}

#[test]
fn every_control_is_on_screen_or_can_be_scrolled_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let mut counts = Vec::new();
    for scale in SCALES {
        let (mut harness, screen) = window_at(&path, scale);
        let shown = picture(&harness);
        assert!(
            shown.width() >= 0.3 * screen.width() && screen.contains_rect(shown),
            "{scale}: the picture at {shown}"
        );
        let all = controls(&harness);
        counts.push(all.len());
        for control in &all {
            let Control { role, name, place } = control;
            let mut all =
                harness.query_all_by(|node| node.role() == *role && node.label().unwrap_or_default() == *name);
            let Some(node) = all.nth(*place) else { continue };
            let lies_over = shown.intersects(node.rect()) && !shown.contains_rect(node.rect());
            if !screen.contains_rect(node.rect()) || lies_over {
                node.scroll_to_me();
                drop(all);
                harness.run_steps(12);
            }
            let rect = rect_of(&harness, control).expect("it is still there");
            assert!(screen.expand(1.0).contains_rect(rect), "{scale}: {role:?} {name:?} is at {rect} on {screen}");
            let is_of_picture = shown.contains_rect(rect);
            assert!(
                is_of_picture || !shown.intersects(rect),
                "{scale}: {role:?} {name:?} at {rect} lies over the picture"
            );
        }
    }
    assert!(counts[0] > 40 && counts.iter().all(|count| *count == counts[0]), "as many on every screen: {counts:?}");
}

/// Where the camera draws a point of the scene.
fn to_screen(app: &App, shown: Rect, point: Point3<f64>) -> Pos2 {
    let aspect = f64::from(shown.width() / shown.height());
    let camera = app.camera();
    let matrix = camera.projection_matrix(aspect, Eye::Both) * camera.view_matrix(Eye::Both);
    let clip: Vector4<f64> = matrix * point.to_homogeneous();
    let [x, y] = [clip.x / clip.w, clip.y / clip.w].map(|c| c as f32);
    pos2(shown.center().x + 0.5 * x * shown.width(), shown.center().y - 0.5 * y * shown.height())
}

#[test]
fn a_stroke_dents_the_model_under_the_pointer_at_every_density() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let original = std::fs::read(&path).unwrap();
    for scale in SCALES {
        let (mut harness, _) = window_at(&path, scale);
        let shown = picture(&harness);
        // On the ball, which fills the picture, and off its middle.
        let half = 0.5 * shown.width().min(shown.height());
        let at = shown.center() + egui::vec2(0.3, -0.22) * half;
        harness.hover_at(at);
        (0..5).for_each(|_| pause(&mut harness));
        harness.drag_at(at);
        (0..45).for_each(|_| pause(&mut harness));
        harness.drop_at(at);
        wait(&mut harness, "a stroke at rest", |app| app.status().done == 1 && app.status().is_at_rest);
        harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
        wait(&mut harness, "saving", |app| !app.is_unsaved());
        let moved = deepest(&original, &std::fs::read(&path).unwrap());
        let seen = to_screen(harness.state(), shown, moved);
        let edge = to_screen(harness.state(), shown, moved + 0.02 * harness.state().camera().axes()[0]);
        // 20 mm of a ball of 100 mm: the tool and the vertices are that large.
        let off = (seen - at).length();
        assert!(off < (edge - seen).length(), "{scale}: the dent is drawn at {seen}, the pointer was at {at}");
        drop(harness);
        std::fs::write(&path, &original).unwrap();
    }
}

/// The vertex that has moved most, m.
fn deepest(before: &[u8], after: &[u8]) -> Point3<f64> {
    let points = |bytes: &[u8]| -> Vec<Point3<f64>> {
        let text = String::from_utf8(bytes.to_vec()).unwrap();
        let numbers = |line: &str| line.split_whitespace().skip(1).map(|n| n.parse().unwrap()).collect::<Vec<f64>>();
        text.lines().filter(|line| line.starts_with("v ")).map(|line| Point3::from_slice(&numbers(line))).collect()
    };
    let (before, after) = (points(before), points(after));
    let pairs = before.iter().zip(&after);
    *pairs.max_by(|a, b| (a.0 - a.1).norm().total_cmp(&(b.0 - b.1).norm())).expect("vertices").0
}
