//! Tools of every shape on solids and sheets: what they carry at rest is what presses on them, and nothing stays inside of them.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_solver::Pool;
use pliant_tests::{Bench, NOW, box_scene, open};

const GRAVITY: f64 = 9.81;
/// Steps over which forces are averaged.
const MEAN_STEPS: u32 = 300;
/// Shapes whose lowest point is 4 mm below the hand when they are turned so.
const DOWN: [(&str, &str); 4] = [
    ("sphere", "shape = { kind = \"sphere\", radius = \"4 mm\" }"),
    (
        "capsule",
        "shape = { kind = \"capsule\", radius = \"4 mm\", length = \"8 mm\", rotation = { axis = [0, 1, 0], angle = \"90 deg\" } }",
    ),
    ("box", "shape = { kind = \"box\", size = [\"10 mm\", \"10 mm\", \"8 mm\"] }"),
    ("plane", "shape = { kind = \"plane\", rotation = { axis = [1, 0, 0], angle = \"180 deg\" } }"),
];

/// A block that is held far from a tool that presses it from above, at rest.
fn pressed(shape: &str, height: f64) -> Session {
    let path = format!("path = [[0.0, 0.0, 0.0, {}], [0.02, 0.0, 0.0, {height}]]", height + 0.004);
    let held = "grid = { level = 4, region = \"whole\" }\nfixed = [{ box = [[-1, -1, -1], [1, 1, -0.0199]] }]";
    let scene = box_scene("integrator = \"backward-euler\"", "", "")
        .replace("path = [[0.0, 0.0, 0.0, 0.006], [0.03, 0.0, 0.0, 0.001], [0.05, 0.002, 0.0, 0.001]]", &path)
        .replace("grid = { level = 5 }", held)
        // Without friction, which would keep a little of how it came there.
        .replace("radius = \"4 mm\"", &format!("{shape}\nfriction = [0, 0]"));
    let mut session = open(&scene, 1);
    (0..1500).for_each(|_| session.step());
    session
}

#[test]
fn on_a_solid_each_shape_carries_what_the_fixed_nodes_hold() {
    let mut forces = Vec::new();
    for (name, shape) in DOWN {
        let height = if name == "plane" { -0.002 } else { 0.002 };
        let mut session = pressed(shape, height);
        let felt = session.frame().tools[0];
        // Means over time: samples at the sharp edges of a box come in and go out, so its force varies from step to step by 4 % (one standard
        // deviation), and a momentum that stays bounded leaves the means equal.
        let (mut holding, mut hand) = (Vec3::zeros(), Vec3::zeros());
        for _ in 0..MEAN_STEPS {
            session.step();
            hand += session.frame().tools[0].force / f64::from(MEAN_STEPS);
            let system = &mut session.bodies[0].system;
            let mut elastic = vec![Vec3::zeros(); system.nodes.len()];
            let still = elastic.clone();
            system.forces(&Pool::new(1), Some(&still), NOW, &mut elastic).unwrap();
            let held = (0..elastic.len()).filter(|&i| !system.nodes.constraint[i].is_free());
            holding += held.map(|i| elastic[i]).sum::<Vec3>() / f64::from(MEAN_STEPS);
        }
        // Along the press. Sideways a capsule on the samples of a flat top is not at rest, and off by 5 % of the force.
        let off = (holding.z + hand.z).abs() / hand.norm();
        // What backward Euler has not brought to rest yet.
        assert!(off < 1e-2, "{name}: held by {holding:?}, hand {hand:?}");
        assert!(felt.contact.is_some() && felt.force[2] > 0.02, "{name}: {felt:?}");
        forces.push(hand.z);
    }
    assert!(forces.windows(2).all(|pair| pair[0] < pair[1]), "the wider, the more it takes: {forces:?}");
}

/// A free sheet of 0.1 m that falls onto a tool from a millimetre above.
fn dropped(shape: &str, friction: f64, height: f64, steps: usize) -> Session {
    let scene = format!(
        r#"
        format = 1
        gravity = [0, 0, -{GRAVITY}]
        [time]
        duration = 10
        dt = 1e-3
        integrator = "backward-euler"
        [solver]
        tolerance = 1e-8
        [[body]]
        shape = {{ kind = "sheet", cells = 16, size = [0.1, 0.1, 0] }}
        sheet = {{ warp = [1, 0, 0] }}
        position = [-0.05, -0.05, {height}]
        [body.material]
        plugin = "cloth"
        params = {{ density = 0.15, young-warp = 500, poisson = 0.3, bending-warp = 10e-6, damping-time = 1e-2 }}
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0, 0, 0], [1, 0, 0, 0]] }}
        [[tool]]
        name = "support"
        device = "hand"
        slew = "1e9 N/s"
        friction = [{friction}, {friction}]
        {shape}
        [[edit]]
        kind = "touch"
        tool = "support"
        "#
    );
    let mut session = open(&scene, 1);
    (0..steps).for_each(|_| session.step());
    session
}

/// Mass of the sheet, kg, and velocity of its centre of mass, m/s.
fn motion(session: &Session) -> (f64, Vec3) {
    let nodes = &session.bodies[0].system.nodes;
    let mass: f64 = nodes.mass.iter().sum();
    (mass, nodes.mass.iter().zip(&nodes.v).map(|(m, v)| *m * *v).sum::<Vec3>() / mass)
}

#[test]
fn a_sheet_on_each_shape_gives_it_all_its_momentum_and_stays_outside() {
    let capsule = r#"{ kind = "capsule", radius = "20 mm", length = "60 mm", rotation = { axis = [0, 1, 0], angle = "90 deg" } }"#;
    for (name, shape, top) in [
        ("sphere", r#"{ kind = "sphere", radius = "40 mm" }"#, 0.04),
        ("capsule", capsule, 0.02),
        ("box", r#"{ kind = "box", size = ["60 mm", "60 mm", "40 mm"] }"#, 0.02),
        ("plane", r#"{ kind = "plane" }"#, 0.0),
    ] {
        // In the air for 14 ms, then in contact.
        let mut session = dropped(&format!("shape = {shape}"), 0.3, top + 0.001, 50);
        let (mass, before) = motion(&session);
        let (mut impulse, steps) = (Vec3::zeros(), 100);
        for _ in 0..steps {
            session.step();
            impulse += 1e-3 * session.frame().tools[0].force;
        }
        let weight = mass * GRAVITY * 1e-3 * f64::from(steps);
        let gained = mass * (motion(&session).1 - before);
        // Newton: what the sheet does not gain of its weight, the hand feels, but for normals that turn in a step: v dt / r, some 5e-3, of
        // the part of the weight that slides.
        let off = (gained + impulse + Vec3::new(0.0, 0.0, weight)).norm() / weight;
        assert!(off < 1e-3 && impulse[2] < -0.1 * weight, "{name}: {off}, {impulse:?} of {weight} N s");
        let (tool, nodes) = (&session.tools[0].tool, &session.bodies[0].system.nodes);
        let shape = &tool.proxy.shape;
        let least = nodes.x.iter().map(|x| shape.distance(x - tool.proxy.position)).fold(f64::INFINITY, f64::min);
        // Constraints hold velocities along tangent planes: around a radius r a slide of v dt goes (v dt)^2 / 2 r inside.
        assert!(least > -1e-5, "{name}: a vertex is {least} m inside");
    }
}

#[test]
fn a_sheet_slides_down_a_tilted_plane_as_friction_lets_it() {
    let tilt = 20.0_f64.to_radians();
    let shape = "shape = { kind = \"plane\", rotation = { axis = [0, 1, 0], angle = \"20 deg\" } }";
    // The sheet lies on the plane from the start, turned as it is.
    for (friction, wanted) in
        [(0.0, GRAVITY * tilt.sin()), (0.2, GRAVITY * (tilt.sin() - 0.2 * tilt.cos())), (0.5, 0.0)]
    {
        let mut session = dropped(shape, friction, 0.05 * tilt.tan() + 2e-3, 600);
        let start = motion(&session).1;
        (0..200).for_each(|_| session.step());
        let gained = (motion(&session).1 - start) / 0.2;
        let down = Vec3::new(tilt.cos(), 0.0, -tilt.sin());
        let along = gained.dot(&down);
        assert!((along - wanted).abs() < 0.03 * GRAVITY, "friction {friction}: {along} m/s^2 for {wanted}, {gained:?}");
    }
}

#[test]
fn a_turning_hand_turns_its_box() {
    // A box edge-on, 4 mm out by its face and 5.66 mm by its edge: at the same height it presses only if it is turned.
    let flat = "shape = { kind = \"box\", size = [\"8 mm\", \"20 mm\", \"8 mm\"] }";
    let turned = "shape = { kind = \"box\", size = [\"8 mm\", \"20 mm\", \"8 mm\"], rotation = { axis = [0, 1, 0], angle = \"45 deg\" } }";
    assert_eq!(pressed(flat, 0.0045).frame().tools[0].force, Vec3::zeros());
    assert!(pressed(turned, 0.0045).frame().tools[0].force[2] > 0.02);
}

#[test]
fn a_wrong_shape_is_refused_with_what_is_allowed() {
    let dir = Bench::new();
    let with = |tool: &str| box_scene("", "", "").replace("radius = \"4 mm\"", tool);
    for (tool, says) in [
        ("", "tool `finger` has no shape; allowed is `radius`, of a sphere, or `shape`"),
        (
            "radius = \"4 mm\"\nshape = { kind = \"plane\" }",
            "tool `finger` has `radius` and `shape`; allowed is one of them",
        ),
        ("shape = { kind = \"cone\" }", "tool `finger`: shape `cone`; allowed is `sphere`, `capsule`, `box`, `plane`"),
        (
            "shape = { kind = \"capsule\", radius = \"4 mm\" }",
            "`capsule` without `length`; it needs `radius`, `length`",
        ),
        (
            "shape = { kind = \"box\", size = [1, 0, 1] }",
            "`size` of a `box` is 0 m; allowed is a finite length above 0",
        ),
    ] {
        dir.write("scene.toml", with(tool));
        dir.pliant(&["run", "scene.toml"]).expect(2).says(&["scene.toml:", says]);
    }
}
