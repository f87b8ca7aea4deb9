//! Obstacles: what meets them does not enter, rests with its weight, sticks or slides by Coulomb's law, and gains no energy.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Random, apart, scan};
use pliant_solver::{Pool, StepTime};
use pliant_tests::{Bench, asked_cases, open, open_file};

const G: f64 = 9.81;

/// How far the smooth surface may come into an obstacle before it is drawn, in edges of a cell.
const SMOOTH: f64 = 0.25;

/// Depth of the deepest drawn vertex inside of an obstacle, in edges of the body. Before drawing, no vertex is deeper than the smooth surface explains.
fn deepest(session: &mut Session) -> f64 {
    for body in &mut session.bodies {
        body.update_skin(&Pool::new(1)).expect("a surface");
    }
    let depth = depth_of_vertices(session);
    assert!(depth < SMOOTH, "{depth} edges inside before drawing");
    session.update_surface();
    depth_of_vertices(session)
}

fn depth_of_vertices(session: &Session) -> f64 {
    let mut deepest = f64::NEG_INFINITY;
    for body in &session.bodies {
        for obstacle in session.obstacles() {
            let depths = body.skin.x.iter().map(|x| -obstacle.distance(*x) / body.discretization.edge());
            deepest = depths.fold(deepest, f64::max);
        }
    }
    deepest
}

fn mass(session: &Session) -> f64 {
    session.bodies.iter().flat_map(|body| &body.system.nodes.mass).sum()
}

/// Kinetic, elastic and gravity's energy of the first body, J.
fn energy(session: &mut Session) -> f64 {
    let gravity = session.plan().gravity;
    let now = StepTime { start: session.time(), dt: session.dt() };
    let system = &mut session.bodies[0].system;
    let height: f64 = system.nodes.x.iter().zip(&system.nodes.mass).map(|(x, m)| -m * gravity.dot(x)).sum();
    system.nodes.kinetic_energy() + system.energy(now).expect("an energy") + height
}

fn mean_velocity(session: &Session) -> Vec3 {
    let nodes = &session.bodies[0].system.nodes;
    let momentum: Vec3 = nodes.v.iter().zip(&nodes.mass).map(|(v, m)| *m * *v).sum();
    momentum / mass(session)
}

fn run(session: &mut Session, seconds: f64) {
    while session.time() < seconds - 1e-9 {
        session.step();
    }
}

/// A block of 60 mm, 1 mm above the floor, on which gravity acts at `angle` (rad) from its normal, in the direction of x.
fn block(solid: &str, level: u32, time: &str, angle: f64, friction: [f64; 2]) -> Session {
    let gravity = [G * angle.sin(), 0.0, -G * angle.cos()];
    open(
        &format!(
            r#"
            format = 1
            gravity = {gravity:?}
            [time]
            {time}
            [[body]]
            shape = {{ kind = "box", cells = 12, size = [0.06, 0.06, 0.06] }}
            position = [0, 0, 0.031]
            material = {{ plugin = "{solid}", params = {{ young = 2e5, density = 1000, damping-time = 0.005 }} }}
            grid = {{ level = {level}, region = "whole" }}
            [[obstacle]]
            name = "floor"
            shape = {{ kind = "plane" }}
            friction = {friction:?}
            "#
        ),
        1,
    )
}

#[test]
fn a_block_at_rest_stands_on_the_floor_with_its_weight() {
    for solid in ["mass-spring", "neo-hookean", "corotational"] {
        for (level, time) in [
            (4, "dt = 0.001"),
            (3, "dt = 0.004\nintegrator = \"backward-euler\""),
            (4, "dt = 0.001\nintegrator = \"bdf2\""),
            (3, "dt = 0.0005\nintegrator = \"symplectic-euler\""),
        ] {
            let mut session = block(solid, level, time, 0.0, [0.35, 0.3]);
            run(&mut session, 0.5);
            let weight = mass(&session) * G;
            let force = session.obstacles()[0].force;
            assert!(
                (force + Vec3::new(0.0, 0.0, weight)).norm() < 1e-3 * weight,
                "{solid} {level} {time}: {force:?} N, weight {weight} N"
            );
            let depth = deepest(&mut session);
            assert!((-1e-3..1e-9).contains(&depth), "{solid} {level} {time}: {depth} cells deep");
        }
    }
}

#[test]
fn a_block_on_a_slope_sticks_or_slides_by_coulombs_law() {
    for (angle, friction) in [(0.2_f64, 0.25), (0.2, 0.15), (0.5, 0.6), (0.5, 0.45), (0.3, 0.0)] {
        for time in [
            "dt = 0.001",
            "dt = 0.002\nintegrator = \"backward-euler\"",
            "dt = 0.001\nintegrator = \"symplectic-euler\"",
        ] {
            let mut session = block("corotational", 3, time, angle, [friction; 2]);
            run(&mut session, 0.2);
            let first = mean_velocity(&session)[0];
            run(&mut session, 0.4);
            let second = mean_velocity(&session)[0];
            let wanted = (G * (angle.sin() - friction * angle.cos())).max(0.0);
            let found = (second - first) / 0.2;
            assert!(
                (found - wanted).abs() < 0.02 * G * angle.sin(),
                "slope {angle}, friction {friction}, {time}: {found} m/s^2, not {wanted}"
            );
            if wanted == 0.0 {
                assert!(second.abs() < 1e-4, "slope {angle}, friction {friction}, {time}: it creeps at {second} m/s");
            }
        }
    }
}

/// A fall of a random closed model on random obstacles; everything about it is drawn from its number.
struct Fall {
    text: String,
    scene: String,
    speed: f64,
    what: String,
}

impl Fall {
    fn new(number: u64) -> Self {
        let random = &mut Random(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let text = scan(u32::from(random.unit() < 0.3), 800, 0, number).text;
        let level = 3 + random.below(3) as u32;
        let solid = random.pick(&["mass-spring", "neo-hookean", "corotational"]);
        let integrator = random.pick(&[
            "auto",
            "backward-euler",
            "bdf2",
            "implicit-midpoint",
            "damped-midpoint",
            "symplectic-euler",
        ]);
        let young = 1e4 * 30_f64.powf(random.unit());
        let speed = 10.0 * random.unit().powi(2);
        let dt = if integrator == "symplectic-euler" { 5e-4 } else { 1e-3 };
        let (axis, angle) = (random.direction(), 3.0 * random.unit());
        let friction = random.unit();
        let shape = random.pick(&[
            r#"shape = { kind = "plane" }"#,
            r#"shape = { kind = "sphere", radius = 0.05 }
            position = [0.01, 0, -0.05]"#,
            r#"shape = { kind = "box", size = [0.06, 0.08, 0.1] }
            position = [0.02, 0, -0.05]"#,
            r#"shape = { kind = "capsule", radius = 0.02, length = 0.1 }
            position = [0, 0, -0.02]
            rotation = { axis = [1, 0, 0], angle = "80 deg" }"#,
            r#"mesh = "rock.obj"
            size = "120 mm"
            position = [0, 0, -0.06]"#,
        ]);
        let axis: [f64; 3] = axis.into();
        let what = format!(
            "fall {number}: {solid}, level {level}, {integrator}, {young:.0} Pa, {speed:.2} m/s, friction {friction:.2}, {shape}"
        );
        let scene = format!(
            r#"
            format = 1
            gravity = [0, 0, -9.81]
            [time]
            dt = {dt}
            integrator = "{integrator}"
            most-substeps = 200
            [[body]]
            mesh = "model.obj"
            size = "100 mm"
            position = [0, 0, 0.09]
            rotation = {{ axis = {axis:?}, angle = {angle} }}
            material = {{ plugin = "{solid}", params = {{ young = {young}, density = 1000, damping-time = 0.002 }} }}
            grid = {{ level = {level}, region = "whole" }}
            [[obstacle]]
            name = "ground"
            {shape}
            friction = [{friction}, {friction}]
            "#
        );
        Self { text, scene, speed, what }
    }

    fn check(&self) {
        let bench = Bench::new();
        bench.write("model.obj", &self.text);
        bench.write("rock.obj", scan(0, 600, 0, 77).text);
        let mut session = open_file(&bench.write("scene.toml", &self.scene), 1, None);
        session.bodies[0].system.nodes.v.fill(Vec3::new(0.0, 0.0, -self.speed));
        let start = energy(&mut session);
        let (mut most, mut depth) = (start, f64::NEG_INFINITY);
        for step in 0..150 {
            session.step();
            assert!(session.bodies[0].frozen.is_none(), "{}: {:?}", self.what, session.bodies[0].frozen);
            if step % 5 == 0 {
                depth = depth.max(deepest(&mut session));
                most = most.max(energy(&mut session));
            }
        }
        assert!(depth < 1e-5, "{}: {depth} cells inside", self.what);
        assert!(most <= start + 1e-3 * start.abs(), "{}: energy {start} J grew to {most} J", self.what);
    }
}

/// Falls that have failed: the damping of crushed elements grew over what explicit substeps follow, and a cell that turned brought a point into the
/// sphere that was moved out again in each step.
const MENDED: [u64; 2] = [95, 155];

/// 12 falls and those that have failed; those of `FALLS`, as `0..300`, if it is set.
#[test]
fn falling_bodies_do_not_enter_obstacles_and_gain_no_energy() {
    let asked = asked_cases("FALLS");
    let mended = MENDED.into_iter().filter(|_| asked.is_none());
    asked.clone().unwrap_or(0..12).chain(mended).for_each(|number| Fall::new(number).check());
}

/// A cloth of 200 mm above what `obstacle` says.
fn cloth(bench: &Bench, time: &str, obstacle: &str, threads: usize) -> Session {
    bench.write("rock.obj", scan(0, 600, 0, 77).text);
    bench.write("open.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    let text = format!(
        r#"
        format = 1
        gravity = [0, 0, -9.81]
        [time]
        {time}
        [[body]]
        shape = {{ kind = "sheet", cells = 24, size = [0.2, 0.2, 0] }}
        position = [-0.1, -0.1, 0.01]
        sheet = {{ warp = [1, 0, 0] }}
        material = {{ plugin = "cloth", params = {{ fabric = "interlock", damping-time = "20 ms" }} }}
        [[obstacle]]
        name = "thing"
        {obstacle}
        "#
    );
    open_file(&bench.write("scene.toml", text), threads, None)
}

const BALL: &str = "shape = { kind = \"sphere\", radius = 0.04 }\nposition = [0, 0, -0.041]";
const IMPLICIT: &str = "dt = 0.002\nintegrator = \"backward-euler\"";

#[test]
fn a_cloth_drapes_over_obstacles_without_entering_them() {
    for obstacle in [
        BALL,
        "shape = { kind = \"box\", size = [0.08, 0.08, 0.02] }\nposition = [0, 0, -0.011]",
        "mesh = \"rock.obj\"\nsize = 0.08\nposition = [0, 0, -0.045]",
        "mesh = \"open.obj\"\nscale = 0.05\nthickness = \"1 mm\"",
        "shape = { kind = \"capsule\", radius = 0.02, length = 0.1 }\nposition = [0, 0, -0.021]\nrotation = { axis = [1, 0, 0], angle = \"90 deg\" }",
    ] {
        let explicit = "dt = 0.0005\nintegrator = \"symplectic-euler\"\nmost-substeps = 300";
        for time in [IMPLICIT, explicit].into_iter().take(if obstacle == BALL { 2 } else { 1 }) {
            let mut session = cloth(&Bench::new(), time, obstacle, 1);
            let start = energy(&mut session);
            let (mut depth, mut most) = (f64::NEG_INFINITY, start);
            for _ in 0..(0.3 / session.dt()) as usize {
                session.step();
                depth = depth.max(deepest(&mut session));
                most = most.max(energy(&mut session));
            }
            assert!(session.bodies[0].frozen.is_none(), "{obstacle}, {time}: {:?}", session.bodies[0].frozen);
            assert!(depth < 1e-6, "{obstacle}, {time}: {depth} edges inside");
            assert!(
                most < start + 1e-3 * mass(&session) * G * 0.05,
                "{obstacle}, {time}: energy {start} J grew to {most} J"
            );
            let lifted = -session.obstacles()[0].force[2] / (mass(&session) * G);
            assert!(lifted > 0.2, "{obstacle}, {time}: it carries {lifted} of the weight");
        }
    }
}

#[test]
fn a_cloth_on_a_floor_rests_with_its_weight() {
    let mut session = cloth(&Bench::new(), IMPLICIT, "shape = { kind = \"plane\" }", 1);
    run(&mut session, 0.6);
    let weight = mass(&session) * G;
    let force = session.obstacles()[0].force;
    assert!((force + Vec3::new(0.0, 0.0, weight)).norm() < 0.01 * weight, "{force:?} N, weight {weight} N");
}

#[test]
fn threads_and_snapshots_change_no_byte() {
    let states = [1, 2].map(|threads| {
        let mut session = cloth(&Bench::new(), IMPLICIT, BALL, threads);
        (0..60).for_each(|_| session.step());
        let before = session.snapshot();
        let run = |session: &mut Session| {
            session.restore(&before).expect("its own");
            (0..40).for_each(|_| session.step());
            session.bodies[0].system.nodes.x.clone()
        };
        let [first, second] = [run(&mut session), run(&mut session)];
        assert!(first == second, "{threads} threads: not the same after a snapshot");
        first
    });
    assert!(states[0] == states[1], "threads change the result");
}

/// A block on a box that a ball presses: the box carries weight and press, and undo and redo come back to the byte.
#[test]
fn a_pressed_block_passes_the_force_on_to_the_box_below() {
    let text = r#"
        format = 1
        gravity = [0, 0, -9.81]
        [time]
        dt = 0.001
        integrator = "backward-euler"
        [[body]]
        name = "block"
        shape = { kind = "box", cells = 12, size = [0.06, 0.06, 0.06] }
        position = [0, 0, 0.0301]
        material = { plugin = "neo-hookean", params = { young = 3e4, density = 1000, damping-time = 0.01 } }
        grid = { level = 4, region = "whole" }
        [[obstacle]]
        name = "box"
        shape = { kind = "box", size = [0.04, 0.04, 0.02] }
        position = [0, 0, -0.01]
        [[device]]
        name = "hand"
        params = { path = [[0, 0, 0, 0.08], [0.1, 0, 0, 0.08], [0.3, 0, 0, 0.063], [1, 0, 0, 0.063]] }
        [[tool]]
        name = "ball"
        device = "hand"
        radius = "10 mm"
        slew = 1e6
        [[edit]]
        kind = "touch"
        tool = "ball"
        release = "keep"
        end = 0.6
        "#;
    let mut session = open(text, 1);
    session.keep_history();
    let mut depth = f64::NEG_INFINITY;
    while session.time() < 0.55 {
        session.step();
        depth = depth.max(deepest(&mut session));
    }
    let press = session.frame().tools[0].force.norm();
    let (weight, carried) = (mass(&session) * G, -session.obstacles()[0].force[2]);
    assert!(press > 0.1, "it is pressed by {press} N");
    assert!(
        (carried - weight - press).abs() < 0.02 * (weight + press),
        "{carried} N, weight {weight} N and press {press} N"
    );
    assert!(depth < 1e-5, "{depth} cells inside");
    run(&mut session, 0.65);
    let kept = session.bodies[0].system.nodes.x.clone();
    assert!(session.undo() && session.bodies[0].system.nodes.x != kept);
    assert!(session.redo() && session.bodies[0].system.nodes.x == kept, "redo comes back to the byte");
    run(&mut session, 0.9);
    assert!(deepest(&mut session) < 1e-5);
}

/// A vertex for each corner, and faces that are turned over, change nothing of an obstacle.
#[test]
fn an_obstacle_in_pieces_or_turned_over_is_the_one_that_it_looks_like() {
    for seed in 0..4 {
        let whole = scan(seed as u32 % 3, 400, 0, 90 + seed).document();
        let pieces = apart(&whole, |face| face);
        let mut turned = 0;
        let some_turned = pieces.text.lines().map(|line| {
            turned += usize::from(line.starts_with("f "));
            let corners: Vec<&str> = line.split(' ').collect();
            match corners[..] {
                ["f", a, b, c] if turned % 3 == 0 => format!("f {a} {c} {b}\n"),
                _ => format!("{line}\n"),
            }
        });
        let some_turned: String = some_turned.collect();
        let as_written = String::from_utf8(whole.bytes().to_vec()).expect("text");
        let positions = [&as_written, &pieces.text, &some_turned].map(|rock| {
            let bench = Bench::new();
            bench.write("rock.obj", rock);
            let scene = "format = 1\ngravity = [0, 0, -9.81]\n[time]\nduration = 0.1\nintegrator = \"backward-euler\"\n[[body]]\n\
                shape = { kind = \"box\", cells = 8, size = [0.06, 0.06, 0.06] }\nposition = [0, 0, 0.08]\nmaterial = { plugin = \"corotational\" }\n\
                grid = { level = 3, region = \"whole\" }\n[[obstacle]]\nname = \"rock\"\nmesh = \"rock.obj\"\nsize = 0.1\n";
            let mut session = open_file(&bench.write("scene.toml", scene), 1, None);
            let fallen = 0.03 + 0.5 * G * 0.15 * 0.15;
            run(&mut session, 0.15);
            let x = session.bodies[0].system.nodes.x.clone();
            let lowest = x.iter().fold(f64::INFINITY, |low, p| low.min(p.z));
            assert!(lowest > 0.08 - 0.03 - fallen, "scan {seed}: the body has met the obstacle");
            x
        });
        let size = 0.1;
        for x in &positions[1..] {
            let apart = x.iter().zip(&positions[0]).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            assert!(apart < 1e-9 * size, "scan {seed}: {apart} m apart");
        }
    }
}

#[test]
fn a_recording_with_obstacles_is_replayed_to_the_byte() {
    let bench = Bench::new();
    bench.write("rock.obj", scan(0, 600, 0, 77).text);
    let scene = "format = 1\ngravity = [0, 0, -9.81]\n[time]\nduration = 0.1\nintegrator = \"backward-euler\"\n[[body]]\nname = \"block\"\n\
        shape = { kind = \"box\", cells = 8, size = [0.06, 0.06, 0.06] }\nposition = [0, 0, 0.08]\nmaterial = { plugin = \"corotational\" }\n\
        grid = { level = 3, region = \"whole\" }\n[[obstacle]]\nname = \"rock\"\nmesh = \"rock.obj\"\nsize = 0.1\n\
        [[device]]\nname = \"hand\"\nparams = { path = [[0, 0, 0, 1]] }\n[[tool]]\nname = \"ball\"\ndevice = \"hand\"\nradius = 0.01\n\
        [[edit]]\nkind = \"touch\"\ntool = \"ball\"\n";
    bench.write("scene.toml", scene);
    bench.pliant(&["run", "scene.toml", "--out", "a", "--record", "a.rec", "-q"]).expect(0);
    bench.pliant(&["replay", "a.rec", "--out", "b", "-q"]).expect(0);
    assert!(bench.read("a/final.obj") == bench.read("b/final.obj"));
    let inputs = bench.summary("a")["inputs"].clone();
    let rocks = inputs.as_array().expect("a list").iter().filter(|input| input["role"] == "obstacle");
    let names: Vec<&str> = rocks.filter_map(|rock| rock["name"].as_str()).collect();
    assert!(matches!(names[..], [name] if name.ends_with("rock.obj")), "{inputs}");
    // A rock that has changed is not the one of the recording.
    bench.write("rock.obj", scan(0, 600, 0, 78).text);
    let replayed = bench.pliant(&["replay", "a.rec", "--out", "c", "-q"]);
    assert!(replayed.code != 0 && replayed.err.contains("rock.obj"), "{}", replayed.err);
}

/// A plate that comes up under a block lifts it, and carries weight and inertia.
#[test]
fn a_moving_obstacle_lifts_a_block() {
    let mut session = open(
        r#"
        format = 1
        gravity = [0, 0, -9.81]
        [time]
        dt = 0.001
        [[body]]
        shape = { kind = "box", cells = 12, size = [0.06, 0.06, 0.06] }
        position = [0, 0, 0.0301]
        material = { plugin = "corotational", params = { young = 2e5, density = 1000, damping-time = 0.01 } }
        grid = { level = 3, region = "whole" }
        [[obstacle]]
        name = "lift"
        shape = { kind = "box", size = [0.2, 0.2, 0.02] }
        position = [0, 0, -0.01]
        path = [[0.1, 0, 0, 0], [0.5, 0.02, 0, 0.02]]
        "#,
        1,
    );
    let height = |session: &Session| {
        let nodes = &session.bodies[0].system.nodes;
        nodes.x.iter().zip(&nodes.mass).map(|(x, m)| *m * *x).sum::<Vec3>() / nodes.mass.iter().sum::<f64>()
    };
    run(&mut session, 0.1);
    let before = height(&session);
    let mut depth = f64::NEG_INFINITY;
    while session.time() < 0.7 {
        session.step();
        depth = depth.max(deepest(&mut session));
    }
    let moved = height(&session) - before;
    assert!((moved - Vec3::new(0.02, 0.0, 0.02)).norm() < 1e-3, "it was carried by {moved:?} m");
    assert!(depth < 1e-5, "{depth} cells inside");
    let weight = mass(&session) * G;
    assert!((session.obstacles()[0].force[2] + weight).abs() < 0.01 * weight);
}

/// A thin plate is not passed by a sheet that is faster than its thickness in a step.
#[test]
fn fast_bodies_do_not_pass_thin_obstacles() {
    for speed in [2.0, 5.0, 10.0] {
        let plate = "shape = { kind = \"box\", size = [0.3, 0.3, 0.001] }\nposition = [0, 0, -0.01]";
        let mut session = cloth(&Bench::new(), IMPLICIT, plate, 1);
        session.bodies[0].system.nodes.v.fill(Vec3::new(0.0, 0.0, -speed));
        for _ in 0..50 {
            session.step();
            let lowest = session.bodies[0].system.nodes.x.iter().fold(f64::INFINITY, |least, x| least.min(x[2]));
            assert!(lowest > -0.0095 - 1e-8, "{speed} m/s: a vertex is at {lowest} m");
        }
    }
}

#[test]
fn warnings_name_body_and_obstacle() {
    let mut session = cloth(&Bench::new(), IMPLICIT, "shape = { kind = \"sphere\", radius = 0.04 }", 1);
    let has = |session: &Session, code: &str, text: &str| {
        session
            .warnings()
            .iter()
            .any(|w| w.code.name() == code && w.message.contains(text) && w.message.contains("`thing`"))
    };
    assert!(has(&session, "starts-inside", "`body`") && !has(&session, "meets-nothing", ""));
    session.step();
    assert!(!has(&session, "meets-nothing", "step"), "{:?}", session.warnings());
    let far = "shape = { kind = \"sphere\", radius = 0.001 }\nposition = [9, 0, 0]";
    let mut session = cloth(&Bench::new(), IMPLICIT, far, 1);
    assert!(has(&session, "coarse-sheet", "`body`") && !has(&session, "starts-inside", ""));
    session.step();
    assert!(has(&session, "meets-nothing", "1 steps"), "{:?}", session.warnings());
}

#[test]
fn wrong_obstacles_are_refused_with_what_is_allowed() {
    let bench = Bench::new();
    bench.write("open.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
    bench.write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    let cases: [(&str, &[&str]); 12] = [
        ("", &["`thing` has no surface", "`mesh` and `shape`"]),
        ("shape = { kind = \"plane\" }\nmesh = \"open.obj\"", &["`mesh` and `shape`; allowed is one of them"]),
        ("shape = { kind = \"cone\" }", &["`thing`", "`cone`", "`sphere`, `capsule`, `box`, `plane`"]),
        ("shape = { kind = \"sphere\" }", &["`sphere` without `radius`"]),
        ("shape = { kind = \"plane\" }\nscale = 0.001", &["`scale`", "is for a `mesh`"]),
        ("mesh = \"none.obj\"", &["no file", "none.obj"]),
        ("mesh = \"open.obj\"", &["`thing`", "not closed (4 border edges", "`thickness`"]),
        ("mesh = \"line.obj\"\nthickness = 0.001", &["`thing`", "no triangle with an area"]),
        ("mesh = \"open.obj\"\nthickness = -1", &["thickness is -1 m", "above 0"]),
        ("shape = { kind = \"plane\" }\nfriction = [0.1, 0.2]", &["friction [0.1, 0.2]"]),
        (
            "shape = { kind = \"plane\" }\npath = [[1, 0, 0, 0], [1, 0, 0, 1]]",
            &["row 2", "obstacle `thing`", "times rising"],
        ),
        ("shape = { kind = \"plane\" }\nplace = 1", &["unknown field `place`"]),
    ];
    let scene = |time: &str, obstacle: &str| {
        format!(
            "format = 1\n[time]\n{time}\n[[body]]\nshape = {{ kind = \"box\", size = [1, 1, 1] }}\nmaterial = {{ plugin = \"mass-spring\" }}\n\
             [[obstacle]]\nname = \"thing\"\n{obstacle}\n"
        )
    };
    for (obstacle, parts) in cases {
        bench.write("scene.toml", scene("", obstacle));
        bench.pliant(&["plan", "scene.toml"]).expect(2).says(&["scene.toml:"]).says(parts);
    }
    bench.write("scene.toml", scene("integrator = \"quasi-static\"", "shape = { kind = \"plane\" }"));
    bench.pliant(&["plan", "scene.toml"]).expect(2).says(&["obstacle `thing`", "quasi-static", "`backward-euler`"]);
}
