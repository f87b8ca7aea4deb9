//! Blades and failure in one body: a cut through or beside what has failed, and failure beside a cut. What is shown is consistent, follows neither from
//! threads nor from the order of failures, and an undo and a replay bring it back byte for byte.

use pliant_engine::session::{Session, WarningCode};
use pliant_mesh::NO_SHELL;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_tests::breaking::{fail, is_in, random_boxes, shown, written};
use pliant_tests::{Bench, open};

/// Edges of a block, m.
const BLOCK: [f64; 3] = [0.06, 0.05, 0.04];

/// A block that nothing moves, under a blade along y that comes down at x = `at` (m) to `depth` (m) below the top between 10 and 60 ms, with further lines of the
/// edit.
fn block(at: f64, depth: f64, slant: f64, threads: usize) -> Session {
    let [from, to] = [0.03, 0.02 - depth];
    open(
        &format!(
            r#"
            format = 1
            gravity = [0, 0, -1e-9]
            [time]
            dt = 1e-3
            integrator = "backward-euler"
            [[body]]
            name = "b"
            shape = {{ kind = "box", cells = 10, size = {BLOCK:?} }}
            fixed = [{{ box = [[-9, -9, -9], [9, 9, 9]] }}]
            material = {{ plugin = "quasi-brittle", params = {{ young = 1e6, strength = 1e8, fracture-energy = 1e9, damping-time = 5e-3 }} }}
            grid = {{ level = 4, region = "whole" }}
            [[device]]
            name = "hand"
            params = {{ path = [[0, {at}, -0.06, {from}], [0.01, {at}, -0.06, {from}], [0.06, {at}, -0.06, {to}]] }}
            [[tool]]
            name = "knife"
            device = "hand"
            radius = "1 mm"
            blade = {{ length = "150 mm", direction = [{slant}, 1, 0], toughness = 0.01 }}
            [[edit]]
            kind = "cut"
            tool = "knife"
            end = 0.065
            "#
        ),
        threads,
    )
}

fn run(session: &mut Session, until: f64) {
    while session.time() < until - 1e-9 {
        session.step();
        let body = &session.bodies[0];
        assert!(body.frozen.is_none(), "{:?}", body.frozen);
    }
}

/// What is shown and written is of triangles that exist, at places that are numbers, and viewers can draw all of it.
fn check(session: &mut Session, what: &str) {
    let (surface, settled, drawn, _) = shown(session);
    assert_eq!(surface.points.len(), settled.len(), "{what}");
    assert!(settled.iter().flat_map(|p| p.iter()).all(|c| c.is_finite()), "{what}");
    let body = &session.bodies[0];
    let count = body.model.surface.triangles.len() as u32;
    let left = (0..count).filter(|t| !body.failed_triangles.contains(*t) && !body.model.is_lid(*t)).count();
    assert_eq!(drawn.len(), left, "{what}: all that is left is drawn");
    assert_eq!(written(session).1.triangles.len(), drawn.len(), "{what}: and written");
}

/// When a random block breaks, relative to the cut.
#[derive(Clone, Copy, Debug, PartialEq)]
enum When {
    Before,
    During,
    After,
}

/// A random block, cut and broken, up to 80 ms.
fn broken(seed: u64, when: When, threads: usize) -> Session {
    let mut random = Random(1000 + seed);
    let (at, depth, slant) = (0.02 * random.signed(), 0.01 + 0.045 * random.unit(), 0.3 * random.signed());
    let mut session = block(at, depth, slant, threads);
    session.keep_history();
    let boxes = random_boxes(&session.bodies[0], &mut random);
    let time = match when {
        When::Before => 2e-3,
        When::During => 0.04,
        When::After => 0.07,
    };
    run(&mut session, time);
    fail(&mut session, |point| is_in(&boxes, point));
    check(&mut session, &format!("{seed} {when:?}"));
    run(&mut session, 0.08);
    session
}

#[test]
fn what_is_shown_of_a_block_that_is_cut_and_broken_is_consistent() {
    for (seed, when) in (0..12).flat_map(|seed| [When::Before, When::During, When::After].map(|when| (seed, when))) {
        let what = format!("{seed} {when:?}");
        let mut session = broken(seed, when, 1);
        assert!(session.cuts().area > 0.0, "{what}: it was cut");
        check(&mut session, &what);
        let before = shown(&mut session);
        let bytes = written(&mut session).0;
        // Taken back past the cut, and forth again.
        let state = session.snapshot();
        assert!(session.undo(), "{what}");
        check(&mut session, &format!("{what}, undone"));
        assert!(session.redo(), "{what}");
        check(&mut session, &format!("{what}, redone"));
        assert!(shown(&mut session) == before && written(&mut session).0 == bytes, "{what}: redone");
        session.restore(&state).expect("goes back");
        assert!(shown(&mut session) == before && written(&mut session).0 == bytes, "{what}: restored");
    }
}

#[test]
fn threads_are_not_in_the_bytes_of_a_block_that_is_cut_and_broken() {
    for (seed, when) in [(0, When::Before), (1, When::During), (2, When::After)] {
        let [one, three] = [1, 3].map(|threads| {
            let mut session = broken(seed, when, threads);
            (shown(&mut session), written(&mut session).0)
        });
        assert!(one == three, "{seed} {when:?}");
    }
}

/// A local region goes on when the tool has left, as long as it has what has failed: otherwise that would be whole again.
#[test]
fn what_has_failed_in_a_local_region_stays_so_when_the_tool_has_left() {
    let scene = r#"
        format = 1
        [time]
        dt = 1e-3
        integrator = "backward-euler"
        [[body]]
        name = "b"
        shape = { kind = "box", cells = 20, size = [0.1, 0.1, 0.04] }
        material = { plugin = "quasi-brittle", params = { young = 1e5, strength = 1e8, fracture-energy = 1e9, damping-time = 5e-3 } }
        grid = { level = 5, region = "local", radius = 0.02, smooth = true }
        [[device]]
        name = "hand"
        params = { path = [[0, 0, 0, 0.03], [0.01, 0, 0, 0.03], [0.03, 0, 0, 0.024], [0.06, 0, 0, 0.024], [0.08, 0, 0, 0.05], [0.1, 0.04, 0.04, 0.05], [0.13, 0.04, 0.04, 0.024]] }
        [[tool]]
        name = "tip"
        device = "hand"
        radius = 0.005
        [[edit]]
        kind = "touch"
        tool = "tip"
        "#;
    let mut session = open(scene, 1);
    run(&mut session, 0.05);
    let around = |x: Vec3| (x - Vec3::new(0.0, 0.0, 0.02)).norm() < 0.008;
    let count = fail(&mut session, around);
    assert!(count > 10, "{count}");
    run(&mut session, 0.075);
    let failed = |session: &Session| session.bodies[0].system.failed_count();
    assert_eq!(failed(&session), count);
    run(&mut session, 0.4);
    assert_eq!(failed(&session), count, "long after the tool has left, and with another contact");
    check(&mut session, "after");
    let (surface, _, drawn, _) = shown(&mut session);
    let gone = drawn.iter().filter(|t| around(t.map(|v| surface.points[v as usize]).iter().sum::<Vec3>() / 3.0));
    let at_top = gone.filter(|t| t.iter().all(|v| (surface.points[*v as usize].z - 0.02).abs() < 1e-9)).count();
    assert_eq!(at_top, 0, "the hole is there");
    assert_eq!(session.bodies[0].parts().iter().filter(|part| **part != NO_SHELL).max(), Some(&0), "one part");
    // The scene asks for what such a body cannot have.
    let warnings = session.warnings();
    let told = warnings.iter().find(|warning| warning.code == WarningCode::SmoothIgnored).expect("a warning");
    assert!(told.place.contains("scene.toml:10:71") && told.message.contains("`quasi-brittle`"), "{told:?}");
}

/// A recording of a blade through a body whose material fails as it is bent verifies.
#[test]
fn a_blade_through_what_has_failed_replays() {
    let bench = Bench::new();
    let scene = r#"
        format = 1
        gravity = [0, 0, -9.81]
        [time]
        dt = 1e-3
        duration = 0.12
        integrator = "backward-euler"
        [[body]]
        name = "b"
        shape = { kind = "box", cells = 20, size = [0.1, 0.03, 0.03] }
        material = { plugin = "quasi-brittle", params = { young = 1e5, strength = 1500, fracture-energy = 0.2, density = 1000, damping-time = 5e-3 } }
        grid = { level = 5, region = "whole" }
        fixed = [{ box = [[-1, -1, -1], [-0.04, 1, 1]] }]
        [[device]]
        name = "hand"
        params = { path = [[0, -0.02, -0.05, 0.03], [0.02, -0.02, -0.05, 0.03], [0.1, -0.03, -0.05, -0.03]] }
        [[tool]]
        name = "knife"
        device = "hand"
        radius = "1 mm"
        blade = { length = "100 mm", direction = [0, 1, 0], toughness = 0.1 }
        [[edit]]
        kind = "cut"
        tool = "knife"
        "#;
    bench.write("scene.toml", scene);
    let run = |threads: &str, more: &[&str]| {
        bench
            .pliant(
                &[&["run", "scene.toml", "-q", "--oversubscribe", "--threads", threads, "--out", "out"][..], more]
                    .concat(),
            )
            .expect(0);
        bench.read("out/final.obj")
    };
    let one = run("1", &["--record", "cut.rec"]);
    let events = bench.summary("out")["event_counts"].clone();
    assert!(events["elements-failed"].as_u64() > Some(0), "it broke: {events}");
    assert!(one == run("3", &[]), "threads");
    bench.pliant(&["replay", "cut.rec", "--verify", "--out", "again"]).expect(0);
}
