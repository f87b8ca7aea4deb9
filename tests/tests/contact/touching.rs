//! What a hand does to a body and feels of it, step by step.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_solver::Pool;
use pliant_tests::{NOW, box_scene, open};

/// A block touched from above; `path` of the hand relative to the top, z up.
fn touched(time: &str, tool: &str, edit: &str, path: &str) -> Session {
    let scene = box_scene(time, "", "")
        .replace("path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]]", path)
        .replace("radius = \"4 mm\"", &format!("radius = \"4 mm\"\n{tool}"))
        .replace("tool = \"finger\"", &format!("tool = \"finger\"\n{edit}"));
    open(&scene, 1)
}

const PRESS: &str = "path = [[0.0, 0.0, 0.0, 0.006], [0.02, 0.0, 0.0, 0.002]]";

#[test]
fn a_hand_in_the_air_feels_nothing_and_moves_nothing() {
    let mut session = touched("", "", "", "path = [[0.0, 0.0, 0.0, 0.03], [0.05, 0.01, 0.0, 0.02]]");
    for _ in 0..50 {
        session.step();
        assert_eq!((session.frame().tools[0].force, session.frame().nodes), (Vec3::zeros(), 0));
    }
    session.update_surface();
    let body = &session.bodies[0];
    assert_eq!(body.skin.x, body.model.surface.points);
}

#[test]
fn a_pressed_body_pushes_back_the_same_with_each_integrator() {
    let mut forces = Vec::new();
    for integrator in ["symplectic-euler", "backward-euler"] {
        let time = format!("integrator = \"{integrator}\"");
        let body = "damping-time = 0.002";
        let scene = box_scene(&time, "", "")
            .replace("plugin = \"mass-spring\"", &format!("plugin = \"mass-spring\", params = {{ {body} }}"));
        let scene =
            scene.replace("path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]]", PRESS);
        // Without friction, which would keep a little of how it came there.
        let scene = scene.replace("radius = \"4 mm\"", "radius = \"4 mm\"\nfriction = [0, 0]");
        let mut session = open(&scene, 1);
        (0..400).for_each(|_| session.step());
        let felt = session.frame().tools[0];
        assert!(felt.contact.is_some() && felt.force[2] > 0.02, "{felt:?}");
        assert!(felt.force[0].abs() < 0.02 * felt.force[2] && felt.force[1].abs() < 0.02 * felt.force[2]);
        assert_eq!(felt.force, felt.device_force, "the hand's axes are the scene's here, and nothing had to be cut");
        forces.push(felt.force[2]);
    }
    assert!((forces[0] / forces[1] - 1.0).abs() < 1e-3, "at rest they must agree: {forces:?}");
}

#[test]
fn at_rest_the_hand_carries_what_the_border_holds() {
    let time = "integrator = \"backward-euler\"";
    let mut session = touched(time, "", "", PRESS);
    (0..500).for_each(|_| session.step());
    let force = session.frame().tools[0].force;
    // Elastic forces on the held nodes are what the rest of the body would have to push with.
    let system = &mut session.bodies[0].system;
    let mut elastic = vec![Vec3::zeros(); system.nodes.len()];
    let still = elastic.clone();
    system.forces(&Pool::new(1), Some(&still), NOW, &mut elastic).unwrap();
    let held = (0..elastic.len()).filter(|&i| !system.nodes.constraint[i].is_free());
    let border: Vec3 = held.map(|i| elastic[i]).sum();
    let off = (border + force).norm() / force.norm();
    assert!(off < 1e-3, "border {border:?}, hand {force:?}");
}

#[test]
fn friction_drags_by_its_coefficient_and_no_more() {
    for (friction, slides) in [("friction = [0.9, 0.9]", false), ("friction = [0.1, 0.1]", true)] {
        // 1.5 mm down, then 5 mm sideways.
        let path = "path = [[0.0, 0.0, 0.0, 0.006], [0.02, 0.0, 0.0, 0.0025], [0.05, 0.0, 0.0, 0.0025], [0.1, 0.005, 0.0, 0.0025]]";
        let mut session = touched("", friction, "", path);
        (0..50).for_each(|_| session.step());
        let mut greatest = 0.0_f64;
        for _ in 0..50 {
            session.step();
            let force = session.frame().tools[0].force;
            // The ball ploughs: the surface under it is tilted.
            let normal = session.tools[0].tool.proxy.touch.expect("it is pressed").normal;
            let press = force.dot(&normal);
            greatest = greatest.max((force - press * normal).norm() / press);
        }
        let lag = session.frame().tools[0].hand[0] - session.frame().tools[0].proxy[0];
        if slides {
            assert!(greatest < 0.12 && lag.abs() < 1e-4, "mu 0.1: {greatest}, lags by {lag}");
        } else {
            assert!(greatest > 0.4 && greatest < 0.95, "mu 0.9: {greatest}");
        }
    }
}

#[test]
fn what_a_hand_leaves_goes_back_without_a_jump() {
    // Across the top faster than the region springs back.
    let path = "path = [[0.0, -0.012, 0.0, 0.006], [0.02, -0.012, 0.0, 0.001], [0.06, 0.012, 0.0, 0.001], [0.07, 0.012, 0.0, 0.02]]";
    let scene = box_scene("", "", "")
        .replace("path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]]", path)
        .replace("level = 5", "level = 5, radius = 0.006, relaxation = 0.005");
    let mut session = open(&scene, 1);
    let (mut last, mut jump, mut deepest) = (session.bodies[0].skin.x.clone(), 0.0_f64, 0.0_f64);
    let (mut speed, mut hand) = (0.0, session.bodies[0].model.surface.points[0]);
    for _ in 0..900 {
        session.step();
        session.update_surface();
        let body = &session.bodies[0];
        let now = body.system.nodes.v.iter().fold(0.0_f64, |m, v| m.max(v.norm()));
        let reachable = 1e-3 * now.max(speed);
        speed = now;
        let tool = session.frame().tools[0];
        let swept = (tool.hand - hand).norm();
        hand = tool.hand;
        for (i, x) in body.skin.x.iter().enumerate() {
            // Under the tool nodes are faster within a step than at its ends, and no faster than the tool.
            let is_under = tool.contact.is_some() && (*x - tool.proxy).norm() < 0.004 + body.discretization.edge();
            let reachable = if is_under { reachable.max(swept) } else { reachable };
            jump = jump.max((*x - last[i]).norm() - reachable);
            deepest = deepest.max((*x - body.model.surface.points[i]).norm());
        }
        last.clone_from(&body.skin.x);
    }
    assert!(deepest > 1e-3, "it was pressed: {deepest}");
    assert!(jump < 5e-5, "a vertex moved {jump} m further in one step than any node could");
    let body = &session.bodies[0];
    assert_eq!(body.skin.x, body.model.surface.points, "in the end everything is back, to the bit");
    assert_eq!(session.frame().nodes, 0, "and nothing is simulated any more");
}

#[test]
fn a_kept_shape_is_the_rest_shape_from_then_on() {
    let edit = "end = 0.05\nrelease = \"keep\"";
    let path =
        "path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.06, 0.0, 0.0, 0.001], [0.07, 0.0, 0.0, 0.02]]";
    let mut session = touched("", "", edit, path);
    (0..51).for_each(|_| session.step());
    session.update_surface();
    let kept = session.bodies[0].skin.x.clone();
    let dent =
        kept.iter().zip(&session.bodies[0].model.surface.points).fold(0.0_f64, |m, (a, b)| m.max((*a - *b).norm()));
    assert!(dent > 1e-3, "{dent}");
    (0..200).for_each(|_| session.step());
    session.update_surface();
    let body = &session.bodies[0];
    let drift = body.skin.x.iter().zip(&kept).fold(0.0_f64, |m, (a, b)| m.max((*a - *b).norm()));
    assert!(drift < 1e-9, "it stays: {drift}");
}

#[test]
fn gravity_makes_no_local_region_jump_and_lets_a_whole_body_fall() {
    let gravity = |region: &str| {
        box_scene("", "", "").replace("level = 5", region).replace("[time]", "gravity = [0, 0, -9.81]\n[time]")
    };
    let mut local = open(&gravity("level = 5").replace(", 0.001]", ", 0.0055]"), 1);
    (0..60).for_each(|_| local.step());
    // The finger stays 1.5 mm above the top: cells are active, and none of them moves.
    assert!(local.frame().nodes > 0 && local.frame().tools[0].contact.is_none());
    assert_eq!(local.frame().kinetic_energy, 0.0);
    assert!(local.plan().left_out.iter().any(|l| l.what.contains("gravity") && l.why.contains("local")));
    let mut whole =
        open(&gravity("level = 5, region = \"whole\"").replace("0.006]", "0.03]").replace(", 0.001]", ", 0.03]"), 1);
    (0..50).for_each(|_| whole.step());
    let nodes = &whole.bodies[0].system.nodes;
    let substeps = whole.choices.substeps as f64;
    let (t, dt) = (0.05, 1e-3 / substeps);
    let fall = -0.5 * 9.81 * t * (t + dt);
    let worst = (0..nodes.len()).fold(0.0_f64, |m, i| m.max((nodes.x[i][2] - nodes.rest[i][2] - fall).abs()));
    assert!(worst < 1e-9, "free fall: off by {worst} of {fall}");
}
