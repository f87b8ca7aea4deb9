//! A closed body with an open part that stands out from it, as a head has eyes: a cut through both parts the grid of both, and both are split.
//!
//! `OPEN_PARTS=0..100 cargo test --release -p pliant-tests --test cuts open_parts` draws those cases in place of the fixed ones.

use nalgebra::UnitQuaternion;
use pliant_editor::{Draft, DraftMaterial, PaintStroke, SOLIDS, stroke_button};
use pliant_engine::body::Division;
use pliant_engine::edit::KINDS;
use pliant_engine::scene::Release;
use pliant_engine::session::{HandPose, Session};
use pliant_mesh::testing::Random;
use pliant_mesh::{Surface, generate};
use pliant_solver::Vec3;
use pliant_tests::{Bench, asked_cases, open_drafted};
use std::fmt::Write;

/// Radius of the ball, m.
const BALL: f64 = 0.05;
/// Number of bodies and sides of the line that a cut leaves.
const SIDES: usize = 2;

/// A ball about the origin, and on its top a dome of this radius (m) without a floor, half of which is outside of the ball, as an OBJ file.
fn ball_with_dome(radius: f64) -> String {
    let mut text = String::new();
    let mut first = 1;
    let parts = [generate::sphere(12, BALL).expect("a ball"), generate::sphere(8, radius).expect("a ball")];
    for (part, at) in parts.iter().zip([Vec3::zeros(), (BALL - 0.3 * radius) * Vec3::z()]) {
        let surface = Surface::from_document(part);
        for point in &surface.points {
            let [x, y, z]: [f64; 3] = (point + at).into();
            writeln!(text, "v {x} {y} {z}").expect("text");
        }
        let is_kept = |corners: &&[u32; 3]| {
            at == Vec3::zeros() || corners.iter().all(|v| surface.points[*v as usize].z > -0.05 * radius)
        };
        for [a, b, c] in surface.triangles.iter().filter(is_kept).map(|corners| corners.map(|v| v + first)) {
            writeln!(text, "f {a} {b} {c}").expect("text");
        }
        first += surface.points.len() as u32;
    }
    text
}

/// Draws a blade that points up along the line from `start` to `end` (m), on a straight way.
fn draw(session: &mut Session, [start, end]: [Vec3; 2]) {
    let cut = KINDS.iter().find(|kind| kind.name() == "cut").expect("a kind");
    let button = 1 << stroke_button(*cut, Release::Keep, PaintStroke::default());
    let mut sample = |position: Vec3, buttons: u32| {
        session.place_hand(0, Some(HandPose { position, rotation: UnitQuaternion::identity(), buttons }));
        session.step();
        (session.frame().tools[0].hand - position).norm()
    };
    while sample(start, 0) > 1e-4 {}
    (1..=150).for_each(|step| _ = sample(start.lerp(&end, f64::from(step) / 150.0), button));
    while sample(end, button) > 1e-4 {}
    (0..3).for_each(|_| _ = sample(end, 0));
}

#[test]
fn a_cut_through_a_body_and_an_open_part_that_stands_out_splits_both() {
    for number in asked_cases("OPEN_PARTS").unwrap_or(0..6) {
        let bench = Bench::new();
        let random = &mut Random(number);
        let radius = BALL * (0.25 + 0.25 * random.unit());
        let mesh = bench.write("model.obj", ball_with_dome(radius));
        let level = 4 + number as u32 % 3;
        let material = DraftMaterial::Solid { plugin: "mass-spring".into(), preset: SOLIDS[1], level };
        let draft = Draft { mesh, scale: 1.0, size: 2.0 * BALL, subdivide: false, weld: None, material, dt: 1e-3 };
        let mut session = open_drafted(&bench.write("scene.toml", draft.to_toml(&bench.path(""))));
        session.keep_history();
        assert!(session.bodies[0].cut.as_ref().is_some_and(|mesh| mesh.open_triangles() > 0), "the dome is open");
        let angle = std::f64::consts::TAU * random.unit();
        let along = Vec3::new(angle.cos(), angle.sin(), 0.0);
        let aside = 0.6 * radius * random.signed() * Vec3::new(-along.y, along.x, 0.0);
        let line = [-1.5, 1.5].map(|way| aside + way * BALL * along - 1.5 * BALL * Vec3::z());
        draw(&mut session, line);
        let what = format!("{number}: a dome of {radius:.4} m at level {level}, cut along {line:?}");
        let bodies = session.split(0, Division::EachPart).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(bodies.len(), SIDES, "{what}");
        // Each body is on one side, with its piece of the dome.
        let normal = along.cross(&Vec3::z());
        let cell = session.bodies[0].discretization.edge();
        for body in bodies {
            let surface = &session.bodies[body].model.surface;
            let offsets =
                surface.triangles.iter().flatten().map(|v| (surface.points[*v as usize] - aside).dot(&normal));
            let [low, high] = offsets.fold([0.0_f64; 2], |[low, high], x| [low.min(x), high.max(x)]);
            assert!(
                low.abs().min(high) < 0.5 * cell,
                "{what}: body {body} reaches from {low} to {high} m about the line"
            );
            let top = surface.triangles.iter().flatten().map(|v| surface.points[*v as usize].z).fold(0.0, f64::max);
            assert!(top > 1.1 * BALL, "{what}: body {body} has no piece of the dome, its top is at {top} m");
        }
    }
}
