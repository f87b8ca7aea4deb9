//! The view: what turns it and what does not.

use crate::common::{MIDDLE, ball, wait, window};
use eframe::egui::{self, Key, Modifiers, PointerButton};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use pliant_window::app::App;
use pliant_window::strings;
use pliant_window::view::cube::{CubeFace, visible_faces};

/// Where frames are rare, a press, the way after it and its end come in one of them: the stroke is made where the button was pressed, and the view stays.
#[test]
fn a_line_that_is_drawn_within_one_frame_cuts_and_turns_no_view() {
    let folder = tempfile::tempdir().unwrap();
    let path = ball(folder.path());
    let mut harness = window(&path);
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
        let side = if round.is_multiple_of(2) { 9.0 } else { -9.0 };
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
