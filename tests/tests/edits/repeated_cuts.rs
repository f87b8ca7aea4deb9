//! Lines drawn where a cut already is.

use nalgebra::{Rotation3, UnitQuaternion};
use pliant_editor::{Draft, DraftMaterial, PaintStroke, SOLIDS, stroke_button};
use pliant_engine::edit::KINDS;
use pliant_engine::scene::Release;
use pliant_engine::session::{EventKind, HandPose, Session};
use pliant_mesh::testing::Random;
use pliant_mesh::{Surface, generate};
use pliant_solver::Vec3;
use pliant_tests::{Bench, open_drafted};

/// m
const RADIUS: f64 = 0.05;
const LEVEL: u32 = 5;

/// A ball of an editor, cut by a hand that draws a line at z = 0, with symmetry along x or without. The blade is along z.
fn cut_ball(lines: &[[Vec3; 2]]) -> Session {
    let bench = Bench::new();
    let document = generate::sphere(12, RADIUS).expect("a ball");
    let mut obj = Vec::new();
    document.write(&Surface::from_document(&document).points, None, &mut obj).expect("written");
    bench.write("model.obj", obj);
    let material = DraftMaterial::Solid { plugin: "mass-spring".into(), preset: SOLIDS[1], level: LEVEL };
    let mesh = bench.path("model.obj");
    let draft = Draft { mesh, scale: 1.0, size: 2.0 * RADIUS, subdivide: false, material, dt: 1e-3 };
    let mut session = open_drafted(&bench.write("scene.toml", draft.to_toml(&bench.path(""))));
    let edge = session.tools.iter().find_map(|slot| slot.tool.blade.clone()).expect("a blade");
    let turn = Rotation3::rotation_between(&edge.direction, &Vec3::z()).expect("not opposite");
    let rotation = UnitQuaternion::from_rotation_matrix(&turn);
    let cut = KINDS.iter().copied().find(|kind| kind.cuts()).expect("a kind that cuts");
    let button = 1 << stroke_button(cut, Release::Keep, PaintStroke::default());
    for [from, to] in lines {
        for step in 0..=500 {
            let position = from.lerp(to, (f64::from(step) / 400.0).min(1.0)) - 2.0 * RADIUS * Vec3::z();
            let buttons = if step > 20 { button } else { 0 };
            session.place_hand(0, Some(HandPose { position, rotation, buttons }));
            session.step();
        }
        session.place_hand(0, None);
        (0..100).for_each(|_| session.step());
    }
    session
}

/// Number of connected parts of the surface, and the cut area, m^2.
fn result(session: &Session) -> (u32, f64) {
    let shells = session.bodies[0].cut.as_ref().expect("a cut").surface().shells();
    let frozen = session.events.count(EventKind::Quarantine);
    assert_eq!(frozen, 0, "it goes on moving");
    (shells.iter().max().map_or(0, |last| last + 1), session.cuts().area)
}

/// A stride of the blade, m: a quarter of a cell.
const STRIDE: f64 = 0.25 * 2.0 * RADIUS / (1 << LEVEL) as f64;

/// A line through the ball at `x` (m), turned by an angle (rad) about the middle of the line.
fn line(x: f64, angle: f64) -> [Vec3; 2] {
    [1.5, -1.5].map(|share| Vec3::new(x + share * RADIUS * angle.sin(), share * RADIUS * angle.cos(), 0.0))
}

#[test]
fn a_line_that_is_drawn_again_cuts_nothing_and_a_longer_one_goes_on() {
    let mut random = Random(70);
    for case in 0..6 {
        let drawn = line(0.5 * RADIUS * random.signed(), 0.0);
        let off = [0.0, 1e-5, 1.0][case % 3] * 0.2 * STRIDE * random.signed() * Vec3::x();
        let (again, once) = (drawn.map(|point| point + off), result(&cut_ball(&[drawn])));
        assert_eq!(result(&cut_ball(&[drawn, again])), once, "case {case}, {drawn:?}, off by {off:?} m");
        let short = [drawn[0], drawn[0].lerp(&drawn[1], 0.4 + 0.2 * random.unit())];
        let (parts, area) = result(&cut_ball(&[short, again]));
        // The strip through the walls begins one stride behind, and one that the mesh refuses waits for three.
        let most = once.1 + 5.0 * STRIDE * 2.0 * RADIUS;
        assert!((2..=3).contains(&parts), "case {case}, {short:?} and {again:?}: {parts} parts");
        assert!((0.99 * once.1..most).contains(&area), "case {case}: {area} m^2 of {} m^2", once.1);
    }
}

#[test]
fn a_line_that_crosses_a_cut_cuts_all_of_its_own() {
    let mut random = Random(71);
    for case in 0..6 {
        let (x, angle) = (0.5 * RADIUS * random.signed(), 0.1 + 1.2 * random.unit());
        let once = result(&cut_ball(&[line(x, 0.0)])).1 + result(&cut_ball(&[line(x, angle)])).1;
        let (_, area) = result(&cut_ball(&[line(x, 0.0), line(x, angle)]));
        assert!((area / once - 1.0).abs() < 0.03, "case {case}, at {x} m, angle {angle}: {area} m^2 of {once} m^2");
    }
}
