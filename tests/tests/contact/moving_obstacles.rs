//! Obstacles that turn along a path, and that bodies bounce from: a block on a tilting plane and on a turntable, drops with restitution.

use pliant_engine::session::{EventKind, Session};
use pliant_mesh::geometry::Vec3;
use pliant_tests::{Bench, open};

/// m/s^2
const G: f64 = 9.81;

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
}

/// A stiff block of 20 mm whose bottom is at `z` (m) and whose middle is at `x` (m), with an obstacle.
fn block([x, z]: [f64; 2], time: &str, obstacle: &str) -> Session {
    open(
        &format!(
            "format = 1\ngravity = [0, 0, -{G}]\n[time]\nduration = 10\n{time}\n[[body]]\n\
             shape = {{ kind = \"box\", cells = 4, size = [0.02, 0.02, 0.02] }}\nposition = [{x}, 0, {}]\n\
             grid = {{ level = 3, region = \"whole\" }}\n\
             material = {{ plugin = \"corotational\", params = {{ young = \"200 kPa\", damping-time = \"0.1 ms\" }} }}\n\
             [[obstacle]]\nname = \"table\"\nfriction = [0.45, 0.45]\n{obstacle}\n",
            z + 0.01
        ),
        1,
    )
}

/// Middle (m), mean velocity (m/s) of a body, by mass.
fn middle(session: &Session) -> (Vec3, Vec3) {
    let nodes = &session.bodies[0].system.nodes;
    let mass: f64 = nodes.mass.iter().sum();
    let mean = |field: &[Vec3]| field.iter().zip(&nodes.mass).map(|(v, m)| *m * v).sum::<Vec3>() / mass;
    (mean(&nodes.x), mean(&nodes.v))
}

/// A plane that tilts about the y axis carries the block up to the angle of friction; beyond, the block slides with g (sin - mu cos).
#[test]
fn a_block_on_a_tilting_plane_sticks_up_to_the_angle_of_friction() {
    for time in
        ["integrator = \"backward-euler\"", "integrator = \"bdf2\"\ndt = 0.002", "integrator = \"symplectic-euler\""]
    {
        // atan(0.45) is 24.2 degrees.
        for (degrees, slides) in [(20.0_f64, false), (35.0, true)] {
            let plane =
                format!("shape = {{ kind = \"plane\" }}\nrotation-path = [[0.1, 0, 0, 0], [1.1, 0, {degrees}, 0]]");
            let mut session = block([0.0, 0.0], time, &plane);
            run(&mut session, 1.1);
            let angle = degrees.to_radians();
            // Down the plane, and out of it: a turn about +y leads x down.
            let (down, out) = (Vec3::new(angle.cos(), 0.0, -angle.sin()), Vec3::new(angle.sin(), 0.0, angle.cos()));
            let what = format!("{time}, {degrees} degrees");
            // The plane has stopped; what that has shaken dies away.
            run(&mut session, 0.05);
            let (_, moving) = middle(&session);
            run(&mut session, 0.1);
            let (at, v) = middle(&session);
            assert!((at.dot(&out) - 0.01).abs() < 3e-4, "{what}: its middle is {} m above the plane", at.dot(&out));
            if !slides {
                assert!(at.dot(&down).abs() < 5e-5, "{what}: it has slid by {} m", at.dot(&down));
                assert!(v.norm() < 5e-3, "{what}: {v:?}");
                continue;
            }
            let exact = G * (angle.sin() - 0.45 * angle.cos());
            let found = (v - moving).dot(&down) / 0.1;
            assert!((found / exact - 1.0).abs() < 0.03, "{what}: it slides with {found} m/s^2, exact {exact}");
            assert_eq!(session.events.count(EventKind::Quarantine), 0, "{what}");
        }
    }
}

/// A turntable carries the block round by friction while w^2 r is less than mu g.
#[test]
fn a_turntable_carries_a_block_round() {
    // It starts within 0.2 s and turns by 90 degrees a second then: w^2 r is 0.07 m/s^2.
    let rows: Vec<String> = (0..=20)
        .map(|i| {
            let t = 0.05 * f64::from(i);
            let turned = if t < 0.2 { 90.0 * t * t / 0.4 } else { 90.0 * (t - 0.1) };
            format!("[{}, 0, 0, {turned}]", t + 0.05)
        })
        .collect();
    let several = "integrator = \"backward-euler\"\n[solver]\nnewton = 4";
    for time in ["integrator = \"backward-euler\"", several, "integrator = \"symplectic-euler\""] {
        let table = format!(
            "shape = {{ kind = \"box\", size = [0.2, 0.2, 0.01] }}\nposition = [0, 0, -0.005]\nrotation-path = [{}]",
            rows.join(", ")
        );
        let mut session = block([0.03, 0.0], time, &table);
        run(&mut session, 1.05);
        let (at, _) = middle(&session);
        let angle = 81.0_f64.to_radians();
        let exact = 0.03 * Vec3::new(angle.cos(), angle.sin(), 0.0);
        let off = (at - exact).xy().norm();
        assert!(off < 5e-4, "{time}: {at:?}, exact {exact:?}");
        // It has turned with the table.
        let nodes = &session.bodies[0].system.nodes;
        let far = (0..nodes.len()).max_by(|a, b| nodes.rest[*a].x.total_cmp(&nodes.rest[*b].x)).expect("nodes");
        let (rest, now) = (nodes.rest[far] - Vec3::new(0.03, 0.0, 0.01), nodes.x[far] - at);
        let turned = f64::atan2(rest.x * now.y - rest.y * now.x, rest.x * now.x + rest.y * now.y);
        assert!((turned - angle).abs() < 0.02, "{time}: it has turned by {turned}, the table by {angle}");
    }
}

/// A wheel that turns under a block at rest drags it by friction alone, and no point of the block is ever inside.
#[test]
fn nothing_enters_an_obstacle_that_turns() {
    for time in ["integrator = \"backward-euler\"\ndt = 0.004", "integrator = \"symplectic-euler\""] {
        let beam = "shape = { kind = \"box\", size = [0.12, 0.03, 0.01] }\nposition = [0, 0, -0.02]\n\
            rotation-path = [[0, 0, 0, 0], [0.5, 0, 150, 0]]";
        let mut session = block([0.035, 0.01], time, beam);
        for _ in 0..(0.5 / session.dt()).round() as usize {
            session.step();
            session.update_surface();
            let table = &session.obstacles()[0];
            let deepest = session.bodies[0].skin.x.iter().map(|x| -table.distance(*x)).fold(0.0, f64::max);
            assert!(deepest < 1e-5, "{time}: {deepest} m deep at {} s", session.time());
        }
        let (at, _) = middle(&session);
        assert!((at - Vec3::new(0.035, 0.0, 0.02)).norm() > 0.02, "{time}: it was thrown to {at:?}");
    }
}

/// A sheet that falls flat has all its mass at vertices that bounce: it rises again to e^2 of the height.
#[test]
fn a_sheet_bounces_to_the_square_of_the_restitution() {
    let height = 0.05;
    for restitution in [0.0, 0.3, 0.7, 1.0] {
        let mut errors = Vec::new();
        for dt in [2e-3, 1e-3, 0.5e-3] {
            let mut session = open(
                &format!(
                    "format = 1\ngravity = [0, 0, -{G}]\n[time]\nduration = 10\ndt = {dt}\nintegrator = \"implicit-midpoint\"\n[[body]]\n\
                     shape = {{ kind = \"sheet\", cells = 6, size = [0.06, 0.06, 0] }}\nposition = [-0.03, -0.03, {height}]\nsheet = {{}}\n\
                     material = {{ plugin = \"cloth\" }}\n[[obstacle]]\nname = \"floor\"\nshape = {{ kind = \"plane\" }}\n\
                     restitution = {restitution}\n"
                ),
                1,
            );
            let fall = (2.0 * height / G).sqrt();
            run(&mut session, fall + 0.5 * dt);
            let mut highest = 0.0_f64;
            // Beyond the top of the way; without a rebound half as long as the fall.
            for _ in 0..(f64::max(2.2 * restitution, 0.5) * fall / dt) as usize {
                session.step();
                highest = highest.max(middle(&session).0.z);
            }
            errors.push((highest - restitution * restitution * height).abs());
        }
        // Within the way of a step at the speed of the fall.
        let speed = (2.0 * G * height).sqrt();
        for (error, dt) in errors.iter().zip([2e-3, 1e-3, 0.5e-3]) {
            assert!(*error < 2.0 * speed * dt, "restitution {restitution}, {dt} s: off by {error} m");
        }
    }
}

/// A block, which bounces by its own elasticity too, gets no more than its energy back.
#[test]
fn a_block_that_bounces_gains_no_energy() {
    let rise = |time: &str, restitution: f64| {
        let floor = format!("shape = {{ kind = \"plane\" }}\nrestitution = {restitution}");
        let mut session = block([0.0, 0.05], time, &floor);
        run(&mut session, (2.0 * 0.05 / G).sqrt() + 0.005);
        let mut highest = 0.0_f64;
        for _ in 0..(0.25 / session.dt()) as usize {
            session.step();
            highest = highest.max(middle(&session).0.z - 0.01);
        }
        highest
    };
    for time in
        ["integrator = \"backward-euler\"", "integrator = \"implicit-midpoint\"", "integrator = \"symplectic-euler\""]
    {
        let rises = [0.0, 0.5, 1.0].map(|restitution| rise(time, restitution));
        assert!(rises.iter().all(|rise| *rise <= 0.0502), "{time}: {rises:?} m");
        // Without the losses of the scheme its elasticity throws it up as far.
        assert!(time.contains("symplectic") || rises[2] > rises[0] + 1e-3, "{time}: {rises:?} m");
    }
}

#[test]
fn a_bad_path_or_restitution_is_refused_by_name() {
    let cases: [(&str, &[&str]); 3] = [
        ("restitution = 1.5", &["restitution 1.5", "0 to 1"]),
        ("restitution = -0.1", &["restitution -0.1", "0 to 1"]),
        (
            "rotation-path = [[1, 0, 0, 0], [0, 0, 0, 90]]",
            &["row 2 of the path of the rotation of obstacle `table`", "times rising"],
        ),
    ];
    for (obstacle, said) in cases {
        let bench = Bench::new();
        let text = pliant_tests::box_scene("", "", "");
        let text = format!(
            "{text}[[obstacle]]\nname = \"table\"\nshape = {{ kind = \"plane\" }}\nposition = [0, 0, -1]\n{obstacle}\n"
        );
        bench.write("scene.toml", text);
        let ran = bench.pliant(&["run", "scene.toml", "--out", "out"]).expect(2);
        assert!(ran.err.starts_with("error: scene.toml:"), "{obstacle}: {}", ran.err);
        ran.says(said);
    }
}
