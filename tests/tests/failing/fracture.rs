//! Solids that fracture (`quasi-brittle`): a bar that breaks takes the fracture energy of its cross-section, whatever its tetrahedra; and wide ones are told.

#![allow(clippy::print_stdout, reason = "the table of errors")]

use pliant_engine::session::{Session, WarningCode};
use pliant_mesh::testing::tetrahedra::{TetBox, TetFormat};
use pliant_solver::StepTime;
use pliant_tests::pulling::pull_apart;
use pliant_tests::{Bench, open_file, root};

/// m
const LENGTH: f64 = 0.04;
/// m, of a square cross-section
const WIDTH: f64 = 0.01;

/// A material of a bar.
#[derive(Clone, Copy)]
struct Brittle {
    /// Pa
    young: f64,
    poisson: f64,
    /// Pa
    strength: f64,
    /// J/m^2
    fracture_energy: f64,
}

/// As soft as a firm gel.
const GEL: Brittle = Brittle { young: 1e6, poisson: 0.0, strength: 2e4, fracture_energy: 10.0 };
/// As stiff as plaster.
const PLASTER: Brittle = Brittle { young: 3e9, poisson: 0.2, strength: 3e6, fracture_energy: 100.0 };

/// A bar along x with `rows` cubes across, each of six tetrahedra, with a layer of cubes in its middle that is a little weaker, held at both ends.
fn bar(of: Brittle, rows: u32) -> Session {
    let cell = WIDTH / f64::from(rows);
    let mesh = TetBox::new([4 * rows, rows, rows], [LENGTH, WIDTH, WIDTH], 0.0, 1);
    let (left, right, end) = (0.5 * LENGTH, 0.5 * LENGTH + cell, LENGTH - 1e-6);
    let Brittle { young, poisson, strength, fracture_energy } = of;
    let scene = format!(
        r#"
        format = 1
        # So little that it is none, but a body without a load is not simulated.
        gravity = [0, 0, -1e-9]
        [time]
        integrator = "quasi-static"
        [[body]]
        mesh = "bar.vtk"
        fixed = [{{ box = [[-1, -1, -1], [1e-6, 1, 1]] }}, {{ box = [[{end}, -1, -1], [1, 1, 1]] }}]
        [[body.field]]
        param = "strength"
        box = [[{left}, -1, -1], [{right}, 1, 1]]
        factor = 0.97
        [body.material]
        plugin = "quasi-brittle"
        params = {{ young = {young}, poisson = {poisson}, strength = {strength}, fracture-energy = {fracture_energy}, damping-time = 0 }}
        "#
    );
    let bench = Bench::new();
    bench.write("bar.vtk", mesh.bytes(TetFormat::Vtk));
    open_file(&bench.write("scene.toml", scene), 1, None)
}

#[test]
fn a_bar_takes_its_fracture_energy_whatever_its_tetrahedra() {
    for of in [GEL, PLASTER] {
        let expected = of.fracture_energy * WIDTH * WIDTH;
        // A layer that has failed is longer by 2 G / f; the rest is slack then.
        let elongation = 2.2 * of.fracture_energy / of.strength;
        for (rows, all_steps) in [(1, &[800, 3200][..]), (2, &[800, 3200]), (4, &[800])] {
            let mut errors = Vec::new();
            for &steps in all_steps {
                let mut session = bar(of, rows);
                let (work, largest) = pull_apart(&mut session, elongation, steps);
                let system = &mut session.bodies[0].system;
                let (gone, peak) = (system.failed_count() as u32, largest / (0.97 * of.strength * WIDTH * WIDTH));
                let left = system.energy(StepTime::default()).expect("finite");
                println!("{rows} across, {steps} steps: {work:.4e} J of {expected:.4e}, {peak:.3} of the strength");
                assert_eq!(gone, 6 * rows * rows, "the layer has failed, and nothing else");
                assert!(left < 1e-6 * expected, "both halves are slack: {left} J");
                assert!((0.98..1.03).contains(&peak), "{rows} across: {peak} of the strength");
                errors.push(work / expected - 1.0);
            }
            // Damage follows a step after its strain: an error of first order in the step, which takes more and never gives.
            assert!(errors.iter().all(|error| (-1e-3..0.04).contains(error)), "{rows} across: {errors:?}");
            assert!(
                errors.windows(2).all(|pair| pair[1] < 0.7 * pair[0] && pair[1] < 0.02),
                "{rows} across: {errors:?}"
            );
        }
    }
}

/// Elements wider than `2 G Y / f^2` take more than their fracture energy, and a warning says so; narrower ones have none.
#[test]
fn elements_too_wide_for_their_fracture_energy_are_told() {
    let told = |session: &Session| -> Vec<String> {
        let doubtful = session.warnings().into_iter().filter(|w| w.code == WarningCode::DoubtfulElements);
        doubtful.map(|w| w.message).collect()
    };
    for rows in [1, 2, 4] {
        // Along the longest edge of a cube of six.
        let width = 3.0_f64.sqrt() * WIDTH / f64::from(rows);
        let fits = width * GEL.strength * GEL.strength / (2.0 * GEL.young);
        for (factor, is_told) in [(1.3, false), (0.7, true)] {
            let session = bar(Brittle { fracture_energy: factor * fits, ..GEL }, rows);
            let told = told(&session);
            assert_eq!(told.len(), usize::from(is_told), "{rows} across, {factor}: {told:?}");
            assert!(told.iter().all(|text| text.contains("`quasi-brittle`")), "{told:?}");
        }
    }
    // A sheet that tears: cells of 5 mm, of which each triangle is as wide.
    for (energy, is_told) in [(35.0, false), (15.0, true)] {
        let scene = format!(
            r#"
            format = 1
            gravity = [0, 0, -1e-9]
            [[body]]
            shape = {{ kind = "sheet", cells = 8, rows = 8, size = [0.04, 0.04, 0] }}
            sheet = {{ warp = [1, 0, 0] }}
            material = {{ plugin = "tearing", params = {{ young = 1e6, strength = 1e5, fracture-energy = {energy} }} }}
            "#
        );
        let session = open_file(&Bench::new().write("scene.toml", scene), 1, None);
        let told = told(&session);
        assert_eq!(told.len(), usize::from(is_told), "{energy} J/m^2: {told:?}");
        assert!(told.iter().all(|text| text.contains("128 of 128") && text.contains("`tearing`")), "{told:?}");
    }
}

/// The shipped scene of a bar that snaps: on any number of threads the same bytes, its recording verifies, and both parts are files.
#[test]
fn a_bar_that_snaps_has_the_same_bytes_on_any_number_of_threads() {
    let bench = Bench::new();
    let scene = root().join("scenes/snap.toml").display().to_string();
    let run = |threads: &str, more: &[&str]| {
        let set = ["--set", "output.parts=\"files\"", "--oversubscribe", "--threads", threads, "--out", "out"];
        bench.pliant(&[&["run", &scene, "-q"], &set[..], more].concat()).expect(0);
        ["final.obj", "final.vtk"].map(|name| bench.read(&format!("out/{name}")))
    };
    let one = run("1", &["--record", "snap.rec"]);
    let names = bench.names("out");
    assert_eq!(names.iter().filter(|name| name.contains("-part-")).count(), 2, "{names:?}");
    let text = String::from_utf8(one[0].clone()).expect("text");
    let (before, new) = text.split_once("usemtl fracture\n").expect("faces that have come to light");
    let faces = |text: &str| text.lines().filter(|line| line.starts_with("f ")).count();
    assert!(faces(new) > 30 && (500..560).contains(&faces(before)), "{} and {}", faces(before), faces(new));
    let text = String::from_utf8_lossy(&one[1]);
    let (_, failed) = text.split_once("SCALARS failed long 1\nLOOKUP_TABLE default\n").expect("which have failed");
    assert!(failed.lines().filter(|line| *line == "1").count() > 20 && failed.lines().count() == 1536);
    assert!(one == run("3", &[]), "threads");
    bench.pliant(&["replay", "snap.rec", "--verify", "--out", "again"]).expect(0);
}
