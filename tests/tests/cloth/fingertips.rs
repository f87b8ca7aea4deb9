//! Fingertips on sheets: rebound, fast tips, sheets that are coarse against the tip, penalty.

use pliant_engine::session::{EventKind, Session};
use pliant_solver::Vec3;
use pliant_tests::open;

const DENSITY: f64 = 0.15;

/// A sheet of 0.2 m with `cells` along its edges, and a tip of 8 mm that goes along `path`.
fn scene(cells: u32, gravity: f64, held: &str, path: &str, tool: &str, time: &str) -> Session {
    let scene = format!(
        r#"
        format = 1
        gravity = [0, 0, {gravity}]
        [time]
        {time}
        [solver]
        tolerance = 1e-8
        [[body]]
        shape = {{ kind = "sheet", cells = {cells}, size = [0.2, 0.2, 0] }}
        sheet = {{ warp = [1, 0, 0] }}
        {held}
        [body.material]
        plugin = "cloth"
        params = {{ density = {DENSITY}, young-warp = 500, poisson = 0.3, bending-warp = 10e-6, damping-time = 1e-2 }}
        [[device]]
        name = "hand"
        params = {{ path = {path} }}
        [[tool]]
        name = "finger"
        device = "hand"
        slew = "1e9 N/s"
        {tool}
        [[edit]]
        kind = "touch"
        tool = "finger"
        "#
    );
    open(&scene, 1)
}

const FRAME: &str = "fixed = [{ box = [[-1, 0.1999, -1], [1, 1, 1]] }, { box = [[-1, -1, -1], [1, 0.0001, 1]] },
    { box = [[-1, -1, -1], [0.0001, 1, 1]] }, { box = [[0.1999, -1, -1], [1, 1, 1]] }]";

/// Nodes that are the sheet's own.
fn velocities(session: &Session) -> &[Vec3] {
    &session.bodies[0].system.nodes.v[..session.bodies[0].model.surface.points.len()]
}

#[test]
fn a_sheet_leaves_a_hard_ball_with_its_restitution() {
    // A ball so large that it is a plane, and a sheet that falls flat on it: every vertex rebounds with e times its speed.
    for e in [0.0, 0.4, 0.9] {
        let tool = format!("radius = 1e4\nrestitution = {e}\nfriction = [0, 0]\nsheets = \"vertices\"");
        let path = "[[0, 0.1, 0.1, -10000.005], [1, 0.1, 0.1, -10000.005]]";
        let mut session = scene(4, -9.81, "", path, &tool, "duration = 1\ndt = 1e-4\nintegrator = \"backward-euler\"");
        let (mut before, mut after) = (0.0, 0.0);
        for _ in 0..420 {
            session.step();
            let mean = velocities(&session).iter().map(|v| v[2]).sum::<f64>() / velocities(&session).len() as f64;
            (before, after) = (f64::min(before, mean), f64::max(after, mean));
        }
        let met = -(2.0 * 9.81 * 0.005_f64).sqrt();
        assert!((before / met - 1.0).abs() < 0.01, "met it with {before} m/s, of {met}");
        // Of the speed that is left, one step of gravity is gone.
        assert!((after + e * before).abs() < 0.01 * -before, "e {e}: {before} m/s became {after} m/s");
    }
}

#[test]
fn a_tip_that_is_fast_does_not_jump_over_a_sheet() {
    // 40 mm in each step of 10 ms: five radii.
    for (cells, by) in [(40, "vertices"), (40, "penalty"), (8, "triangles")] {
        let tool = format!("radius = \"8 mm\"\nspeed = \"10 m/s\"\nstiffness = 500\nsheets = \"{by}\"");
        let path = "[[0, 0.101, 0.102, 0.06], [0.02, 0.101, 0.102, -0.02], [1, 0.101, 0.102, -0.02]]";
        let time = "duration = 1\ndt = 0.01\nintegrator = \"backward-euler\"";
        let mut session = scene(cells, 0.0, FRAME, path, &tool, time);
        (0..60).for_each(|_| session.step());
        let force = session.frame().tools[0].force;
        assert!(force[2] > 0.05, "{by}: the tip is held back, {force:?} N");
        assert!(session.frame().tools[0].contact.is_some());
    }
}

#[test]
fn a_tip_that_slides_meets_vertices_where_they_come_to_it() {
    // Held fast by friction for a step, a vertex of a taut sheet would be pulled at, and let into the tip.
    let hung = "fixed = [{ box = [[-1, 0.1999, -1], [1, 1, 1]] }]";
    let path = "[[0, 0.1, 0.1, 0.009], [0.2, 0.1, 0.1, -0.002], [1, 0.14, 0.1, -0.002]]";
    let tool = "radius = \"8 mm\"\nfriction = [0.35, 0.3]\nsheets = \"vertices\"";
    let mut session = scene(31, 0.0, hung, path, tool, "duration = 1\ndt = 0.001\nintegrator = \"backward-euler\"");
    let (mut deepest, mut met) = (0.0_f64, 0);
    for _ in 0..500 {
        session.step();
        let tip = session.frame().tools[0];
        let depth = |x: &Vec3| 0.008 - (*x - tip.proxy).norm();
        deepest = session.bodies[0].system.nodes.x.iter().map(depth).fold(deepest, f64::max);
        met += usize::from(tip.contact.is_some());
    }
    assert!(met > 140, "it touches in {met} steps");
    assert!(deepest < 1e-6, "{deepest} m inside");
}

#[test]
fn a_sheet_follows_a_tip_that_draws_back() {
    // 10 mm deep, and back at 20 mm/s, 20 um in a step: the force goes down as it came, with no step without it.
    let path = "[[0, 0.1, 0.1, 0.009], [0.1, 0.1, 0.1, -0.002], [0.3, 0.1, 0.1, -0.002], [0.7, 0.1, 0.1, 0.006]]";
    let tool = "radius = \"8 mm\"\nsheets = \"vertices\"";
    let time = "duration = 1\ndt = 0.001\nintegrator = \"backward-euler\"";
    let mut session = scene(40, 0.0, FRAME, path, tool, time);
    (0..300).for_each(|_| session.step());
    let pressed = session.frame().tools[0].force[2];
    let (mut before, mut jump) = (pressed, 0.0_f64);
    for step in 300..700 {
        session.step();
        let tip = session.frame().tools[0];
        assert!(tip.contact.is_some(), "step {step} does not touch");
        jump = jump.max((tip.force[2] - before).abs());
        before = tip.force[2];
    }
    assert!(before < 0.2 * pressed && jump < 0.12 * pressed, "{pressed} N became {before} N, by up to {jump} N a step");
}

#[test]
fn triangles_hold_a_tip_that_fits_between_vertices() {
    // Cells of 50 mm: no vertex comes near a tip of 8 mm.
    let path = "[[0, 0.11, 0.12, 0.012], [0.1, 0.11, 0.12, 0.002], [9, 0.11, 0.12, 0.002]]";
    let tool = "radius = \"8 mm\"\nstiffness = 300";
    let time = "duration = 9\nintegrator = \"backward-euler\"";
    let mut session = scene(4, 0.0, FRAME, path, tool, time);
    assert_eq!(session.choices.contacts[0].by, "triangles");
    (0..4000).for_each(|_| session.step());
    let felt = session.frame().tools[0];
    let body = &session.bodies[0];
    let nodes = &body.system.nodes;
    let border = (0..nodes.len()).filter(|i| !nodes.constraint[*i].is_free());
    let border: Vec3 = border.map(|i| session.reactions(0)[i]).sum();
    assert!(felt.force[2] > 0.01 && (felt.force - border).norm() < 0.01 * felt.force[2], "{felt:?} {border:?}");
    let corners = |t: &[u32; 3]| t.map(|v| nodes.x[v as usize]);
    let nearest = body
        .model
        .surface
        .triangles
        .iter()
        .map(|t| (pliant_mesh::geometry::closest_point(felt.proxy, corners(t)).point - felt.proxy).norm());
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    assert!((nearest / 0.008 - 1.0).abs() < 1e-3, "the sheet lies on the tip: {nearest} m from its centre");
    assert_eq!(session.events.count(EventKind::NotConverged) + session.events.count(EventKind::Quarantine), 0);
}

#[test]
fn a_penalty_is_as_deep_as_its_force_needs_and_a_constraint_is_not_deep() {
    let path = "[[0, 0.1, 0.1, 0.009], [0.05, 0.1, 0.1, -0.002], [9, 0.1, 0.1, -0.002]]";
    let pressed = |by: &str, stiffness: f64| {
        let tool = format!("radius = \"8 mm\"\nstiffness = {stiffness}\nsheets = \"{by}\"\nfriction = [0, 0]");
        let mut session = scene(30, 0.0, FRAME, path, &tool, "duration = 9\nintegrator = \"backward-euler\"");
        (0..300).for_each(|_| session.step());
        let felt = session.frame().tools[0];
        let depth = |x: &Vec3| (0.008 - (*x - felt.proxy).norm()).max(0.0);
        let deep: Vec<f64> = session.bodies[0].system.nodes.x.iter().map(depth).collect();
        // What springs of this stiffness give, along the tip's normals.
        let pushed = session.bodies[0].system.nodes.x.iter().zip(&deep).fold(Vec3::zeros(), |sum, (x, d)| {
            let out = *x - felt.proxy;
            sum - stiffness * d / out.norm() * out
        });
        (felt.force[2], deep.into_iter().fold(0.0, f64::max), pushed[2])
    };
    let (exact, none, _) = pressed("vertices", 500.0);
    assert!(none < 1e-6, "{none} m inside");
    for stiffness in [50.0, 500.0] {
        let (force, deep, pushed) = pressed("penalty", stiffness);
        assert!(deep > 1e-5 && (force / pushed - 1.0).abs() < 0.01, "{force} N of {pushed} N, {deep} m");
        assert!(force < exact, "softer than the constraint: {force} N of {exact} N");
    }
    let (soft, hard) = (pressed("penalty", 50.0), pressed("penalty", 500.0));
    assert!((hard.0 - exact).abs() < (soft.0 - exact).abs() && hard.1 < soft.1, "{soft:?} {hard:?} {exact}");
}

/// A tip that stands still finds the vertices that come to it from afar.
#[test]
fn a_sheet_that_falls_from_above_lands_on_a_tip_that_stands_still() {
    for [height, dt] in [[0.02, 1e-3], [0.1, 1e-3], [0.3, 2e-3]] {
        let path = format!("[[0, 0.1, 0.1, {}]]", -0.041 - height);
        let time = format!("dt = {dt}\nduration = 9\nintegrator = \"backward-euler\"");
        let mut session = scene(20, -9.81, "", &path, "radius = \"40 mm\"\nfriction = [1, 1]", &time);
        let (falls, speed) = ((2.0 * height / 9.81_f64).sqrt(), (2.0 * height * 9.81_f64).sqrt());
        let deepest = |session: &Session| {
            let tip = Vec3::new(0.1, 0.1, -0.041 - height);
            session.bodies[0].system.nodes.x.iter().map(|x| 0.04 - (x - tip).norm()).fold(0.0, f64::max)
        };
        let mut depth = 0.0_f64;
        while session.time() < falls + 0.1 {
            session.step();
            depth = depth.max(deepest(&session));
        }
        assert!(session.frame().tools[0].force.norm() > 0.0, "from {height} m: nothing is felt");
        assert!(depth < 0.25 * speed * dt + 1e-4, "from {height} m: {depth} m inside");
    }
}
