//! Cuts of whole scenes: what comes apart, what a blade feels, and how it is taken back.

use pliant_engine::session::{EventKind, HistoryCounts, Session};
use pliant_mesh::geometry::Vec3;
use pliant_record::write_model;
use pliant_tests::{Bench, open, open_file, root};
use std::collections::BTreeSet;

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
}

/// A block of 40 mm standing on its base, under a blade along y that comes down from `from` to `to` (m, at x = `at`) in
/// half a second and goes back up.
fn block(at: f64, [from, to]: [f64; 2], blade: &str, edits: &str) -> Session {
    let scene = format!(
        r#"
        format = 1
        [time]
        duration = "2 s"
        [[body]]
        shape = {{ kind = "box", cells = 12, size = ["40 mm", "40 mm", "40 mm"] }}
        material = {{ plugin = "mass-spring", params = {{ young = "500 kPa", density = 1000, damping-time = "2 ms" }} }}
        grid = {{ level = 4, region = "whole" }}
        [[body.fixed]]
        box = [["-1 m", "-1 m", "-1 m"], ["1 m", "1 m", "-19 mm"]]
        [[device]]
        name = "hand"
        params = {{ path = [[0, {at}, -0.05, {from}], [0.5, {at}, -0.05, {to}], [1.0, {at}, -0.05, {from}]] }}
        [[tool]]
        name = "knife"
        device = "hand"
        radius = "1 mm"
        stiffness = "1000 N/m"
        blade = {{ length = "100 mm", direction = [0, 1, 0], {blade} }}
        {edits}
        "#
    );
    open(&scene, 1)
}

const CUT: &str = "[[edit]]\nkind = \"cut\"\ntool = \"knife\"\n";

#[test]
fn a_blade_feels_the_energy_of_what_it_cuts() {
    let mut session = block(0.003, [0.03, -0.01], "toughness = 30", CUT);
    run(&mut session, 0.1);
    assert_eq!(session.frame().tools[0].force, Vec3::zeros(), "in the air");
    let mut felt = Vec::new();
    for _ in 0..320 {
        session.step();
        felt.push(session.frame().tools[0].force[2]);
    }
    // Griffith: 30 J/m^2 over a width of 40 mm is 1.2 N.
    felt.drain(..120);
    let mean = felt.iter().sum::<f64>() / felt.len() as f64;
    assert!((mean / 1.2 - 1.0).abs() < 0.05, "{mean} N");
    run(&mut session, 0.08);
    let area = session.cuts().area;
    assert!((area - 0.04 * 0.03).abs() < 0.04 * 0.003, "{area} m^2");
    run(&mut session, 0.3);
    assert_eq!(session.cuts().area, area, "drawn back it cuts nothing");
    // The faces of the cut hold it sideways, with what they have moved since the blade passed.
    let felt = session.frame().tools[0].force;
    assert!(felt[2].abs() < 1e-3 * 1.2 && felt.norm() < 0.02 * 1.2, "and nothing resists it: {felt:?} N");
    assert_eq!(
        session.bodies[0].discretization.lattice().unwrap().parts().iter().max(),
        Some(&0),
        "the block hangs together"
    );
}

#[test]
fn what_is_cut_through_falls_by_itself_and_the_surface_goes_with_it() {
    let mut session = open_file(&root().join("scenes/cut.toml"), 1, None);
    run(&mut session, 0.24);
    session.update_surface();
    let body = &session.bodies[0];
    let parts = body.discretization.lattice().unwrap().parts();
    assert_eq!(parts.iter().max(), Some(&1), "two parts");
    let shells = body.model.surface.shells();
    assert_eq!(shells.iter().max(), Some(&1));
    let mut pairs = BTreeSet::new();
    for (triangle, shell) in body.model.surface.triangles.iter().zip(&shells) {
        for vertex in triangle {
            let cell = body.skin.cell[*vertex as usize];
            pairs.insert((
                *shell,
                parts[body.discretization.lattice().unwrap().region().cell_corners[cell as usize][0] as usize],
            ));
        }
    }
    assert_eq!(pairs.len(), 2, "each shell follows one part: {pairs:?}");
    let centre = |session: &Session| {
        let nodes = &session.bodies[0].system.nodes;
        let of_tip = (0..nodes.len()).filter(|n| parts[*n] == 1);
        let (m, mv) =
            of_tip.fold((0.0, Vec3::zeros()), |(m, mv), n| (m + nodes.mass[n], mv + nodes.mass[n] * nodes.v[n]));
        mv / m
    };
    let before = centre(&session);
    run(&mut session, 0.05);
    let fell = centre(&session) - before;
    assert!((fell[1] + 9.81 * 0.05).abs() < 1e-3 * 9.81 * 0.05, "{fell:?}");
    assert_eq!(session.events.count(EventKind::CutRefused), 0);
}

fn written(session: &mut Session) -> Vec<u8> {
    session.update_surface();
    let bench = Bench::new();
    write_model(&session.bodies[0], "cut", &bench.path("final.obj")).unwrap();
    bench.read("final.obj")
}

#[test]
fn undo_gives_back_the_same_bytes_and_redo_the_cut() {
    let edit = "[[edit]]\nkind = \"cut\"\ntool = \"knife\"\nstart = \"0.05 s\"\nend = \"0.45 s\"\n";
    let mut session = block(0.003, [0.03, -0.03], "toughness = 5", edit);
    session.keep_history();
    run(&mut session, 0.04);
    let (document, x) = (session.bodies[0].model.document.bytes().to_vec(), session.bodies[0].system.nodes.x.clone());
    assert!(!session.undo(), "nothing yet");
    run(&mut session, 0.46);
    assert_eq!(session.history(), HistoryCounts { done: 1, undone: 0 });
    let cut = written(&mut session);
    let nodes = session.bodies[0].system.nodes.x.clone();
    assert!(cut.len() > document.len() && nodes.len() > x.len());
    for _ in 0..2 {
        assert!(session.undo());
        assert_eq!(session.history(), HistoryCounts { done: 0, undone: 1 });
        assert_eq!(session.bodies[0].system.nodes.x, x, "every node is where it was");
        assert!(written(&mut session) == document, "the file as it was handed in");
        assert!(session.redo());
        assert_eq!(session.bodies[0].system.nodes.x, nodes);
        assert!(written(&mut session) == cut);
    }
    assert!(session.undo());
    run(&mut session, 0.1);
    assert_eq!(session.events.count(EventKind::Quarantine), 0, "it goes on from there");
}

#[test]
fn several_cuts_are_taken_back_one_by_one() {
    let edit = |start: &str, end: &str| {
        format!("[[edit]]\nkind = \"cut\"\ntool = \"knife\"\nstart = \"{start}\"\nend = \"{end}\"\n")
    };
    let back = |kind: &str, start: &str| format!("[[edit]]\nkind = \"{kind}\"\nstart = \"{start}\"\n");
    let edits = [
        edit("0 s", "0.2 s"),
        edit("0.25 s", "0.45 s"),
        back("undo", "0.6 s"),
        back("redo", "0.7 s"),
        back("undo", "0.8 s"),
        back("undo", "0.9 s"),
    ]
    .concat();
    let mut session = block(0.003, [0.03, -0.03], "toughness = 5", &edits);
    let mut depths = Vec::new();
    for until in [0.22, 0.5, 0.65, 0.75, 0.85, 0.95] {
        let more = until - session.time();
        run(&mut session, more);
        depths.push(session.bodies[0].cut.as_ref().unwrap().depth());
    }
    let [first, both] = [depths[0], depths[1]];
    assert!(first > 0 && both > first, "{depths:?}");
    assert_eq!(depths[2..], [first, both, first, 0]);
    assert_eq!(written(&mut session), session.bodies[0].model.document.bytes());
}

#[test]
fn a_cut_does_not_depend_on_the_number_of_threads() {
    let state = |threads| {
        let mut session = open_file(&root().join("scenes/cut.toml"), threads, None);
        run(&mut session, 0.25);
        (written(&mut session), session.frame().tools[0].force)
    };
    assert!(state(1) == state(2));
}
