//! Implicit steps of a pressed cloth: preconditioners agree, threads agree, and what is nothing stays nothing.

use pliant_engine::session::Session;
use pliant_mesh::geometry::Vec3;
use pliant_tests::open;

/// A cloth of `n` cells a side that hangs by its top row, pressed by a fingertip from the start.
fn pressed(n: u32, pattern: &str, time: &str, solver: &str, gravity: f64, threads: usize) -> Session {
    let scene = format!(
        r#"
        format = 1
        gravity = [0, {gravity}, 0]
        [time]
        duration = 2
        integrator = "backward-euler"
        {time}
        [solver]
        {solver}
        [[body]]
        shape = {{ kind = "sheet", cells = {n}, rows = {n}, pattern = "{pattern}", size = [0.2, 0.2, 0] }}
        sheet = {{ warp = [1, 0, 0] }}
        material = {{ plugin = "cloth", params = {{ density = 0.15, young-warp = 500, poisson = 0.3, bending-warp = 10e-6 }} }}
        [[body.fixed]]
        box = [[-1, 0.19999, -1], [1, 1, 1]]
        [[device]]
        name = "hand"
        params = {{ path = [[0, 0.1, 0.1, 0.009], [0.03, 0.1, 0.1, 0.003], [0.2, 0.13, 0.1, -0.002]] }}
        [[tool]]
        name = "finger"
        device = "hand"
        radius = "8 mm"
        friction = [0.35, 0.3]
        slew = "1e9 N/s"
        [[edit]]
        kind = "touch"
        tool = "finger"
        "#
    );
    open(&scene, threads)
}

/// Positions after `steps`, and the iterations they took.
fn run(session: &mut Session, steps: usize) -> (Vec<Vec3>, usize) {
    let mut iterations = 0;
    for _ in 0..steps {
        session.step();
        iterations += session.frame().iterations;
    }
    (session.bodies[0].system.nodes.x.clone(), iterations)
}

#[test]
fn levels_give_the_same_motion_in_far_fewer_iterations() {
    for pattern in ["alternating", "irregular"] {
        let [(jacobi, many), (levels, few)] = ["block-jacobi", "multilevel"].map(|preconditioner| {
            let solver = format!("tolerance = 1e-10\niterations = 5000\npreconditioner = \"{preconditioner}\"");
            let mut session = pressed(32, pattern, "", &solver, -9.81, 1);
            let done = run(&mut session, 25);
            assert!(session.frame().tools[0].contact.is_some(), "{pattern}: a fingertip holds vertices");
            assert_eq!(session.choices.preconditioners[0].preconditioner, preconditioner);
            done
        });
        let apart = jacobi.iter().zip(&levels).map(|(a, b)| *a - *b).map(|d| d.norm());
        let apart = apart.fold(0.0, f64::max);
        // Which vertices stick and which slide is decided anew in each step, and magnifies what solves leave.
        assert!(apart < 1e-5, "{pattern}: {apart} m");
        assert!(apart > 0.0, "two ways, not one");
        assert!(2 * few < many, "{pattern}: {few} iterations, {many} without levels");
    }
}

#[test]
fn a_pressed_cloth_has_the_same_bytes_for_any_number_of_threads() {
    let bytes = [1, 2, 4].map(|threads| {
        let mut session = pressed(40, "irregular", "", "tolerance = 1e-4", -9.81, threads);
        assert_eq!(session.choices.preconditioners[0].preconditioner, "multilevel");
        run(&mut session, 25).0.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>()
    });
    assert!(bytes[0] == bytes[1] && bytes[0] == bytes[2]);
}

#[test]
fn the_choice_is_explained() {
    let why = |n: u32, time: &str| {
        let session = pressed(n, "alternating", time, "tolerance = 1e-4", -9.81, 1);
        let chosen = &session.choices.preconditioners[0];
        (chosen.preconditioner, chosen.why.clone())
    };
    let (name, text) = why(32, "");
    assert!(name == "multilevel" && text.contains("1089 nodes"), "{name}: {text}");
    let (name, text) = why(8, "");
    assert!(name == "block-jacobi" && text.contains("81 nodes"), "{name}: {text}");
    let (name, text) = why(32, "dt = 1e-5");
    assert!(name == "block-jacobi" && text.contains("fastest frequency"), "{name}: {text}");
}

#[test]
fn a_cloth_at_rest_takes_no_iterations() {
    let mut session = pressed(20, "alternating", "", "tolerance = 1e-8", 0.0, 1);
    session.step();
    assert!(session.frame().tools[0].contact.is_none());
    let (_, iterations) = run(&mut session, 3);
    assert_eq!(iterations, 0, "what is left of the forces is rounding");
}

#[test]
fn the_first_touch_of_a_flat_cloth_leaves_no_denormal_numbers() {
    let solver = "tolerance = 1e-4\npreconditioner = \"block-jacobi\"";
    let mut session = pressed(48, "alternating", "dt = 1e-4", solver, 0.0, 1);
    let mut least = f64::INFINITY;
    for _ in 0..400 {
        session.step();
        let speeds = session.bodies[0].system.nodes.v.iter().flatten().map(|c| c.abs());
        least = speeds.filter(|c| *c > 0.0).fold(least, f64::min);
    }
    assert!(session.frame().tools[0].contact.is_some());
    assert!((1e-40..1e-20).contains(&least), "the smallest speed was {least} m/s");
}
