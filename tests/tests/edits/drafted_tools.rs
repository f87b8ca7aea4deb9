//! Tools of an editor on every kind of body: a stroke does something that can be taken back, or it is said why it does nothing.

use nalgebra::UnitQuaternion;
use pliant_editor::{Draft, DraftMaterial, PaintStroke, SOLIDS, stroke_button};
use pliant_engine::edit::{EditKind, KINDS};
use pliant_engine::scene::Release;
use pliant_engine::session::{EventKind, HandPose, Session};
use pliant_mesh::{Surface, generate};
use pliant_solver::Vec3;
use pliant_tests::{Bench, open_drafted, root};

/// A kind of body as an editor drafts it, with the files it is of.
fn drafted(bench: &Bench, kind: &str) -> (Session, Draft) {
    let solid = |plugin: &str| DraftMaterial::Solid { plugin: plugin.into(), preset: SOLIDS[1], level: 4 };
    let write = |document: pliant_mesh::ObjDocument| {
        let mut obj = Vec::new();
        document.write(&Surface::from_document(&document).points, None, &mut obj).expect("written");
        bench.write("model.obj", String::from_utf8(obj).expect("text"));
        bench.path("model.obj")
    };
    let (mesh, scale, size, material, dt) = match kind {
        "solid" => (write(generate::cuboid(8, [0.1; 3]).expect("a cube")), 1.0, 0.1, solid("mass-spring"), 1e-3),
        "sheet" => {
            let sheet =
                DraftMaterial::Sheet { plugin: "cloth".into(), fabric: "denim".into(), held: (0..13).collect() };
            (
                write(generate::grid([12; 2], [0.1; 2], generate::Pattern::Regular).expect("a sheet")),
                1.0,
                0.1,
                sheet,
                4e-3,
            )
        }
        _ => {
            std::fs::copy(root().join("scenes/beam.msh"), bench.path("beam.msh")).expect("a file");
            (bench.path("beam.msh"), 1e-3, 0.16, solid("neo-hookean"), 1e-3)
        }
    };
    let draft = Draft { mesh, scale, size, subdivide: false, weld: None, material, dt };
    let mut session = open_drafted(&bench.write("scene.toml", draft.to_toml(&bench.path(""))));
    session.keep_history();
    (session, draft)
}

/// Holds a button while the hand goes into the top of the body, along it and out again; a blade goes through it from side to side.
fn stroke(session: &mut Session, draft: &Draft, kind: &dyn EditKind) {
    let bounds = session.bodies[0].model.surface.bounds();
    let (centre, half) = (bounds.centre(), 0.5 * (bounds.max - bounds.min));
    let radius = draft.radius();
    let top = centre + half.component_mul(&Vec3::z());
    let way = match kind.cuts() {
        true => [-1.4, -1.4, 1.4, 1.4, 1.4]
            .map(|share| top + share * half.component_mul(&Vec3::x()) - 0.6 * half.z * Vec3::z()),
        false => [
            top + 1.2 * radius * Vec3::z(),
            top + 0.9 * radius * Vec3::z(),
            top + 0.4 * radius * Vec3::z(),
            top + 0.4 * radius * Vec3::z() + 0.5 * radius * Vec3::x(),
            top + 3.0 * radius * Vec3::z(),
        ],
    };
    let button = 1 << stroke_button(kind, Release::Keep, PaintStroke::default());
    let steps = (0.08 / session.dt()).round() as usize;
    for (leg, ends) in way.windows(2).enumerate() {
        for step in 1..=steps {
            let position = ends[0].lerp(&ends[1], step as f64 / steps as f64);
            let buttons = if leg == 0 || leg == 3 { 0 } else { button };
            session.place_hand(0, Some(HandPose { position, rotation: UnitQuaternion::identity(), buttons }));
            session.step();
        }
    }
    session.place_hand(0, None);
    session.step();
}

/// What an editor hears of a stroke that left nothing: warnings and events that are not of the hand alone.
fn said(session: &Session) -> Vec<String> {
    let of_hand = [
        EventKind::SpeedLimit,
        EventKind::SampleDropped,
        EventKind::ForceSafety,
        EventKind::Substeps,
        EventKind::RepeatedStep,
    ];
    let events = session.events.described().iter().filter(|(kind, _)| !of_hand.contains(kind));
    let events = events.map(|(_, event)| event.text.clone());
    session.warnings().into_iter().map(|warning| format!("{warning:?}")).chain(events).collect()
}

#[test]
fn every_tool_does_something_to_every_body_or_says_why_not() {
    let mut silent = Vec::new();
    for body in ["solid", "sheet", "tetrahedra"] {
        for kind in KINDS.iter().copied() {
            let bench = Bench::new();
            let (mut session, draft) = drafted(&bench, body);
            let button = stroke_button(kind, Release::Keep, PaintStroke::default());
            if !session.plan().edits.iter().any(|edit| edit.button == Some(button)) {
                // The window says so before a stroke begins: `ModelFacts::why_idle`.
                assert!(kind.changes_topology() && body == "tetrahedra", "{body}, {}: it has no edit", kind.name());
                continue;
            }
            stroke(&mut session, &draft, kind);
            let done = session.history().done;
            let said = said(&session);
            println!("{body}, {}: {done} in the history, {said:?}", kind.name());
            if done == 0 && said.is_empty() {
                silent.push(format!("{body}: {}", kind.name()));
            }
        }
    }
    assert!(silent.is_empty(), "nothing happens without a word: {silent:?}");
}
