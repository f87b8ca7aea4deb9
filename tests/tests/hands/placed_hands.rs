//! What a program that uses the engine as a library relies on: hands it places itself, models in memory, snapshots.

use pliant_engine::plan::Plan;
use pliant_engine::scene;
use pliant_engine::session::{EventKind, HandPose, Options, Session, SnapshotError};
use pliant_host::SearchPath;
use pliant_mesh::generate;
use pliant_mesh::geometry::Vec3;
use pliant_tests::{box_scene, deps, open};
use std::path::Path;

fn pose(position: Vec3) -> Option<HandPose> {
    Some(HandPose { position, rotation: Default::default(), buttons: 0 })
}

/// m, the frame of the hand in `box_scene` stands on the top of its block: a place `height` above that.
fn above(session: &Session, height: f64) -> Vec3 {
    session.devices[0].frame.to_scene(Vec3::new(0.0, 0.0, height))
}

#[test]
fn a_placed_hand_does_what_its_device_would_and_may_leave() {
    let (mut scripted, mut placed) = (open(&box_scene("", "", ""), 1), open(&box_scene("", "", ""), 1));
    for _ in 0..30 {
        scripted.step();
        let there = scripted.tools[0].hand.position;
        placed.place_hand(0, pose(there));
        placed.step();
        let difference = (placed.frame().tools[0].force - scripted.frame().tools[0].force).norm();
        assert!(difference <= 1e-9 * scripted.frame().tools[0].force.norm(), "{difference} N");
    }
    assert!(placed.frame().tools[0].force.norm() > 1e-3);
    assert!(placed.devices[0].device.is_none(), "its device was let go");
    placed.place_hand(0, None);
    placed.step();
    assert!(!placed.tools[0].hand.present && placed.frame().tools[0].force == Vec3::zeros());
    assert_eq!(placed.events.count(EventKind::SampleDropped), 0, "a hand that is not there drops no sample");
}

/// A tool does not cross what is between where its hand left and where it comes back.
#[test]
fn a_hand_that_comes_back_elsewhere_has_not_moved_through_the_body() {
    let mut session = open(&box_scene("", "", ""), 1);
    for height in [-0.06, 0.05] {
        let hand = above(&session, height);
        session.place_hand(0, pose(hand));
        session.step();
        session.step();
        assert_eq!(session.frame().tools[0].force, Vec3::zeros(), "free at {height} m");
        session.place_hand(0, None);
        session.step();
    }
}

#[test]
fn a_snapshot_gives_the_same_future_twice() {
    let mut session = open(&box_scene("", "", ""), 1);
    let hand = above(&session, 0.002);
    session.place_hand(0, pose(hand));
    (0..20).for_each(|_| session.step());
    let snapshot = session.snapshot();
    let mut futures = Vec::new();
    for _ in 0..2 {
        session.restore(&snapshot).expect("of the same session");
        assert_eq!(session.steps(), 20);
        (0..15).for_each(|_| session.step());
        let nodes = &session.bodies[0].system.nodes;
        futures.push((nodes.x.clone(), nodes.v.clone(), session.frame().tools[0].force));
    }
    assert_eq!(futures[0], futures[1]);
    assert!(futures[0].2.norm() > 1e-3);
}

#[test]
fn a_snapshot_of_other_bodies_is_refused() {
    let mut session = open(&box_scene("", "", ""), 1);
    let two = box_scene("", "", "").replace(
        "[[device]]",
        "[[body]]\nname = \"other\"\nshape = { kind = \"box\", size = [0.01, 0.01, 0.01] }\nmaterial = { plugin = \"mass-spring\" }\n[[device]]",
    );
    let snapshot = open(&two, 1).snapshot();
    assert_eq!(session.restore(&snapshot), Err(SnapshotError::Bodies { found: 2, expected: 1 }));
}

#[test]
fn a_model_in_memory_takes_the_place_of_a_file() {
    let text = "format = 1\n[[body]]\nmesh = \"block\"\nmaterial = { plugin = \"mass-spring\" }\n";
    let (scene, mut source) = scene::load_text(Path::new("memory"), text.to_owned(), &[]).expect("a scene");
    let document = generate::cuboid(4, [0.1, 0.2, 0.3]).expect("a block");
    let open = |source: &scene::Source| {
        let plan = Plan::new(&scene, source).expect("a plan");
        let options = Options::new(SearchPath::new(&[deps()]), 1);
        Session::open(&scene, source, plan, &options).map_err(|error| error.to_string())
    };
    let error = open(&source).err().expect("no such file");
    assert!(error.starts_with("memory:3:8: no file"), "{error}");
    source.documents.insert("block".into(), document.clone());
    let session = open(&source).expect("a session");
    assert_eq!(session.standing[0].1.surface.points, document.positions());
}
