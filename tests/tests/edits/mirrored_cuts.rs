//! Cuts with symmetry: blades that would cut the same cut once, blades that cross each other cut both lines.

use nalgebra::{Rotation3, UnitQuaternion};
use pliant_editor::{Draft, DraftMaterial, PaintStroke, SOLIDS, stroke_button};
use pliant_engine::edit::KINDS;
use pliant_engine::scene::Release;
use pliant_engine::session::{EventKind, HandPose, Session, SessionCommand};
use pliant_mesh::testing::Random;
use pliant_mesh::{Surface, generate};
use pliant_solver::Vec3;
use pliant_tests::{Bench, open_drafted};

/// m
const RADIUS: f64 = 0.05;
const LEVEL: u32 = 5;

/// A ball of an editor, cut by a hand that draws a line at z = 0, with symmetry along x or without. The blade is along z.
fn cut_ball([from, to]: [Vec3; 2], is_mirrored: bool) -> Session {
    let bench = Bench::new();
    let document = generate::sphere(12, RADIUS).expect("a ball");
    let mut obj = Vec::new();
    document.write(&Surface::from_document(&document).points, None, &mut obj).expect("written");
    bench.write("model.obj", obj);
    let material = DraftMaterial::Solid { plugin: "mass-spring".into(), preset: SOLIDS[1], level: LEVEL };
    let mesh = bench.path("model.obj");
    let draft = Draft { mesh, scale: 1.0, size: 2.0 * RADIUS, subdivide: false, material, dt: 1e-3 };
    let mut session = open_drafted(&bench.write("scene.toml", draft.to_toml(&bench.path(""))));
    let axes = [is_mirrored, false, false];
    assert!(session.apply(SessionCommand::SetSymmetry { axes, centre: Vec3::zeros() }));
    let edge = session.tools.iter().find_map(|slot| slot.tool.blade.clone()).expect("a blade");
    let turn = Rotation3::rotation_between(&edge.direction, &Vec3::z()).expect("not opposite");
    let rotation = UnitQuaternion::from_rotation_matrix(&turn);
    let cut = KINDS.iter().copied().find(|kind| kind.cuts()).expect("a kind that cuts");
    let button = 1 << stroke_button(cut, Release::Keep, PaintStroke::default());
    for step in 0..=500 {
        let position = from.lerp(&to, (f64::from(step) / 400.0).min(1.0)) - 2.0 * RADIUS * Vec3::z();
        let buttons = if step > 20 { button } else { 0 };
        session.place_hand(0, Some(HandPose { position, rotation, buttons }));
        session.step();
    }
    session.place_hand(0, None);
    (0..100).for_each(|_| session.step());
    session
}

/// Number of connected parts of the surface, and the cut area, m^2.
fn result(session: &Session) -> (u32, f64) {
    let shells = session.bodies[0].cut.as_ref().expect("a cut").surface().shells();
    let frozen = session.events.count(EventKind::Quarantine);
    assert_eq!(frozen, 0, "it goes on moving");
    (shells.iter().max().map_or(0, |last| last + 1), session.cuts().area)
}

#[test]
fn a_line_along_the_plane_of_symmetry_cuts_once_and_one_across_twice() {
    let mut random = Random(49);
    let edge = 2.0 * RADIUS / f64::from(1 << LEVEL);
    for case in 0..8 {
        // As far from the plane as makes the blades go along with each other, and farther.
        let (near, far) = (0.12 * edge * random.signed(), (0.2 + random.unit()) * edge);
        let x = if case % 2 == 0 { near } else { far };
        let line = [1.5, -1.5].map(|share| Vec3::new(x, share * RADIUS, 0.0));
        let (alone, mirrored) = (result(&cut_ball(line, false)), result(&cut_ball(line, true)));
        let [parts, times] = if case % 2 == 0 { [2, 1] } else { [3, 2] };
        assert_eq!((alone.0, mirrored.0), (2, parts), "case {case}, at {x} m");
        let off = mirrored.1 / (f64::from(times) * alone.1) - 1.0;
        assert!(off.abs() < 0.03, "case {case}, at {x} m: the area is off by {off}");
    }
    for case in 0..4 {
        // Straight across, so that both blades cut one plane from its two ends.
        let (y, rise) = (0.5 * RADIUS * random.signed(), [0.0, 1e-4][case % 2] * random.signed());
        let line = [-1.5, 1.5].map(|share| Vec3::new(share * RADIUS, y + share * rise, 0.0));
        let (alone, mirrored) = (result(&cut_ball(line, false)), result(&cut_ball(line, true)));
        assert_eq!((alone.0, mirrored.0), (2, 2), "case {case}, at {y} m, {rise}");
        // Either blade joins its cut to the other one by a strip through the wall, which may wait for three strides.
        let most = alone.1 + 8.0 * 0.25 * edge * 2.0 * RADIUS;
        assert!((0.99 * alone.1..most).contains(&mirrored.1), "case {case}, at {y} m, {rise}: {alone:?}, {mirrored:?}");
    }
    for case in 0..4 {
        let slope = (0.3 + 0.7 * random.unit()) * if case % 2 == 0 { 1.0 } else { -1.0 };
        let line = [-1.5, 1.5].map(|share| Vec3::new(share * RADIUS, slope * share * RADIUS, 0.0));
        let (alone, mirrored) = (result(&cut_ball(line, false)), result(&cut_ball(line, true)));
        // The blades lag behind their hands, so that a sliver may be left where they cross.
        assert!(alone.0 == 2 && mirrored.0 >= 4, "case {case}, slope {slope}: {alone:?}, {mirrored:?}");
        let off = mirrored.1 / (2.0 * alone.1) - 1.0;
        assert!(off.abs() < 0.03, "case {case}, slope {slope}: the area is off by {off}");
    }
}
