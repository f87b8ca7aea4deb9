//! A ball of an editor that a hand cuts along drawn lines.

use nalgebra::{Rotation3, UnitQuaternion};
use pliant_editor::{Draft, DraftMaterial, PaintStroke, SOLIDS, stroke_button};
use pliant_engine::edit::KINDS;
use pliant_engine::scene::Release;
use pliant_engine::session::{EventKind, HandPose, Session, SessionCommand};
use pliant_mesh::{Surface, generate};
use pliant_solver::Vec3;
use pliant_tests::{Bench, open_drafted};

/// m
pub const RADIUS: f64 = 0.05;
pub const LEVEL: u32 = 5;

/// A ball of an editor, cut by a hand that draws lines at z = 0 one after the other, with symmetry along x or without. The blade is along z.
pub fn cut_ball(lines: &[[Vec3; 2]], is_mirrored: bool) -> Session {
    let bench = Bench::new();
    let document = generate::sphere(12, RADIUS).expect("a ball");
    let mut obj = Vec::new();
    document.write(&Surface::from_document(&document).points, None, &mut obj).expect("written");
    bench.write("model.obj", obj);
    let material = DraftMaterial::Solid { plugin: "mass-spring".into(), preset: SOLIDS[1], level: LEVEL };
    let mesh = bench.path("model.obj");
    let draft = Draft { mesh, scale: 1.0, size: 2.0 * RADIUS, subdivide: false, weld: None, material, dt: 1e-3 };
    let mut session = open_drafted(&bench.write("scene.toml", draft.to_toml(&bench.path(""))));
    let axes = [is_mirrored, false, false];
    assert!(session.apply(SessionCommand::SetSymmetry { axes, centre: Vec3::zeros() }));
    let edge = session.tools.iter().find_map(|slot| slot.tool.blade.clone()).expect("a blade");
    let turn = Rotation3::rotation_between(&edge.direction, &Vec3::z()).expect("not opposite");
    let rotation = UnitQuaternion::from_rotation_matrix(&turn);
    let cut = KINDS.iter().copied().find(|kind| kind.cuts()).expect("a kind that cuts");
    let button = 1 << stroke_button(cut, Release::Keep, PaintStroke::default());
    for [from, to] in lines {
        // It waits at the beginning of the line, and presses the button there.
        for step in -100..=500 {
            let position = from.lerp(to, (f64::from(step) / 400.0).clamp(0.0, 1.0)) - 2.0 * RADIUS * Vec3::z();
            let buttons = if step > 0 { button } else { 0 };
            session.place_hand(0, Some(HandPose { position, rotation, buttons }));
            session.step();
        }
        session.place_hand(0, None);
        (0..100).for_each(|_| session.step());
    }
    session
}

/// Number of connected parts of the surface, and the cut area, m^2.
pub fn result(session: &Session) -> (u32, f64) {
    let shells = session.bodies[0].cut.as_ref().expect("a cut").surface().shells();
    let frozen = session.events.count(EventKind::Quarantine);
    assert_eq!(frozen, 0, "it goes on moving");
    (shells.iter().max().map_or(0, |last| last + 1), session.cuts().area)
}
