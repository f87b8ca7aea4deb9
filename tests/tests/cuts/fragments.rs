//! A lattice that a blade passes through: what is conserved, what hangs together.

use pliant_engine::body::Body;
use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_tests::{Everywhere, NOW, box_scene, open};

/// A block of 40 mm, all of it active, twisted and moving.
fn block(params: &str) -> Session {
    let scene = box_scene("", "", "")
        .replace("level = 5", "level = 4, region = \"whole\"")
        .replace("plugin = \"mass-spring\"", &format!("plugin = \"mass-spring\", params = {{ {params} }}"));
    let mut session = open(&scene, 1);
    session.step();
    let nodes = &mut session.bodies[0].system.nodes;
    for i in 0..nodes.x.len() {
        let [x, y, z] = nodes.rest[i].into();
        nodes.x[i] = Vec3::new(x + 4.0 * y * z, y - 3.0 * x * z, z * 1.1);
        nodes.v[i] = Vec3::new(1.0 + 10.0 * y, 2.0 - 5.0 * z, 3.0 * x);
    }
    session
}

/// The rectangle x = `at`, y up to `to`, as a blade sweeps it.
fn wall(at: f64, to: f64) -> [[Vec3; 3]; 2] {
    let (low, high) = (-0.03, 0.03);
    [
        [Vec3::new(at, low, low), Vec3::new(at, to, low), Vec3::new(at, to, high)],
        [Vec3::new(at, low, low), Vec3::new(at, to, high), Vec3::new(at, low, high)],
    ]
}

fn cut(body: &mut Body, swept: &[[Vec3; 3]]) {
    let points = body.model.surface.points.clone();
    // Just inside of the body: towards its middle, and away from the wall.
    let inside = |v: u32| points[v as usize] * (1.0 - 1e-3);
    body.discretization
        .lattice_mut()
        .unwrap()
        .cut(swept, std::iter::empty(), inside, |_| Vec::new(), &Everywhere)
        .unwrap();
    let Body { model, skin, system, discretization, fixings, .. } = body;
    assert!(discretization.follow(&[], model, fixings, skin, system).unwrap());
}

struct State {
    mass: f64,
    momentum: Vec3,
    energy: f64,
    nodes: usize,
    parts: u32,
}

fn state(body: &mut Body) -> State {
    let elastic = body.system.energy(NOW).unwrap();
    let nodes = &body.system.nodes;
    let momentum: Vec3 = (0..nodes.len()).map(|i| nodes.mass[i] * nodes.v[i]).sum();
    State {
        mass: nodes.mass.iter().sum(),
        momentum,
        energy: elastic + nodes.kinetic_energy(),
        nodes: nodes.len(),
        parts: body.discretization.lattice().unwrap().parts().iter().max().map_or(0, |m| m + 1),
    }
}

fn close(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-12
}

#[test]
fn a_cut_keeps_mass_momentum_and_energy() {
    for params in ["", "flexion = 0.1", "mode = \"paper\""] {
        let mut session = block(params);
        let body = &mut session.bodies[0];
        let before = state(body);
        cut(body, &wall(0.0013, 0.03));
        let after = state(body);
        assert!(after.nodes > before.nodes, "nodes were copied");
        if params.contains("paper") {
            continue; // every particle of the paper has the same mass, copies too
        }
        assert!(close(after.mass, before.mass), "{params}: {} {}", after.mass, before.mass);
        let off = after.momentum - before.momentum;
        assert!(off.norm() < 1e-12 * before.momentum.norm());
        if params.is_empty() {
            assert!(close(after.energy, before.energy), "{} {}", after.energy, before.energy);
        } else {
            assert!(after.energy <= before.energy * (1.0 + 1e-12), "springs over the cut go: {}", after.energy);
        }
    }
}

#[test]
fn only_a_cut_that_goes_through_makes_two() {
    for (to, parts) in [(0.03, 2), (0.005, 1)] {
        let mut session = block("");
        let body = &mut session.bodies[0];
        assert_eq!(state(body).parts, 1);
        cut(body, &wall(0.0013, to));
        assert_eq!(state(body).parts, parts, "up to {to}");
    }
}

#[test]
fn a_cut_may_go_on_cross_another_and_be_made_twice() {
    let mut session = block("");
    let body = &mut session.bodies[0];
    cut(body, &wall(0.0013, 0.005));
    cut(body, &wall(0.0013, 0.03));
    let through = state(body);
    assert_eq!(through.parts, 2);
    cut(body, &wall(0.0013, 0.03));
    let again = state(body);
    assert_eq!((again.nodes, again.parts), (through.nodes, 2));
    let across = wall(0.0021, 0.03).map(|t| t.map(|p| Vec3::new(p.y, p.x, p.z)));
    cut(body, &across);
    let four = state(body);
    assert_eq!(four.parts, 4);
    assert!(close(four.mass, through.mass) && close(four.energy, through.energy));
}

#[test]
fn the_parts_of_a_cut_body_move_apart_on_their_own() {
    let mut session = block("damping-time = 0.001");
    cut(&mut session.bodies[0], &wall(0.0013, 0.03));
    session.changed(0);
    let nodes = &mut session.bodies[0].system.nodes;
    nodes.x.clone_from(&nodes.rest);
    for i in 0..nodes.x.len() {
        nodes.v[i] = Vec3::zeros();
    }
    let parts = session.bodies[0].discretization.lattice().unwrap().parts();
    let nodes = &mut session.bodies[0].system.nodes;
    for i in 0..nodes.x.len() {
        nodes.v[i][0] = if parts[i] == parts[0] { -0.1 } else { 0.1 };
    }
    // The finger is not there yet.
    (0..8).for_each(|_| session.step());
    let nodes = &session.bodies[0].system.nodes;
    for i in 0..nodes.x.len() {
        let moved = nodes.x[i][0] - nodes.rest[i][0];
        let expected = if parts[i] == parts[0] { -0.0008 } else { 0.0008 };
        assert!((moved - expected).abs() < 1e-9, "node {i}: {moved}");
    }
    session.update_surface();
    let body = &session.bodies[0];
    for (x, rest) in body.skin.x.iter().zip(&body.model.surface.points) {
        let expected = if rest[0] < 0.0013 { -0.0008 } else { 0.0008 };
        assert!((x[0] - rest[0] - expected).abs() < 1e-9, "the point at {rest:?} follows its own side: {x:?}");
    }
}
