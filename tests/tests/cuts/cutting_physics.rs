//! What a cut must not change: mass, momentum, energy, what is fixed, and what else goes on in a scene.

use pliant_engine::body::Body;
use pliant_engine::session::{EventKind, HistoryCounts, Session};
use pliant_record::write_model;
use pliant_solver::{Constraint, Vec3};
use pliant_tests::{Bench, open};
use std::collections::BTreeSet;

const DOWN: &str = "[[0.0, 0.003, -0.05, 0.03], [0.4, 0.003, -0.05, -0.03]]";

/// A box of 40 mm under a blade along y with `blade`, which follows `path`.
fn scene(top: &str, body: &str, path: &str, blade: &str, rest: &str) -> Session {
    open(
        &format!(
            r#"
            format = 1
            {top}
            [time]
            duration = "2 s"
            [[body]]
            name = "block"
            shape = {{ kind = "box", cells = 12, size = ["40 mm", "40 mm", "40 mm"] }}
            material = {{ plugin = "mass-spring", params = {{ young = "200 kPa", density = 1000, damping-time = "2 ms" }} }}
            grid = {{ level = 4, region = "whole" }}
            {body}
            [[device]]
            name = "hand"
            params = {{ path = {path} }}
            [[tool]]
            name = "knife"
            device = "hand"
            radius = "1 mm"
            stiffness = "1000 N/m"
            blade = {{ length = "100 mm", direction = [0, 1, 0], {blade} }}
            [[edit]]
            kind = "cut"
            tool = "knife"
            {rest}
            "#
        ),
        1,
    )
}

fn run(session: &mut Session, seconds: f64) {
    for _ in 0..(seconds / session.dt()).round() as usize {
        session.step();
    }
}

fn momentum(body: &Body) -> (f64, Vec3) {
    let nodes = &body.system.nodes;
    (0..nodes.len()).fold((0.0, Vec3::zeros()), |(m, p), n| (m + nodes.mass[n], p + nodes.mass[n] * nodes.v[n]))
}

/// Each part of the surface with the parts of the lattice that carry it.
fn pairs(body: &Body) -> BTreeSet<(u32, u32)> {
    let (parts, shells) = (body.discretization.lattice().unwrap().parts(), body.model.surface.shells());
    let part = |v: u32| {
        parts[body.discretization.lattice().unwrap().region().cell_corners[body.skin.cell[v as usize] as usize][0]
            as usize]
    };
    let surface = &body.model.surface;
    surface.triangles.iter().zip(&shells).flat_map(|(t, shell)| t.map(|v| (*shell, part(v)))).collect()
}

#[test]
fn a_falling_block_keeps_its_mass_and_its_momentum() {
    let under = "[[0.0, 0.003, -0.05, -0.025], [2.0, 0.003, -0.05, -0.025]]";
    let mut session = scene("gravity = [0, 0, -9.81]", "", under, "toughness = 0", "");
    session.step();
    let (mass, _) = momentum(&session.bodies[0]);
    run(&mut session, 0.06);
    let cut = session.cuts().advances;
    assert!(cut > 2, "it falls onto the blade: {cut}");
    let (now, p) = momentum(&session.bodies[0]);
    assert!((now / mass - 1.0).abs() < 1e-12, "{now} kg, was {mass}");
    let expected = mass * 9.81 * session.time();
    assert!((p[2] + expected).abs() < 1e-6 * expected && p[0].abs().max(p[1].abs()) < 1e-6 * expected, "{p:?}");
}

#[test]
fn a_cut_gives_no_energy() {
    // Stretched by 5 % between its base and its top, and cut lengthways: nothing is let go but what was stored.
    let held = "[[body.fixed]]\nbox = [[\"-1 m\", \"-1 m\", \"-1 m\"], [\"1 m\", \"1 m\", \"-19 mm\"]]\n[[body.fixed]]\n\
        box = [[\"-1 m\", \"-1 m\", \"19 mm\"], [\"1 m\", \"1 m\", \"1 m\"]]\n\
        path = [[0, 0, 0, 0], [0.1, 0, 0, 0.002], [9, 0, 0, 0.002]]\n";
    let path = "[[0.0, -0.03, -0.05, 0.001], [0.5, -0.03, -0.05, 0.001], [0.9, 0.03, -0.05, 0.001]]";
    let mut session = scene("", held, path, "toughness = 0", "");
    run(&mut session, 0.5);
    let energy = |session: &Session| session.frame().kinetic_energy + session.frame().elastic_energy;
    let (before, mut last) = (energy(&session), energy(&session));
    assert!(before > 1e-4 && session.cuts().advances == 0, "{before} J");
    for _ in 0..400 {
        session.step();
        let now = energy(&session);
        assert!(now <= last + 1e-9 * before, "{now} J after {last} J at {} s", session.time());
        last = now;
    }
    assert!(session.cuts().advances > 5 && last < 0.9 * before, "{last} J of {before} J");
    assert_eq!(session.bodies[0].discretization.lattice().unwrap().parts().iter().max(), Some(&1));
}

#[test]
fn a_cut_through_what_is_fixed_leaves_both_sides_fixed() {
    let held = "[[body.fixed]]\nbox = [[\"-1 m\", \"-1 m\", \"-1 m\"], [\"1 m\", \"1 m\", \"-14 mm\"]]\n";
    let mut session = scene("gravity = [0, 0, -9.81]", held, DOWN, "toughness = 1", "");
    run(&mut session, 0.5);
    let body = &session.bodies[0];
    let (nodes, region) = (&body.system.nodes, body.discretization.lattice().unwrap().region());
    let base: Vec<usize> = (0..nodes.len()).filter(|n| region.node_rest[*n][2] < -0.014).collect();
    assert!(base.iter().any(|n| region.node_copy[*n] > 0), "there are copies");
    for n in base {
        assert!(nodes.constraint[n] == Constraint::Fixed && nodes.x[n] == nodes.rest[n], "node {n}");
    }
    assert_eq!(body.discretization.lattice().unwrap().parts().iter().max(), Some(&1));
}

#[test]
fn every_part_of_the_surface_goes_with_one_part_of_the_lattice() {
    // Also where the blade passes closer to the face of a cell than a voxel is thick: cells are 5 mm, voxels 1.25 mm.
    for at in [0.0, 2e-4, 6e-4, 1.2e-3, 2.5e-3, 4.4e-3, 4.9e-3, 5e-3] {
        for tilt in [0.0, 0.004] {
            // A voxel a step.
            let path = format!("[[0.0, {at}, -0.05, 0.03], [0.05, {}, -0.05, -0.03]]", at + tilt);
            let mut session = scene("", "", &path, "toughness = 0", "");
            run(&mut session, 0.055);
            let pairs = pairs(&session.bodies[0]);
            assert_eq!(pairs.len(), 2, "{at} {tilt}: {pairs:?}");
        }
    }
}

#[test]
fn a_cut_beside_a_finger_that_touches() {
    let finger = "[[device]]\nname = \"other\"\nparams = { path = [[0.0, -0.01, 0.0, 0.03], [0.1, -0.01, 0.0, 0.0225], \
        [2.0, -0.01, 0.0, 0.0225]] }\n[[tool]]\nname = \"finger\"\ndevice = \"other\"\nradius = \"6 mm\"\n\
        stiffness = \"500 N/m\"\n[[edit]]\nkind = \"touch\"\ntool = \"finger\"\n";
    let held = "[[body.fixed]]\nbox = [[\"-1 m\", \"-1 m\", \"-1 m\"], [\"1 m\", \"1 m\", \"-19 mm\"]]\n";
    let path = "[[0.0, 0.003, -0.05, 0.03], [0.2, 0.003, -0.05, 0.03], [0.5, 0.003, -0.05, 0.0]]";
    let mut session = scene("", held, path, "toughness = 2", finger);
    let force = |session: &Session| session.frame().tools[1].force.norm();
    run(&mut session, 0.2);
    let before = force(&session);
    assert!(before > 0.05 && session.cuts().advances == 0, "{before} N");
    for _ in 0..400 {
        session.step();
        assert!(force(&session) > 0.3 * before && force(&session) < 1.5 * before, "{} N", force(&session));
    }
    assert!(session.cuts().advances > 5);
    assert_eq!(session.events.count(EventKind::Quarantine), 0);
}

#[test]
fn one_blade_cuts_several_bodies() {
    let second = "[[body]]\nname = \"second\"\nposition = [0, \"50 mm\", 0]\n\
        shape = { kind = \"box\", cells = 8, size = [\"20 mm\", \"20 mm\", \"20 mm\"] }\n\
        material = { plugin = \"mass-spring\", params = { young = \"200 kPa\", damping-time = \"2 ms\" } }\n\
        grid = { level = 4, region = \"whole\" }\n";
    let path = "[[0.0, 0.003, -0.03, 0.03], [0.4, 0.003, -0.03, -0.03]]";
    let mut session = scene("", second, path, "toughness = 0", "");
    run(&mut session, 0.45);
    for body in &session.bodies {
        assert_eq!(body.discretization.lattice().unwrap().parts().iter().max(), Some(&1), "{}", body.name);
    }
    let expected = 0.04 * 0.04 + 0.02 * 0.02;
    assert!((session.cuts().area / expected - 1.0).abs() < 1e-3, "{} m^2", session.cuts().area);
}

#[test]
fn a_kept_pull_is_taken_back_with_the_cut_after_it() {
    let pull = "start = \"0.6 s\"\nend = \"1.1 s\"\n[[device]]\nname = \"other\"\nparams = { path = [[0.0, -0.012, 0.0, 0.02], \
        [0.05, -0.012, 0.0, 0.02], [0.3, -0.012, 0.0, 0.026]] }\n[[tool]]\nname = \"finger\"\ndevice = \"other\"\n\
        radius = \"3 mm\"\nstiffness = \"500 N/m\"\n[[edit]]\nkind = \"pull\"\ntool = \"finger\"\nrelease = \"keep\"\n\
        end = \"0.4 s\"\n[[edit]]\nkind = \"undo\"\nstart = \"1.2 s\"\n[[edit]]\nkind = \"undo\"\nstart = \"1.3 s\"\n";
    let held = "[[body.fixed]]\nbox = [[\"-1 m\", \"-1 m\", \"-1 m\"], [\"1 m\", \"1 m\", \"-19 mm\"]]\n";
    let path = "[[0.0, 0.003, -0.05, 0.03], [0.6, 0.003, -0.05, 0.03], [1.0, 0.003, -0.05, -0.01]]";
    let mut session = scene("", held, path, "toughness = 1", pull);
    let bench = Bench::new();
    let written = |session: &mut Session| {
        session.update_surface();
        write_model(&session.bodies[0], "cut", &bench.path("final.obj")).unwrap();
        bench.read("final.obj")
    };
    let whole = session.bodies[0].model.document.bytes().to_vec();
    run(&mut session, 0.5);
    let pulled = written(&mut session);
    assert!(pulled != whole && session.cuts().advances == 0);
    run(&mut session, 0.65);
    assert!(session.cuts().advances > 5 && session.history().done == 2, "{:?}", session.history());
    run(&mut session, 0.1);
    assert_eq!(session.history(), HistoryCounts { done: 1, undone: 1 });
    let rest = &session.bodies[0].skin.settled;
    assert!(rest.len() == session.bodies[0].model.document.positions().len(), "the cut is gone, the pull is not");
    assert!(written(&mut session) == pulled);
    run(&mut session, 0.1);
    assert!(written(&mut session) == whole, "the file as it was handed in");
}
