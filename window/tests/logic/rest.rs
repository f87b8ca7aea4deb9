//! A model that nobody touches comes to rest, and a window in which nothing changes draws nothing.

use crate::common::{MIDDLE, PATIENCE, ball, pause, saved, sheet, stroke, wait, window};
use eframe::egui::ViewportId;
use egui_kittest::Harness;
use nalgebra::UnitQuaternion;
use pliant_engine::scene::Release;
use pliant_engine::session::{HandPose, Session, SessionCommand};
use pliant_live::view_buffer;
use pliant_solver::Vec3;
use pliant_window::app::App;
use pliant_window::opening::{OpenRequest, open};
use pliant_window::tools::ToolKind;
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Shows frames until none is asked for any more.
fn wait_until_idle(harness: &mut Harness<'_, App>) {
    let began = Instant::now();
    loop {
        harness.step();
        let delay = harness.output().viewport_output[&ViewportId::ROOT].repaint_delay;
        if delay == Duration::MAX {
            return;
        }
        assert!(began.elapsed() < PATIENCE, "the next picture comes after {delay:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_model_that_nobody_touches_comes_to_rest_and_its_picture_with_it() {
    for (name, model) in [("solid", ball as fn(&Path) -> _), ("sheet", sheet)] {
        let folder = tempfile::tempdir().unwrap();
        let path = model(folder.path());
        let original = std::fs::read(&path).unwrap();
        let mut harness = window(&path);
        wait(&mut harness, "the model", App::is_open);
        // The pointer stays over the model and touches nothing.
        harness.hover_at(MIDDLE);
        wait(&mut harness, "rest", |app| app.status().is_at_rest);
        wait_until_idle(&mut harness);
        harness.drag_at(MIDDLE);
        let moves = |harness: &mut Harness<'_, App>| {
            pause(harness);
            !harness.state().status().is_at_rest
        };
        let began = Instant::now();
        while !moves(&mut harness) {
            assert!(began.elapsed() < PATIENCE, "{name}: the touch wakes nothing");
        }
        harness.drop_at(MIDDLE);
        wait(&mut harness, "rest", |app| app.status().is_at_rest);
        stroke(&mut harness, MIDDLE);
        wait(&mut harness, "a stroke at rest", |app| app.status().done > 0 && app.status().is_at_rest);
        wait_until_idle(&mut harness);
        let pressed = saved(&mut harness, &path);
        assert_ne!(pressed, original, "{name}");
        (0..30).for_each(|_| pause(&mut harness));
        assert_eq!(saved(&mut harness, &path), pressed, "{name}: what is at rest stays as it is");
    }
}

/// A model as the window opens it, and the radius of its tool, m.
fn opened(path: &Path) -> (Session, f64) {
    let request = OpenRequest { level: 4, threads: 1, ..OpenRequest::new(path.to_owned()) };
    let opened = open(&request).unwrap();
    let mut session = opened.session;
    session.keep_history();
    session.apply(SessionCommand::SetSymmetry { axes: [false; 3], centre: Vec3::zeros() });
    (session, opened.facts.hand.radius)
}

fn step_at(session: &mut Session, position: Vec3, buttons: u32) {
    session.place_hand(0, Some(HandPose { position, rotation: UnitQuaternion::identity(), buttons }));
    session.step();
}

/// The point of the model that is nearest to a viewer along z.
fn top(session: &Session) -> Vec3 {
    let bounds = session.bodies[0].model.surface.bounds();
    Vec3::new(bounds.centre().x, bounds.centre().y, bounds.max.z)
}

/// Holds a button while the hand goes into the top of the model and along it, and lets go in it; a blade goes through it from side to side.
fn press(session: &mut Session, radius: f64, tool: ToolKind) {
    let (top, half) = (top(session), 0.55 * session.bodies[0].model.surface.bounds().longest_edge());
    let way = match tool.kind.cuts() {
        true => [-half, -half, half, half].map(|along| top + along * Vec3::x() - 0.5 * radius * Vec3::z()),
        false => [[0.0, 1.2], [0.0, 0.9], [0.0, 0.4], [0.5, 0.4]]
            .map(|[along, above]| top + radius * Vec3::new(along, 0.0, above)),
    };
    let button = tool.buttons(Release::Keep, Default::default());
    let steps = (0.06 / session.dt()).round() as u32;
    for (leg, ends) in way.windows(2).enumerate() {
        for step in 1..=steps {
            let at = ends[0].lerp(&ends[1], f64::from(step) / f64::from(steps));
            step_at(session, at, if leg == 0 { 0 } else { button });
        }
    }
}

/// Longest simulated time until a model is at rest, s: a sheet that was smoothed and let go swings, and only its implicit steps take its energy.
const SETTLING: f64 = 120.0;

/// Steps with the hand over the top until the session is at rest; whether it is within [`SETTLING`].
fn comes_to_rest(session: &mut Session, radius: f64) -> bool {
    let (over, steps) = (top(session) + 1.6 * radius * Vec3::z(), (SETTLING / session.dt()).round() as u32);
    (0..steps).any(|_| {
        step_at(session, over, 0);
        session.is_at_rest()
    })
}

/// Every tool on a solid and on a sheet: at rest before the stroke and after it under a hand that touches nothing, and moved at once by the next touch.
#[test]
fn a_model_is_at_rest_before_and_after_every_stroke_and_is_woken_by_a_touch() {
    let folder = tempfile::tempdir().unwrap();
    for path in [ball(folder.path()), sheet(folder.path())] {
        for tool in ToolKind::all() {
            let what = format!("{}, {}", path.display(), tool.name());
            let (mut session, radius) = opened(&path);
            assert!(comes_to_rest(&mut session, radius), "{what}: as it was opened");
            press(&mut session, radius, tool);
            let rests = comes_to_rest(&mut session, radius);
            let fastest = session.bodies[0].system.nodes.v.iter().map(|v| v.norm()).fold(0.0, f64::max);
            assert!(rests, "{what}: after the stroke: {fastest:e} m/s");
            let at_rest = top(&session) + 1.6 * radius * Vec3::z();
            let (mut writer, reader) = view_buffer(&session);
            let changes = reader.changes();
            let mut frames = |session: &mut Session| {
                for _ in 0..50 {
                    step_at(session, at_rest, 0);
                    writer.publish(session);
                }
                changes.load(Ordering::Acquire)
            };
            // The hand comes to its place, a new viewer has seen nothing yet, and cells that nothing needs are left.
            let mut seen = 0;
            let has_changed = (0..40).map(|_| frames(&mut session)).all(|now| std::mem::replace(&mut seen, now) != now);
            assert!(!has_changed, "{what}: there is always something to draw");
            let before = session.bodies[0].skin.x.clone();
            frames(&mut session);
            assert!(session.is_at_rest() && session.bodies[0].skin.x == before, "{what}: it stays at rest");
            if !tool.kind.changes_topology() {
                press(&mut session, radius, ToolKind::all()[0]);
                assert!(!session.is_at_rest(), "{what}: the next touch is felt");
            }
        }
    }
}
