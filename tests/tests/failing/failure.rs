//! Elements that have failed because their material says so (`pliant.failure/1`): a strip that tears takes the fracture energy of its cross-section
//! whatever the mesh; what has failed is out of forces, matrices, pictures and files, and an undo brings it back.

use pliant_engine::session::{EventKind, Session};
use pliant_mesh::generate::Pattern;
use pliant_mesh::{ObjDocument, Surface};
use pliant_solver::{Pool, StepTime, Vec3};
use pliant_tests::cloth::sheet;
use pliant_tests::pulling::pull_apart;
use pliant_tests::{Bench, open_file, root};
use std::fmt::Write;
use std::path::Path;

const YOUNG: f64 = 1e6;
const STRENGTH: f64 = 1e5;
/// J/m^2
const FRACTURE_ENERGY: f64 = 400.0;
const THICKNESS: f64 = 1e-3;
/// m
const LENGTH: f64 = 0.04;
/// m: more than `2 G / f`, by which the band is longer when its triangles fail.
const ELONGATION: f64 = 0.25 * LENGTH;
/// m
const WIDTH: f64 = 0.01;

/// A strip along x of square cells of a pattern, `rows` across, with a column of cells in its middle that is a little weaker, held at both ends.
fn strip(pattern: Pattern, rows: u32) -> Session {
    let cell = WIDTH / f64::from(rows);
    let surface = sheet(pattern, [4 * rows, rows], [LENGTH, WIDTH]);
    let mut obj = String::new();
    surface.points.iter().for_each(|p| _ = writeln!(obj, "v {:?} {:?} {:?}", p[0], p[1], p[2]));
    let one_based = surface.triangles.iter().map(|t| t.map(|v| v + 1));
    one_based.for_each(|t| _ = writeln!(obj, "f {} {} {}", t[0], t[1], t[2]));
    let bench = Bench::new();
    bench.write("strip.obj", obj);
    let (left, right, end) = (0.5 * LENGTH + 0.1 * cell, 0.5 * LENGTH + 0.9 * cell, LENGTH - 1e-6);
    let scene = format!(
        r#"
        format = 1
        # So little that it is none, but a body without a load is not simulated.
        gravity = [0, 0, -1e-9]
        [time]
        integrator = "quasi-static"
        [[body]]
        mesh = "strip.obj"
        sheet = {{ warp = [1, 0, 0] }}
        fixed = [{{ box = [[-1, -1, -1], [1e-6, 1, 1]] }}, {{ box = [[{end}, -1, -1], [1, 1, 1]] }}]
        [[body.field]]
        param = "strength"
        box = [[{left}, -1, -1], [{right}, 1, 1]]
        factor = 0.97
        [body.material]
        plugin = "tearing"
        params = {{ young = {YOUNG}, poisson = 0, thickness = {THICKNESS}, strength = {STRENGTH}, fracture-energy = {FRACTURE_ENERGY}, damping-time = 0 }}
        "#
    );
    open_file(&bench.write("scene.toml", scene), 1, None)
}

#[test]
fn a_strip_takes_its_fracture_energy_whatever_the_mesh() {
    let expected = FRACTURE_ENERGY * THICKNESS * WIDTH;
    for rows in [1, 2, 4] {
        let errors = [400, 1600].map(|steps| {
            let mut session = strip(Pattern::Regular, rows);
            let (work, largest) = pull_apart(&mut session, ELONGATION, steps);
            let system = &mut session.bodies[0].system;
            let gone = system.failed_count() as u32;
            println!("{rows} cells across, {steps} steps: {work:.4e} J of {expected:.4e}, {largest:.3} N, {gone} gone");
            assert_eq!(gone, 2 * rows, "the band has torn, and nothing else");
            assert!(system.energy(StepTime::default()).expect("finite") < 1e-6 * expected, "both halves are slack");
            work / expected - 1.0
        });
        // Damage follows a step after its strain: an error of first order in the step.
        assert!(errors[1].abs() < 0.02, "{rows} cells across: {errors:?}");
        assert!(errors[1].abs() < 0.5 * errors[0].abs() + 2e-3, "{rows} cells across: {errors:?}");
    }
}

/// Triangles of other shapes: the width of the band is that of a square of a triangle's area, which in an irregular mesh holds on average.
#[test]
fn a_strip_of_another_pattern_takes_its_fracture_energy_too() {
    let expected = FRACTURE_ENERGY * THICKNESS * WIDTH;
    for pattern in [Pattern::Alternating, Pattern::Irregular] {
        let mut session = strip(pattern, 4);
        let error = pull_apart(&mut session, ELONGATION, 1600).0 / expected - 1.0;
        let gone = session.bodies[0].system.failed_count();
        assert!(gone >= 4 && error.abs() < 0.05, "{pattern:?}: {error} of {expected} J, {gone} gone");
    }
}

/// The shipped scene of a membrane that tears, after so many steps.
fn torn(steps: usize, integrator: &str) -> Session {
    let scene = std::fs::read_to_string(root().join("scenes/tear.toml")).expect("a shipped scene");
    let scene = scene.replace("integrator = \"backward-euler\"", &format!("integrator = \"{integrator}\""));
    let mut session = open_file(&Bench::new().write("tear.toml", scene), 1, None);
    (0..steps).for_each(|_| session.step());
    assert!(session.bodies[0].frozen.is_none(), "{:?}", session.bodies[0].frozen);
    session
}

/// Numbers of the triangles that viewers do not draw.
fn undrawn(session: &Session) -> Vec<u32> {
    let body = &session.bodies[0];
    (0..body.model.surface.triangles.len() as u32).filter(|t| body.look(*t).is_none()).collect()
}

#[test]
fn what_is_gone_is_neither_drawn_nor_written_and_comes_back_with_its_history() {
    for integrator in ["backward-euler", "damped-midpoint"] {
        let mut session = torn(70, integrator);
        assert!(session.bodies[0].system.failed_count() == 0 && undrawn(&session).is_empty(), "{integrator}: too soon");
        let before = session.snapshot();
        let states: Vec<Vec<Vec3>> = [0, 1]
            .into_iter()
            .map(|_| {
                // Twice from the same snapshot: a solver that goes on starts from the solutions before.
                session.restore(&before).expect("goes back");
                (0..50).for_each(|_| session.step());
                let (body, gone) = (&session.bodies[0], undrawn(&session));
                assert!(gone.len() > 5 && gone.len() == body.system.failed_count(), "{integrator}: {}", gone.len());
                let mut written = Vec::new();
                pliant_record::write_model_to(body, "cap", &mut written).expect("written");
                let document = ObjDocument::parse(written, Path::new("torn.obj")).expect("an OBJ file");
                let faces = Surface::from_document(&document).triangles.len();
                assert_eq!(faces + gone.len(), body.model.surface.triangles.len(), "{integrator}");
                let x = body.system.nodes.x.clone();
                session.restore(&before).expect("goes back");
                let count = session.bodies[0].system.failed_count();
                assert!(count == 0 && undrawn(&session).is_empty(), "{integrator}: {count} are still gone");
                x
            })
            .collect();
        assert!(states[0] == states[1], "{integrator}: the same tear again, to the bit");
        assert!(session.events.count(EventKind::ElementsFailed) > 10, "{integrator}: and events say so");
    }
}

#[test]
fn a_torn_membrane_has_the_same_bytes_on_any_number_of_threads() {
    let tear = |threads: &str| {
        let bench = Bench::new();
        let scene = root().join("scenes/tear.toml").display().to_string();
        // The scene's check, that it is torn through, is met at its end only.
        let set = [
            "--set",
            "time.duration=0.15",
            "--set",
            "probe=[]",
            "--oversubscribe",
            "--threads",
            threads,
            "--out",
            "out",
        ];
        bench.pliant(&[&["run", &scene, "-q"], &set[..]].concat()).expect(0);
        bench.read("out/final.obj")
    };
    let one = tear("1");
    assert!(one == tear("3") && one.iter().filter(|c| **c == b'\n').count() > 4000);
    let faces = one.split(|c| *c == b'\n').filter(|line| line.starts_with(b"f ")).count();
    assert!(faces + 10 < 2 * 40 * 40, "{faces} faces are left: nothing has torn");
}

/// Links of the right half of a square of springs that break at once, with a force left, are broken.
#[test]
fn calls_go_around_what_is_gone_and_masses_stay() {
    let scene = r#"
        format = 1
        gravity = [0, 0, -1e-9]
        [time]
        integrator = "backward-euler"
        [[body]]
        shape = { kind = "sheet", cells = 8, rows = 8, size = [0.08, 0.08, 0] }
        sheet = { warp = [1, 0, 0] }
        material = { plugin = "faulty-plugins#sound-thread" }
    "#;
    let mut session = open_file(&Bench::new().write("net.toml", scene), 1, None);
    let (system, pool, time) = (&mut session.bodies[0].system, Pool::new(1), StepTime { start: 0.0, dt: 1e-3 });
    let n = system.nodes.len();
    let stretched = |x: Vec3| Vec3::new(if x.x > 0.04 { 0.04 + 1.6 * (x.x - 0.04) } else { x.x }, x.y, x.z);
    let (rest, mass) = (system.nodes.rest.clone(), system.nodes.mass.clone());
    system.nodes.x = rest.iter().map(|x| stretched(*x)).collect();
    let mut force = vec![Vec3::zeros(); n];
    system.forces(&pool, None, time, &mut force).expect("sound");
    let before = system.energy(time).expect("sound");
    assert!(force.iter().any(|f| f.norm() > 1e-2) && system.failed_count() == 0);
    system.advance(&pool, time).expect("sound");
    let gone = system.failed_count();
    let set = system.sets.iter().find(|set| !set.failed().is_empty()).expect("springs");
    let has_failed = |e: usize| set.failed()[e] != 0;
    let ends = |e: usize| [0, 1].map(|i| set.nodes()[2 * e + i] as usize);
    assert!(gone > 20 && gone < set.count(), "{gone} of {}", set.count());
    assert!((0..set.count()).all(
        |e| has_failed(e) == ends(e).iter().any(|i| rest[*i].x > 0.041 && rest[ends(e)[0]].x != rest[ends(e)[1]].x)
    ));
    let connected: Vec<bool> =
        (0..n).map(|i| (0..set.count()).any(|e| !has_failed(e) && ends(e).contains(&i))).collect();
    system.forces(&pool, None, time, &mut force).expect("sound");
    assert!(system.energy(time).expect("sound") < 0.05 * before, "what has failed has no energy");
    assert!((0..n).all(|i| connected[i] || force[i] == Vec3::zeros()), "nor forces");
    assert!(system.nodes.mass == mass);
    let undamaged = vec![0.0; system.sets.iter().map(|set| set.history().len()).max().expect("a history")];
    system.sets.iter_mut().filter(|set| !set.failed().is_empty()).for_each(|set| set.set_history(&undamaged));
    assert!((system.energy(time).expect("sound") / before - 1.0).abs() < 1e-12, "back with its history");
    assert_eq!(system.failed_count(), 0);
}

/// Largest forces on a tool and on an obstacle (N) that go through two places of a sheet, which may have been torn away around them before, on a
/// session of its own or on one that was torn and then taken back.
fn crossed(contact: &str, radius: f64, torn: bool, undone: bool) -> [f64; 2] {
    let scene = format!(
        r#"
        format = 1
        gravity = [0, 0, -1e-9]
        [time]
        integrator = "backward-euler"
        [[body]]
        shape = {{ kind = "sheet", cells = 20, rows = 20, size = [0.1, 0.1, 0] }}
        sheet = {{ warp = [1, 0, 0] }}
        fixed = [{{ box = [[-1, -1, -1], [1e-6, 1, 1]] }}, {{ box = [[0.099999, -1, -1], [1, 1, 1]] }}]
        material = {{ plugin = "tearing", params = {{ young = 1e6, strength = 1e5, fracture-energy = 5000, thickness = 2e-4, damping-time = 5e-3 }} }}
        [[device]]
        name = "hand"
        plugin = "scripted"
        params = {{ path = [[0, 0.03, 0.05, 0.015], [0.03, 0.03, 0.05, 0.015], [0.06, 0.03, 0.05, -0.005]] }}
        [[tool]]
        name = "tip"
        device = "hand"
        radius = {radius}
        sheets = "{contact}"
        [[edit]]
        kind = "touch"
        tool = "tip"
        [[obstacle]]
        name = "ball"
        shape = {{ kind = "sphere", radius = {radius} }}
        position = [0.07, 0.05, 0.015]
        path = [[0, 0, 0, 0], [0.03, 0, 0, 0], [0.06, 0, 0, -0.02]]
        "#
    );
    let mut session = open_file(&Bench::new().write("scene.toml", scene), 1, None);
    session.step();
    let whole = session.snapshot();
    if torn {
        let system = &mut session.bodies[0].system;
        let rest = &system.nodes.rest;
        let set = system.sets.iter_mut().find(|set| !set.failed().is_empty()).expect("triangles");
        let mut history = set.history().to_vec();
        for (corners, strain) in set.nodes().chunks(3).zip(&mut history) {
            let middle = corners.iter().map(|node| rest[*node as usize]).sum::<Vec3>() / 3.0;
            if [0.03, 0.07].iter().any(|x| (middle.x - x).abs() < 0.0175 && (middle.y - 0.05).abs() < 0.02) {
                *strain = 1e3;
            }
        }
        set.set_history(&history);
        // The contacts know the sheet as it was.
        (0..3).for_each(|_| session.step());
        assert!(session.bodies[0].failed_triangles.loose_nodes().len() > 20);
    }
    if undone {
        session.restore(&whole).expect("goes back");
    }
    let mut most = [0.0_f64; 2];
    for _ in 0..70 {
        session.step();
        assert!(session.bodies[0].frozen.is_none(), "{:?}", session.bodies[0].frozen);
        most = [most[0].max(session.frame().tools[0].force.norm()), most[1].max(session.obstacles()[0].force.norm())];
    }
    most
}

#[test]
fn nothing_meets_what_has_failed_until_it_is_undone() {
    for contact in ["vertices", "triangles", "penalty"] {
        for radius in [0.004, 0.008] {
            let [tip, ball] = crossed(contact, radius, false, false);
            assert!(tip > 1e-3 && ball > 1e-3, "{contact}, {radius} m: a whole sheet is met: {tip} and {ball} N");
            assert_eq!(crossed(contact, radius, true, false), [0.0; 2], "{contact}, {radius} m: nothing is left there");
            let [again, ball_again] = crossed(contact, radius, true, true);
            let error = (again / tip - 1.0).abs().max((ball_again / ball - 1.0).abs());
            assert!(
                error < 0.05,
                "{contact}, {radius} m: {again} and {ball_again} N after an undo, {tip} and {ball} N before"
            );
        }
    }
}
