//! Bodies meet each other: momentum stays, energy does not grow, nothing passes through.

use pliant_engine::body::Division;
use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_mesh::testing::tetrahedra::{TetBox, TetFormat};
use pliant_tests::tetrahedral::orders;
use pliant_tests::{Bench, open, open_file};

const G: f64 = 9.81;

fn run(session: &mut Session, seconds: f64) {
    while session.time() < seconds - 1e-9 {
        session.step();
    }
}

/// Mass (kg), momentum (N s) and angular momentum (N m s) of all bodies.
fn momenta(session: &Session) -> (f64, Vec3, Vec3) {
    let start = (0.0, Vec3::zeros(), Vec3::zeros());
    session.bodies.iter().fold(start, |sum, body| {
        let nodes = &body.system.nodes;
        (0..nodes.len()).fold(sum, |(mass, linear, angular), i| {
            let p = nodes.mass[i] * nodes.v[i];
            (mass + nodes.mass[i], linear + p, angular + nodes.x[i].cross(&p))
        })
    })
}

fn mean_velocity(session: &Session, body: usize) -> Vec3 {
    let nodes = &session.bodies[body].system.nodes;
    let mass: f64 = nodes.mass.iter().sum();
    nodes.v.iter().zip(&nodes.mass).map(|(v, m)| *m * *v).sum::<Vec3>() / mass
}

fn mean_position(session: &Session, body: usize) -> Vec3 {
    let nodes = &session.bodies[body].system.nodes;
    let mass: f64 = nodes.mass.iter().sum();
    nodes.x.iter().zip(&nodes.mass).map(|(x, m)| *m * *x).sum::<Vec3>() / mass
}

/// Gives every node of a body a velocity and a spin about the origin.
fn throw(session: &mut Session, body: usize, v: Vec3, spin: Vec3) {
    let nodes = &mut session.bodies[body].system.nodes;
    let centre = nodes.x.iter().sum::<Vec3>() / nodes.len() as f64;
    nodes.v = nodes.x.iter().map(|x| v + spin.cross(&(x - centre))).collect();
}

/// Triangles of a body at their present positions, m.
fn triangles(session: &mut Session, body: usize) -> Vec<[Vec3; 3]> {
    let body = &session.bodies[body];
    let x = vertices(body);
    body.model.surface.triangles.iter().map(|t| t.map(|v| x[v as usize])).collect()
}

/// Positions of the vertices by the weights of the grid, m.
fn vertices(body: &pliant_engine::body::Body) -> Vec<Vec3> {
    let mut x = body.skin.x.clone();
    if let Some(sheet) = body.discretization.sheet() {
        for v in 0..x.len() as u32 {
            x[v as usize] = body.system.nodes.x[sheet.node_of(v) as usize];
        }
    }
    x
}

/// Number of edges of the one body that go through triangles of the other.
fn crossings(a: &[[Vec3; 3]], b: &[[Vec3; 3]]) -> usize {
    let mut count = 0;
    for s in a {
        for t in b {
            let far = (0..3).any(|c| {
                let range = |x: &[Vec3; 3]| {
                    (
                        x.iter().map(|p| p[c]).fold(f64::INFINITY, f64::min),
                        x.iter().map(|p| p[c]).fold(f64::NEG_INFINITY, f64::max),
                    )
                };
                let (s, t) = (range(s), range(t));
                s.0 > t.1 || t.0 > s.1
            });
            if far {
                continue;
            }
            let pierces = |edge: [Vec3; 2], triangle: &[Vec3; 3]| {
                let [a, b, c] = *triangle;
                let volume = |p: Vec3, q: Vec3, r: Vec3, s: Vec3| (q - p).cross(&(r - p)).dot(&(s - p));
                let [p, q] = edge;
                let (u, v) = (volume(a, b, c, p), volume(a, b, c, q));
                let sides = [volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)];
                u * v < 0.0 && (sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0))
            };
            for i in 0..3 {
                count += usize::from(pierces([s[i], s[(i + 1) % 3]], t));
                count += usize::from(pierces([t[i], t[(i + 1) % 3]], s));
            }
        }
    }
    count
}

fn solid(name: &str, shape: &str, at: [f64; 3], level: u32, young: f64, more: &str) -> String {
    format!(
        r#"
        [[body]]
        name = "{name}"
        shape = {shape}
        position = {at:?}
        material = {{ plugin = "corotational", params = {{ young = {young:?}, poisson = 0.3, density = 1000, damping-time = 0.002 }} }}
        grid = {{ level = {level}, region = "whole", smooth = false }}
        meets = true
        {more}
        "#
    )
}

fn sheet(name: &str, cells: u32, size: f64, at: [f64; 3], more: &str) -> String {
    // The only body of a scene meets itself alone.
    let meets = !more.contains("self-contact");
    format!(
        r#"
        [[body]]
        name = "{name}"
        shape = {{ kind = "sheet", cells = {cells}, size = [{size:?}, {size:?}, 0] }}
        position = {at:?}
        sheet = {{}}
        meets = {meets}
        material = {{ plugin = "cloth", params = {{ fabric = "interlock", damping-time = 0.02 }} }}
        {more}
        "#
    )
}

fn scene(gravity: [f64; 3], time: &str, rest: &str) -> String {
    format!("format = 1\ngravity = {gravity:?}\n[time]\n{time}\n[solver]\ntolerance = 1e-10\n{rest}")
}

const TINY: [f64; 3] = [0.0, 0.0, -1e-30];

#[test]
fn two_sheets_that_meet_go_on_together() {
    for (time, v) in [
        ("dt = 0.001\nintegrator = \"backward-euler\"", 1.0),
        ("dt = 0.004\nintegrator = \"bdf2\"", 3.0),
        ("dt = 0.0005\nintegrator = \"implicit-midpoint\"", 0.3),
    ] {
        let bodies = sheet("a", 6, 0.06, [0.0, 0.0, 0.0], "") + &sheet("b", 8, 0.04, [0.01, 0.01, 0.01], "");
        let mut session = open(&scene(TINY, time, &bodies), 1);
        throw(&mut session, 1, Vec3::new(0.0, 0.0, -v), Vec3::zeros());
        let (mass, before, angular) = momenta(&session);
        let common = before / mass;
        run(&mut session, 0.5);
        let (_, after, turned) = momenta(&session);
        assert!((after - before).norm() < 1e-9 * before.norm(), "{time}: {before:?} {after:?}");
        // Backward Euler turns with the geometry at the start of a step, and a collision within it has another.
        assert!((turned - angular).norm() < 1e-4 * angular.norm(), "{time}: {angular:?} {turned:?}");
        assert!(
            (0..2).all(|b| (mean_velocity(&session, b) - common).norm() < 0.2 * common.norm()),
            "{time} {common:?} {:?} {:?}",
            mean_velocity(&session, 0),
            mean_velocity(&session, 1)
        );
        let (a, b) = (triangles(&mut session, 0), triangles(&mut session, 1));
        assert_eq!(crossings(&a, &b), 0, "{time}");
    }
}

#[test]
fn momentum_and_angular_momentum_of_bodies_that_collide_stay() {
    // Symplectic Euler conserves both itself, so what changes them is contact.
    let ball = "{ kind = \"sphere\", cells = 3, size = [0.04, 0.04, 0.04] }";
    let cube = "{ kind = \"box\", cells = 3, size = [0.03, 0.03, 0.03] }";
    let families = [
        solid("a", ball, [0.0, 0.0, 0.0], 3, 5e4, "") + &solid("b", ball, [0.06, 0.01, 0.005], 3, 5e4, ""),
        solid("a", cube, [0.0, 0.0, 0.0], 2, 5e4, "") + &solid("b", ball, [0.06, 0.01, 0.005], 3, 2e4, ""),
        sheet("a", 5, 0.05, [0.0, 0.0, 0.0], "") + &solid("b", cube, [0.02, 0.03, 0.04], 2, 2e4, ""),
        sheet("a", 5, 0.05, [0.0, 0.0, 0.0], "") + &sheet("b", 4, 0.04, [0.01, 0.0, 0.02], ""),
    ];
    let mut random = Random(3);
    for (at, bodies) in families.iter().enumerate() {
        for _ in 0..2 {
            let mut session = open(&scene(TINY, "dt = 0.0001\nintegrator = \"symplectic-euler\"", bodies), 1);
            let apart = (mean_position(&session, 0) - mean_position(&session, 1)).normalize();
            throw(&mut session, 0, -1.0 * apart + 0.2 * random.vector(), 20.0 * random.vector());
            throw(&mut session, 1, 1.0 * apart + 0.2 * random.vector(), 20.0 * random.vector());
            let (_, linear, angular) = momenta(&session);
            let scale: f64 = session.bodies.iter().map(|b| b.system.nodes.kinetic_energy()).sum::<f64>().sqrt()
                * momenta(&session).0.sqrt();
            let mut pushed = 0.0_f64;
            while session.time() < 0.08 {
                session.step();
                pushed = pushed.max(session.contact_force(0).norm());
            }
            let (_, l, a) = momenta(&session);
            assert!(pushed > 0.01, "{at}: they did not meet");
            assert!((l - linear).norm() < 1e-12 * scale, "{at}: {:e}", (l - linear).norm() / scale);
            // A collision within a step acts at points that were a way v dt apart along the surface at its start.
            assert!((a - angular).norm() < 1e-6 * scale, "{at}: {:e}", (a - angular).norm() / scale);
        }
    }
}

#[test]
fn a_block_on_a_block_rests_with_its_weight() {
    let cube = "{ kind = \"box\", cells = 4, size = [0.04, 0.04, 0.04] }";
    let fixed = "fixed = [{ box = [[-1, -1, -1], [1, 1, -0.0199]] }]";
    let floor = "[[obstacle]]\nname = \"floor\"\nshape = { kind = \"plane\" }\nposition = [0, 0, -0.02]\n";
    for (time, below, rest) in [
        ("dt = 0.001\nintegrator = \"backward-euler\"", fixed, ""),
        ("dt = 0.005\nintegrator = \"backward-euler\"", fixed, ""),
        ("dt = 0.001\nintegrator = \"backward-euler\"", "", floor),
        ("dt = 0.0005\nintegrator = \"bdf2\"", fixed, ""),
    ] {
        let bodies =
            solid("below", cube, [0.0; 3], 3, 2e5, below) + &solid("above", cube, [0.005, 0.003, 0.0405], 3, 2e5, "");
        let mut session = open(&scene([0.0, 0.0, -G], time, &(bodies + rest)), 1);
        let mass: f64 = session.bodies[1].system.nodes.mass.iter().sum();
        run(&mut session, 1.5);
        let start = mean_position(&session, 1);
        let (mut sum, mut count) = (0.0, 0);
        while session.time() < 1.8 {
            session.step();
            sum += session.contact_force(1)[2];
            count += 1;
        }
        let (force, end) = (sum / f64::from(count), mean_position(&session, 1));
        println!("{time}: force {force} N of {} N, drift {:?} m", mass * G, end - start);
        assert!((force - mass * G).abs() < 0.01 * mass * G, "{time}: {force} N, weight {} N", mass * G);
        assert!((end - start).norm() < 1e-5, "{time}: drift {:?} m", end - start);
        session.update_surface();
        let (a, b) = (triangles(&mut session, 0), triangles(&mut session, 1));
        assert_eq!(crossings(&a, &b), 0, "{time}");
    }
}

#[test]
fn a_block_on_a_sloping_block_sticks_or_slides_by_coulombs_law() {
    let cube = "{ kind = \"box\", cells = 4, size = [0.02, 0.02, 0.02] }";
    let slab = "{ kind = \"box\", cells = 12, size = [0.12, 0.04, 0.01] }";
    for (angle, friction) in [(0.2_f64, 0.25), (0.2, 0.15), (0.5, 0.3)] {
        let gravity = [G * angle.sin(), 0.0, -G * angle.cos()];
        let key = format!("friction = [{friction}, {friction}]");
        let fixed = format!("{key}\nfixed = [{{ box = [[-1, -1, -1], [1, 1, 1]] }}]");
        let bodies = solid("slope", slab, [0.0; 3], 3, 1e6, &fixed)
            + &solid("block", cube, [-0.04, 0.001, 0.0152], 2, 1e6, &key);
        let mut session = open(&scene(gravity, "dt = 0.0005\nintegrator = \"backward-euler\"", &bodies), 1);
        run(&mut session, 0.05);
        let first = mean_velocity(&session, 1)[0];
        run(&mut session, 0.15);
        let acceleration = (mean_velocity(&session, 1)[0] - first) / 0.1;
        let expected = (G * (angle.sin() - friction * angle.cos())).max(0.0);
        println!("{angle} {friction}: {acceleration} m/s^2, expected {expected}");
        assert!(
            (acceleration - expected).abs() < 0.05 * expected.max(0.2),
            "{angle} {friction}: {acceleration}, expected {expected}"
        );
    }
}

/// Kinetic and elastic energy of all bodies and their energy in gravity along the third axis, J.
fn energy(session: &mut Session, gravity: f64) -> f64 {
    let now = pliant_solver::StepTime { start: session.time(), dt: session.dt() };
    let each = session.bodies.iter_mut().map(|body| {
        let nodes = &body.system.nodes;
        let height: f64 = nodes.x.iter().zip(&nodes.mass).map(|(x, m)| m * x[2]).sum();
        nodes.kinetic_energy() + gravity * height + body.system.energy(now).expect("an energy")
    });
    each.sum()
}

/// A random body around a point, m.
fn random_body(random: &mut Random, name: &str, at: [f64; 3], most_level: u32) -> String {
    let kind = random.pick(&["sphere", "box", "cylinder", "sheet"]);
    let size = 0.02 + 0.03 * random.unit();
    if kind == "sheet" {
        return sheet(name, 4 + random.below(9) as u32, size, [at[0] - 0.5 * size, at[1] - 0.5 * size, at[2]], "");
    }
    let shape = format!("{{ kind = \"{kind}\", cells = {}, size = [{size}, {size}, {size}] }}", 3 + random.below(4));
    let young = 2e3 * 500f64.powf(random.unit());
    let level = 2 + random.below(u64::from(most_level - 1)) as u32;
    solid(name, &shape, at, level, young, "")
}

#[test]
fn random_falls_pass_through_nothing_and_gain_no_energy() {
    let integrators = ["backward-euler", "bdf2", "implicit-midpoint", "symplectic-euler"];
    let count = pliant_tests::asked_cases("MEETING_CASES").unwrap_or(0..12);
    for case in count {
        let mut random = Random(1000 + case);
        let (a, b) = (random_body(&mut random, "a", [0.0; 3], 4), random_body(&mut random, "b", [0.0, 0.0, 0.06], 4));
        let integrator = integrators[case as usize % 4];
        let dt = 0.0001 * 100f64.powf(random.unit());
        let dt = if integrator == "symplectic-euler" { (0.1 * dt).min(1e-4) } else { dt };
        let time = format!("dt = {dt}\nintegrator = \"{integrator}\"\nmost-substeps = 1000");
        let mut session = open(&scene(TINY, &time, &(a + &b)), 1);
        let speed = 0.5 * 20f64.powf(random.unit());
        throw(&mut session, 1, Vec3::new(0.0, 0.0, -speed) + 0.2 * speed * random.vector(), Vec3::zeros());
        let (_, momentum, _) = momenta(&session);
        let (first, mut least, mut most) = (energy(&mut session, 0.0), f64::INFINITY, 0.0_f64);
        let (mut touching, mut iterations, mut solver, mut fallback, mut slow) = (0, 0, 0, 0, 0);
        for step in 0..((0.12 / speed / dt) as usize + 20).min(300) {
            session.step();
            let report = session.collision_report();
            touching += usize::from(report.has_pushed);
            iterations += report.iterations;
            solver += report.solver_iterations;
            fallback += usize::from(report.rounds > 0);
            slow += usize::from(!report.has_converged);
            if report.has_pushed {
                assert_eq!(
                    session.crossings(0, 1).expect("surfaces"),
                    0,
                    "case {case}, step {step}: {integrator} dt {dt} speed {speed}"
                );
            }
            let now = energy(&mut session, 0.0);
            least = least.min(now);
            most = most.max((now - least) / first);
        }
        let left = session.events.count(pliant_engine::session::EventKind::CollisionsLeft);
        let (mass, after, _) = momenta(&session);
        let drift = (after - momentum).norm() / (mass * first).sqrt();
        println!(
            "case {case}: {integrator} dt {dt:.5} speed {speed:.2}: {touching} touch, {:.0} its, {:.0} cg, {slow} slow, {fallback} fallback, left {left}, gain {most:.1e} momentum {drift:.1e}",
            iterations as f64 / touching.max(1) as f64,
            solver as f64 / touching.max(1) as f64
        );
        assert!(left == 0, "case {case}: {left} collisions left");
        // Symplectic Euler swings about the energy by terms of first order in the step; the materials are not linear.
        let allowed = if integrator == "symplectic-euler" { 0.05 } else { 0.01 };
        assert!(most < allowed, "case {case}: the energy rose by {most} of that at the start");
    }
}

/// A sheet that stands on a floor, falls over and folds onto itself.
fn folding(self_contact: bool, threads: usize) -> Session {
    let more = format!("rotation = {{ axis = [1, 0, 0], angle = \"80 deg\" }}\nself-contact = {self_contact}");
    let floor = "[[obstacle]]\nname = \"floor\"\nshape = { kind = \"plane\" }\n";
    let body = sheet("cloth", 12, 0.12, [-0.06, 0.0, 0.01], &more) + floor;
    open(&scene([0.0, 0.0, -G], "dt = 0.001\nintegrator = \"backward-euler\"", &body), threads)
}

#[test]
fn a_sheet_that_folds_onto_itself_on_a_floor_hardly_cuts_itself() {
    let mut bytes = Vec::new();
    for (self_contact, threads) in [(false, 1), (true, 1), (true, 2)] {
        let mut session = folding(self_contact, threads);
        let mut crossed = 0;
        for _ in 0..10 {
            let until = session.time() + 0.04;
            run(&mut session, until);
            crossed += session.crossings(0, 0).expect("a surface");
        }
        println!(
            "self-contact {self_contact}: {crossed} crossings, {:.4} s, {:?}",
            session.body_contact_seconds(),
            session.collision_report()
        );
        // Without it 310. Some are left where the floor pushes nodes out after contact: docs/scenes.md says so.
        assert_eq!(crossed < 31, self_contact, "{crossed} crossings");
        bytes.push(session.bodies[0].system.nodes.x.clone());
    }
    assert_eq!(bytes[1], bytes[2], "with 1 and 2 threads");
}

#[test]
fn a_restored_session_goes_on_alike_and_far_bodies_cost_nothing() {
    let cube = "{ kind = \"box\", cells = 4, size = [0.02, 0.02, 0.02] }";
    let bodies = sheet(
        "a",
        6,
        0.06,
        [-0.03, -0.03, 0.0],
        "fixed = [{ box = [[-1, -1, -1], [-0.029, 1, 1]] }, { box = [[0.029, -1, -1], [1, 1, 1]] }]",
    ) + &solid("b", cube, [0.0, 0.0, 0.03], 2, 1e5, "");
    let mut session = open(&scene([0.0, 0.0, -G], "dt = 0.001\nintegrator = \"bdf2\"", &bodies), 1);
    run(&mut session, 0.02);
    assert_eq!(session.contact_force(1), Vec3::zeros(), "still far");
    run(&mut session, 0.05);
    let snapshot = session.snapshot();
    let mut again = || {
        session.restore(&snapshot).expect("its own snapshot");
        let mut met = false;
        while session.time() < 0.12 {
            session.step();
            met |= session.contact_force(1) != Vec3::zeros();
        }
        assert!(met);
        session.bodies.iter().map(|body| body.system.nodes.x.clone()).collect::<Vec<_>>()
    };
    assert_eq!(again(), again());
}

#[test]
fn a_stack_of_two_blocks_sinks_like_one_of_double_height() {
    let young = 5e3;
    let half = "{ kind = \"box\", cells = 6, size = [0.04, 0.04, 0.02] }";
    let whole = "{ kind = \"box\", cells = 6, size = [0.04, 0.04, 0.04] }";
    let fixed = "fixed = [{ box = [[-1, -1, -1], [1, 1, 1e-4]] }]";
    let stack = solid("below", half, [0.0, 0.0, 0.01], 3, young, fixed)
        + &solid("above", half, [0.0, 0.0, 0.0301], 3, young, "");
    let other = "[[body]]\nname = \"far\"\nshape = { kind = \"box\", cells = 2, size = [0.01, 0.01, 0.01] }\nposition = [1, 0, 0]\nmeets = true\nfixed = [{ box = [[-9, -9, -9], [9, 9, 9]] }]\nmaterial = { plugin = \"corotational\" }\ngrid = { level = 2, region = \"whole\", smooth = false }\n";
    let one = solid("one", whole, [0.0, 0.0, 0.02], 3, young, fixed) + other;
    let time = "dt = 0.002\nintegrator = \"backward-euler\"";
    let sunk = |text: &str, tops: &dyn Fn(f64) -> bool, body: usize| {
        let mut session = open(&scene([0.0, 0.0, -G], time, text), 1);
        run(&mut session, 1.0);
        let nodes = &session.bodies[body].system.nodes;
        let each = nodes.x.iter().zip(&nodes.rest).filter(|(_, rest)| tops(rest[2])).map(|(x, rest)| rest[2] - x[2]);
        let all: Vec<f64> = each.collect();
        all.iter().sum::<f64>() / all.len() as f64
    };
    let two = sunk(&stack, &|z| (z - 0.0401).abs() < 2e-4, 1);
    let single = sunk(&one, &|z| (z - 0.04).abs() < 2e-4, 0);
    // The gap of 0.1 mm closes to that which surfaces keep; friction 0.3 does not hold all of the sides' spreading.
    println!("top of two blocks sinks {two} m, of one {single} m");
    assert!((two - 1e-4 - single).abs() < 0.05 * single + 1e-4, "{two} {single}");
}

#[test]
fn a_block_at_rest_on_a_block_falls_asleep() {
    let cube = "{ kind = \"box\", cells = 4, size = [0.04, 0.04, 0.04] }";
    let floor = "[[obstacle]]\nname = \"floor\"\nshape = { kind = \"plane\" }\nposition = [0, 0, -0.02]\n";
    let bodies = solid("below", cube, [0.0; 3], 3, 1e5, "") + &solid("above", cube, [0.005, 0.003, 0.0405], 3, 1e5, "");
    let time = "dt = 0.001\nintegrator = \"backward-euler\"\nsleep = \"1 mm/s\"";
    let mut session = open(&scene([0.0, 0.0, -G], time, &(bodies + floor)), 1);
    run(&mut session, 1.5);
    assert!(session.events.count(pliant_engine::session::EventKind::Asleep) >= 2);
    let start = session.bodies[1].system.nodes.x.clone();
    run(&mut session, 1.6);
    assert_eq!(start, session.bodies[1].system.nodes.x, "it stands still");
    // A third of the sizes apart it would have fallen through.
    assert!(mean_position(&session, 1)[2] > 0.038);
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let ball = "{ kind = \"sphere\", cells = 8, size = [0.04, 0.04, 0.04] }";
    let bodies = solid("ball", ball, [0.0; 3], 4, 3e4, "fixed = [{ box = [[-1, -1, -1], [1, 1, -0.015]] }]")
        + &sheet("cloth", 16, 0.08, [-0.04, -0.04, 0.021], "");
    let run = |threads: usize| {
        let mut session = open(
            &scene([0.0, 0.0, -G], "dt = 0.002\nintegrator = \"backward-euler\"", &bodies).replace("1e-10", "1e-4"),
            threads,
        );
        for _ in 0..60 {
            session.step();
        }
        assert_ne!(session.contact_force(0), Vec3::zeros());
        session.bodies.iter().map(|body| body.system.nodes.x.clone()).collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn a_sheet_drapes_over_a_soft_ball_and_onto_itself() {
    let ball = "{ kind = \"sphere\", cells = 8, size = [0.04, 0.04, 0.04] }";
    let cloth =
        sheet("cloth", 20, 0.14, [-0.07, -0.07, 0.022], "self-contact = true").replace("meets = false", "meets = true");
    let floor = "[[obstacle]]\nname = \"floor\"\nshape = { kind = \"plane\" }\nposition = [0, 0, -0.02]\n";
    let bodies = solid("ball", ball, [0.0; 3], 3, 2e4, "") + &cloth + floor;
    let text = scene([0.0, 0.0, -G], "dt = 0.004\nintegrator = \"backward-euler\"", &bodies).replace("1e-10", "1e-4");
    let mut session = open(&text, 2);
    let first = energy(&mut session, G);
    let mut most = f64::NEG_INFINITY;
    for _ in 0..10 {
        let until = session.time() + 0.04;
        run(&mut session, until);
        let crossed = [[0, 1], [1, 1]].map(|[a, b]| session.crossings(a, b).expect("surfaces"));
        assert_eq!(crossed, [0, 0], "at {until} s");
        most = most.max(energy(&mut session, G));
    }
    let report = session.collision_report();
    println!("energy {first} J, at most {most} J afterwards; {report:?}, {:.3} s", session.body_contact_seconds());
    assert!(most <= first + 1e-3 * first.abs(), "{first} {most}");
}

#[test]
fn a_cut_body_stays_in_contact() {
    let cube = "{ kind = \"box\", cells = 4, size = [0.02, 0.02, 0.02] }";
    let fixed = "fixed = [{ box = [[-1, -1, -1], [1, 1, -0.009]] }]";
    let bodies = solid("below", cube, [0.0; 3], 3, 5e4, fixed) + &solid("above", cube, [0.0, 0.0, 0.0205], 3, 5e4, "");
    let knife = "[[device]]\nname = \"hand\"\nplugin = \"scripted\"\n[device.params]\npath = [[0.0, 0.0, -0.03, 0.02], [0.1, 0.0, 0.03, 0.02]]\n\
         [[tool]]\nname = \"knife\"\ndevice = \"hand\"\nradius = \"0.5 mm\"\nblade = { length = \"16 mm\", direction = [0, 0, 1], toughness = \"5 J/m^2\" }\n\
         [[edit]]\nkind = \"cut\"\ntool = \"knife\"\nend = \"0.1 s\"\n";
    let mut session = open(&scene([0.0, 0.0, -G], "dt = 0.002\nintegrator = \"backward-euler\"", &(bodies + knife)), 1);
    let nodes = session.bodies[1].system.nodes.len();
    run(&mut session, 0.2);
    assert_ne!(session.contact_force(1), Vec3::zeros(), "in contact");
    assert!(session.bodies[1].system.nodes.len() > nodes, "it was cut");
    assert_eq!(session.crossings(0, 1).expect("surfaces"), 0);
}

/// Two boxes of linear, quadratic and curved tetrahedra fall onto each other; the lower one is held.
#[test]
fn tetrahedral_meshes_of_each_order_meet() {
    for (number, mesh) in orders(&TetBox::new([2, 2, 2], [0.02, 0.02, 0.02], 0.1, 5)).iter().enumerate() {
        let bench = Bench::new();
        bench.write("box.msh", mesh.bytes(TetFormat::Msh4));
        let body = |name: &str, height: f64, more: &str| {
            format!(
                "[[body]]\nname = \"{name}\"\nmesh = \"box.msh\"\nposition = [0, 0, {height:?}]\nmeets = true\nmaterial = {{ plugin = \"neo-hookean\", \
                 params = {{ young = 5e4, poisson = 0.3, density = 1000, damping-time = 2e-3 }} }}\n{more}\n"
            )
        };
        let fixed = "fixed = [{ box = [[-1, -1, -1], [1, 1, 0.002]] }]";
        let bodies = body("below", 0.0, fixed) + &body("above", 0.022, "");
        let text = scene([0.0, 0.0, -G], "dt = 0.002\nduration = 1\nintegrator = \"backward-euler\"", &bodies);
        let mut session = open_file(&bench.write("scene.toml", text), 1, None);
        let first = energy(&mut session, G);
        run(&mut session, 0.5);
        assert_eq!(session.crossings(0, 1).expect("surfaces"), 0, "order {number}");
        let weight = G * session.bodies[1].system.nodes.mass.iter().sum::<f64>();
        let force = session.contact_force(1)[2];
        assert!((force - weight).abs() < 0.01 * weight, "order {number}: {force} N carries {weight} N");
        assert!(energy(&mut session, G) < first, "order {number}");
    }
}

/// A finger presses a block that lies on another one and keeps the dent, which is undone; the recording of it gives the same state, to the bit.
#[test]
fn an_undo_in_contact_is_replayed_to_the_bit() {
    let bench = Bench::new();
    let cube = "{ kind = \"box\", cells = 4, size = [0.02, 0.02, 0.02] }";
    let fixed = "fixed = [{ box = [[-1, -1, -1], [1, 1, -0.009]] }]";
    let bodies = solid("below", cube, [0.0; 3], 3, 5e4, fixed) + &solid("above", cube, [0.0, 0.0, 0.0205], 3, 5e4, "");
    let finger = "[[device]]\nname = \"hand\"\n[device.params]\npath = [[0.0, 0.0, 0.0, 0.04], [0.1, 0.0, 0.0, 0.033], [0.2, 0.0, 0.0, 0.05]]\n\
         [[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"4 mm\"\n\
         [[edit]]\nkind = \"touch\"\ntool = \"finger\"\nend = \"0.15 s\"\nrelease = \"keep\"\n[[edit]]\nkind = \"undo\"\nstart = \"0.25 s\"\n";
    let time = "dt = 0.002\nduration = 0.35\nintegrator = \"backward-euler\"";
    let text = scene([0.0, 0.0, -G], time, &(bodies + finger)).replace("1e-10", "1e-5");
    bench.write("scene.toml", &text);
    bench.pliant(&["run", "scene.toml", "-q", "--out", "first", "--record", "hand.rec"]).expect(0);
    bench.write("kept.toml", text.replace("[[edit]]\nkind = \"undo\"\nstart = \"0.25 s\"\n", ""));
    bench.pliant(&["run", "kept.toml", "-q", "--out", "kept"]).expect(0);
    assert!(bench.read("first/final-above.obj") != bench.read("kept/final-above.obj"), "the dent was undone");
    bench.pliant(&["replay", "hand.rec", "--verify", "-q", "--out", "again"]).expect(0);
    for name in ["final-below.obj", "final-above.obj"] {
        assert!(bench.read(&format!("first/{name}")) == bench.read(&format!("again/{name}")), "{name}");
    }
}

/// A body of two blocks that lie on another one is split, and joined again by an undo: the parts meet what the whole met.
#[test]
fn parts_of_a_body_meet_what_the_whole_meets() {
    let bench = Bench::new();
    let block = |first: usize, x: f64| {
        let corner = |i: usize| {
            let at = |bit: usize| if i >> bit & 1 == 1 { 0.01 } else { 0.0 };
            format!("v {} {} {}\n", x + at(0), at(1), at(2))
        };
        let faces = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
        let face = |f: [usize; 4]| format!("f {} {} {} {}\n", f[0] + first, f[1] + first, f[2] + first, f[3] + first);
        (0..8).map(corner).chain(faces.map(face)).collect::<String>()
    };
    bench.write("two.obj", block(0, -0.018) + &block(8, 0.008));
    let below = "{ kind = \"box\", cells = 8, size = [0.05, 0.03, 0.02] }";
    let fixed = "fixed = [{ box = [[-1, -1, -1], [1, 1, -0.008]] }]";
    let above = solid("above", "\"\"", [0.0, -0.005, 0.0105], 4, 5e4, "scale = 1\nsubdivide = 2")
        .replace("shape = \"\"", "mesh = \"two.obj\"");
    let bodies = solid("below", below, [0.0; 3], 4, 5e4, fixed) + &above;
    let text = scene([0.0, 0.0, -G], "dt = 0.002\nduration = 1\nintegrator = \"backward-euler\"", &bodies);
    let mut session = open_file(&bench.write("scene.toml", text.replace("1e-10", "1e-6")), 1, None);
    session.keep_history();
    run(&mut session, 0.1);
    let weight = G * session.bodies[1].system.nodes.mass.iter().sum::<f64>();
    let rests = |session: &mut Session, parts: std::ops::RangeInclusive<usize>, what: &str| {
        let until = session.time() + 0.3;
        run(session, until);
        let carried = -session.contact_force(0)[2];
        assert!((carried - weight).abs() < 0.02 * weight, "{what}: {carried} N of {weight} N");
        for part in parts {
            assert_eq!(session.crossings(0, part).expect("surfaces"), 0, "{what}: part {part}");
        }
    };
    rests(&mut session, 1..=1, "whole");
    session.split(1, Division::EachPart).expect("two parts");
    assert_eq!(session.bodies.len(), 3);
    rests(&mut session, 1..=2, "parts");
    assert!(session.undo());
    assert_eq!(session.bodies.len(), 2);
    rests(&mut session, 1..=1, "whole again");
}
