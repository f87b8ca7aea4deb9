//! A cut body is split: each part becomes a body of its own, and nothing of its shape, motion and stuff changes by that.

use pliant_engine::body::{Body, Division};
use pliant_engine::session::{EventKind, Session, SessionCommand};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::{Random, models};
use pliant_plugin_api::abi::Ball;
use pliant_solver::StepTime;
use pliant_tests::sweep::{Sweep, cut};
use pliant_tests::{Bench, NOW, asked_cases, open_file, root};
use std::collections::BTreeMap;
use std::ops::Range;

/// A material and what it needs in a `[[body]]`.
const SOLIDS: [&str; 4] = [
    "material = { plugin = \"mass-spring\", params = { young = \"80 kPa\" } }",
    "material = { plugin = \"neo-hookean\", params = { young = \"80 kPa\" } }",
    "material = { plugin = \"corotational\", params = { young = \"80 kPa\" } }",
    "material = { plugin = \"neo-hookean\", params = { young = \"80 kPa\", yield-strain = 0.02 } }",
];

/// Levels of solids, from 3 on.
const LEVELS: usize = 3;
/// Seeds of generated models. `SPLITS=0..20` asks for those.
const SEEDS: Range<u64> = 0..2;

/// A free body of 100 mm, with undo, that blades may cut.
fn scene(body: &str) -> String {
    format!(
        r#"
        format = 1
        gravity = [0, -9.81, 0]
        [time]
        duration = "1 s"
        dt = "1 ms"
        integrator = "backward-euler"
        [[body]]
        name = "thing"
        {body}
        [[device]]
        name = "hand"
        params = {{ path = [[0.0, 1.0, 1.0, 1.0]] }}
        [[tool]]
        name = "knife"
        device = "hand"
        radius = "1 mm"
        blade = {{ length = "200 mm", direction = [0, 1, 0] }}
        [[edit]]
        kind = "cut"
        tool = "knife"
        "#
    )
}

/// The generated models of a seed with a body's lines for each: solids at levels from 3 on, and cloth.
fn cases(bench: &Bench, seed: u64) -> Vec<(String, String)> {
    let mut random = Random(seed);
    let mut cases = Vec::new();
    for (i, model) in models(6, seed).into_iter().enumerate() {
        let file = format!("{seed}-{i}.obj");
        bench.write(&file, &model.text);
        let level = 3 + (seed as usize + i) % LEVELS;
        let material = random.pick(&SOLIDS);
        let extent = random.pick(&["whole", "whole", "local"]);
        cases.push((
            format!("{} of seed {seed}, level {level}, {extent}, {material}", model.name),
            format!(
                "mesh = \"{file}\"\nsize = \"100 mm\"\n{material}\ngrid = {{ level = {level}, region = \"{extent}\" }}"
            ),
        ));
    }
    let pattern = random.pick(&["regular", "alternating", "irregular"]);
    cases.push((
        format!("cloth of seed {seed}, {pattern}"),
        format!(
            "shape = {{ kind = \"sheet\", cells = 14, size = [0.1, 0.1, 0.0], pattern = \"{pattern}\" }}\nposition = [-0.05, -0.05, 0]\n\
             material = {{ plugin = \"cloth\" }}\nsheet = {{}}"
        ),
    ));
    cases
}

/// Opens a case, cuts it by a random blade and lets it move. `None` where the blade has left one part.
fn cut_and_moving(bench: &Bench, body: &str, seed: u64) -> Option<Session> {
    let mut session = open_file(&bench.write("scene.toml", scene(body)), 1, None);
    session.keep_history();
    session.step();
    cut(&mut session.bodies[0], &Sweep::random(seed), 40);
    session.changed(0);
    if session.bodies[0].parts().iter().max() == Some(&0) {
        return None;
    }
    if !session.bodies[0].discretization.is_whole() {
        // As around a contact.
        let Body { model, skin, system, discretization, fixings, .. } = &mut session.bodies[0];
        let ball = Ball { centre: [0.0; 3], radius: 0.06 };
        discretization.follow(&[ball], model, fixings, skin, system).unwrap();
        session.changed(0);
    }
    let nodes = &mut session.bodies[0].system.nodes;
    for i in 0..nodes.len() {
        let at = nodes.rest[i];
        nodes.v[i] = Vec3::new(-3.0 * at.y, 3.0 * at.x, 1.0 * at.z) + Vec3::new(0.0, 0.1, 0.05);
    }
    steps(&mut session, 5);
    session.update_surface();
    Some(session)
}

/// Takes this many steps of a session.
fn steps(session: &mut Session, count: usize) {
    (0..count).for_each(|_| session.step());
}

/// Mass (kg), momentum (N s), kinetic and elastic energy (J) of all bodies.
fn balance(session: &mut Session) -> (f64, Vec3, [f64; 2]) {
    let (mut mass, mut momentum, mut energy) = (0.0, Vec3::zeros(), [0.0; 2]);
    for body in &mut session.bodies {
        let nodes = &body.system.nodes;
        // Ghost nodes beyond clamped edges have no mass to speak of.
        mass += nodes.mass.iter().sum::<f64>();
        momentum += nodes.v.iter().zip(&nodes.mass).map(|(v, m)| *m * v).sum::<Vec3>();
        energy[0] += nodes.kinetic_energy();
        energy[1] += body.system.energy(NOW).unwrap();
    }
    (mass, momentum, energy)
}

/// Force on each node (N) by its rest position and position; copies of a node at one place are told apart by their velocities.
fn forces(session: &mut Session) -> BTreeMap<[u64; 9], Vec3> {
    let mut all = BTreeMap::new();
    for index in 0..session.bodies.len() {
        let mut force = vec![Vec3::zeros(); session.bodies[index].system.nodes.len()];
        let pool = pliant_solver::Pool::new(1);
        session.bodies[index].system.forces(&pool, None, StepTime { start: 0.0, dt: 1e-3 }, &mut force).unwrap();
        let nodes = &session.bodies[index].system.nodes;
        for (i, force) in force.into_iter().enumerate() {
            let key: Vec<u64> = [nodes.rest[i], nodes.x[i], nodes.v[i]].iter().flatten().map(|c| c.to_bits()).collect();
            *all.entry(key.try_into().unwrap()).or_insert_with(Vec3::zeros) += force;
        }
    }
    all
}

/// Triangles by the numbers and the bits of the positions of their corners, sorted.
fn triangles<'a>(bodies: impl Iterator<Item = &'a Body>) -> Vec<[(u32, [u64; 3]); 3]> {
    let mut all = Vec::new();
    for body in bodies {
        let drawn = (0..body.model.surface.triangles.len() as u32).filter(|t| !body.model.is_lid(*t));
        all.extend(drawn.map(|t| {
            body.model.surface.triangles[t as usize].map(|v| (v, body.skin.x[v as usize].map(f64::to_bits).into()))
        }));
    }
    all.sort_unstable();
    all
}

/// Everything that a step reads and writes of all bodies, as bits.
fn state(session: &Session) -> Vec<u64> {
    let of = |body: &Body| -> Vec<u64> {
        let nodes = &body.system.nodes;
        let vectors =
            nodes.rest.iter().chain(&nodes.x).chain(&nodes.v).chain(&body.skin.x).chain(body.skin.settled.iter());
        let numbers = vectors.flatten().chain(&nodes.mass).chain(body.system.sets.iter().flat_map(|set| set.history()));
        numbers.map(|x| x.to_bits()).collect()
    };
    session.bodies.iter().flat_map(of).collect()
}

/// Splits what random blades have cut, and checks what must not change by that.
#[test]
fn a_split_changes_no_shape_motion_or_force() {
    let bench = Bench::new();
    let mut split = 0;
    for seed in asked_cases("SPLITS").unwrap_or(SEEDS) {
        for (name, body) in cases(&bench, seed) {
            let Some(mut session) = cut_and_moving(&bench, &body, seed) else { continue };
            let (before, drawn, felt) = (balance(&mut session), triangles(session.bodies.iter()), forces(&mut session));
            let Ok(bodies) = session.split(0, Division::EachPart) else {
                // Shells that share cells hang together in the lattice.
                continue;
            };
            split += 1;
            assert!(bodies.len() > 1 && bodies.len() == session.bodies.len(), "{name}: {bodies:?}");
            assert!(triangles(session.bodies.iter()) == drawn, "{name}: triangles or positions");
            session.update_surface();
            assert!(triangles(session.bodies.iter()) == drawn, "{name}: positions that follow from the nodes");
            let (mass, momentum, [kinetic, elastic]) = balance(&mut session);
            // Sums have another order; elements and nodes are the same.
            let near = |a: f64, b: f64, scale: f64| (a - b).abs() <= 1e-12 * scale;
            assert!(near(mass, before.0, mass), "{name}: mass {mass}, before {}", before.0);
            assert!(
                (momentum - before.1).norm() <= 1e-12 * mass,
                "{name}: momentum {momentum:?}, before {:?}",
                before.1
            );
            let scale = before.2[0] + before.2[1];
            assert!(near(kinetic, before.2[0], scale), "{name}: kinetic energy {kinetic}, before {}", before.2[0]);
            assert!(near(elastic, before.2[1], scale), "{name}: elastic energy {elastic}, before {}", before.2[1]);
            let now = forces(&mut session);
            assert_eq!(now.len(), felt.len(), "{name}: nodes");
            let largest = felt.values().map(|f| f.norm()).fold(0.0, f64::max);
            for (key, force) in &felt {
                let off = now.get(key).map_or(f64::INFINITY, |other| (other - force).norm());
                assert!(off <= 1e-12 * largest.max(1e-9), "{name}: a force is off by {off} N of {largest} N");
            }
        }
    }
    assert!(asked_cases("SPLITS").is_some() || split > 6, "{split} splits");
}

/// Undo brings the whole back with every bit, redo the parts, and what follows is the same each time.
#[test]
fn undo_makes_the_parts_one_body_again() {
    let bench = Bench::new();
    let mut split = 0;
    for seed in asked_cases("SPLITS").unwrap_or(SEEDS) {
        for (name, body) in cases(&bench, seed) {
            let Some(mut session) = cut_and_moving(&bench, &body, seed) else { continue };
            let (whole, entries) = (state(&session), session.history().done);
            if session.split(0, Division::EachPart).is_err() {
                assert!(state(&session) == whole, "{name}: a refused split changes nothing");
                assert!(session.history().done <= entries, "{name}: and is nothing to undo");
                continue;
            }
            split += 1;
            let parts = state(&session);
            let names: Vec<String> = session.bodies.iter().map(|body| body.name.clone()).collect();
            steps(&mut session, 4);
            session.update_surface();
            let later = state(&session);
            assert!(later != parts, "{name}: the parts move");
            assert!(session.undo(), "{name}");
            session.update_surface();
            assert_eq!(session.bodies.len(), 1, "{name}");
            assert!(state(&session) == whole, "{name}: the whole");
            steps(&mut session, 2);
            assert!(session.redo(), "{name}");
            assert_eq!(session.bodies.iter().map(|body| body.name.clone()).collect::<Vec<_>>(), names, "{name}");
            // A redo goes on from where the undo was asked for.
            session.update_surface();
            assert!(state(&session) == later, "{name}: the parts again");
            assert!(session.bodies.iter().all(|body| body.frozen.is_none()), "{name}");
        }
    }
    assert!(asked_cases("SPLITS").is_some() || split > 6, "{split} splits");
}

/// Parts of a free body move as they would within it, and each on its own: what is done to one moves no other.
#[test]
fn each_part_moves_on_alone() {
    let bench = Bench::new();
    let body = "shape = { kind = \"box\", cells = 12, size = [0.1, 0.09, 0.08] }\n\
                material = { plugin = \"neo-hookean\", params = { young = \"80 kPa\" } }\ngrid = { level = 4, region = \"whole\" }";
    let mut session = cut_and_moving(&bench, body, 5).expect("two parts");
    let bodies = session.split(0, Division::EachPart).unwrap();
    assert_eq!(bodies, [0, 1]);
    let other = |session: &Session| session.bodies[1].system.nodes.x.clone();
    let snapshot = session.snapshot();
    steps(&mut session, 20);
    let undisturbed = other(&session);
    session.restore(&snapshot).unwrap();
    session.bodies[0].system.nodes.v.iter_mut().for_each(|v| v.x += 2.0);
    steps(&mut session, 20);
    assert!(other(&session) == undisturbed, "a push of one part moves the other");
    // Free fall: gravity alone changes momentum.
    let momentum = |session: &Session| {
        let nodes = &session.bodies[0].system.nodes;
        nodes.v.iter().zip(&nodes.mass).map(|(v, m)| *m * v).sum::<Vec3>()
    };
    let mass: f64 = session.bodies[0].system.nodes.mass.iter().sum();
    let before = momentum(&session);
    steps(&mut session, 20);
    let fall = (momentum(&session) - before) / mass;
    assert!((fall - Vec3::new(0.0, -9.81 * 0.02, 0.0)).norm() < 1e-4, "{fall:?} m/s");
}

/// A part that was split off is cut and split like any body.
#[test]
fn a_part_can_be_cut_and_split_again() {
    let bench = Bench::new();
    let mut seen = 0;
    for seed in 0..6 {
        let body = format!(
            "shape = {{ kind = \"box\", cells = 12, size = [0.1, 0.09, 0.08] }}\n{}\ngrid = {{ level = {}, region = \"whole\" }}",
            SOLIDS[seed as usize % 4],
            3 + seed % 3
        );
        let Some(mut session) = cut_and_moving(&bench, &body, seed) else { continue };
        session.split(0, Division::EachPart).unwrap();
        let volume = |session: &Session| session.bodies[0].system.nodes.mass.iter().sum::<f64>();
        let mass = volume(&session);
        cut(&mut session.bodies[0], &Sweep::random(seed + 100), 40);
        session.changed(0);
        session.step();
        if session.bodies[0].parts().iter().max() == Some(&0) {
            continue;
        }
        seen += 1;
        let parted = volume(&session);
        assert!((parted - mass).abs() < 1e-9 * mass, "seed {seed}: {parted} kg of {mass} kg after the second cut");
        let drawn = triangles(session.bodies.iter());
        let bodies = session.split(0, Division::EachPart).unwrap();
        assert!(bodies.len() >= 2, "seed {seed}: {bodies:?}");
        assert!(triangles(session.bodies.iter()) == drawn, "seed {seed}: triangles");
        let names: std::collections::BTreeSet<&str> = session.bodies.iter().map(|body| body.name.as_str()).collect();
        assert_eq!(names.len(), session.bodies.len(), "{names:?}");
        steps(&mut session, 10);
        assert!(session.bodies.iter().all(|body| body.frozen.is_none()), "seed {seed}");
        assert!(session.undo() && session.undo() && session.bodies.len() == 1, "seed {seed}");
    }
    assert!(seen > 2, "{seen}");
}

/// `split = true` of a scene's cut leaves a file for each part with the faces of the whole, and a recording of it is replayed to the bit.
#[test]
fn a_scene_splits_what_it_has_cut() {
    let bench = Bench::new();
    bench.write(
        "scene.toml",
        r#"
        format = 1
        [time]
        duration = 0.45
        integrator = "backward-euler"
        [[body]]
        name = "block"
        shape = { kind = "box", cells = 8, size = [0.04, 0.04, 0.04] }
        material = { plugin = "mass-spring", params = { young = "200 kPa", damping-time = "2 ms" } }
        grid = { level = 4, region = "whole" }
        [[device]]
        name = "hand"
        params = { path = [[0, 0.004, -0.05, 0.035], [0.3, 0.006, -0.05, -0.035]] }
        [[tool]]
        name = "knife"
        device = "hand"
        radius = "1 mm"
        blade = { length = "100 mm", direction = [0, 1, 0] }
        [[edit]]
        kind = "cut"
        tool = "knife"
        end = 0.4
        split = true
        "#,
    );
    let run = |arguments: &[&str]| bench.pliant(&[&["run", "scene.toml", "-q"], arguments].concat()).expect(0);
    run(&["--out", "parts", "--record", "hand.rec"]);
    run(&["--out", "whole", "--set", "edit.0.split=false"]);
    let faces = |name: &str| bench.read(name).split(|b| *b == b'\n').filter(|line| line.starts_with(b"f ")).count();
    let parts = ["parts/final-block.obj", "parts/final-block-2.obj"];
    assert_eq!(parts.map(faces).iter().sum::<usize>(), faces("whole/final.obj"));
    bench.pliant(&["replay", "hand.rec", "--verify", "-q", "--out", "again"]).expect(0);
    for name in parts {
        assert!(bench.read(name) == bench.read(&name.replace("parts", "again")), "{name}");
    }
    let refused = bench.pliant(&["run", "scene.toml", "--set", "edit.0.kind=touch"]).expect(2);
    refused.says(&["`touch` does not read `split`"]);
}

/// A slab thinner than half a cell stays with the cells beside it: the body is not split, and it is said that the grid holds what the surface does not.
#[test]
fn a_slab_that_the_grid_cannot_part_is_told() {
    for (thickness, says) in [(0.001, "still hold together"), (0.012, "")] {
        let z = 0.02 - thickness;
        let text = format!(
            r#"
            format = 1
            [time]
            duration = "0.2 s"
            dt = "1 ms"
            [[body]]
            name = "block"
            shape = {{ kind = "box", cells = 8, size = ["40 mm", "40 mm", "40 mm"] }}
            material = {{ plugin = "mass-spring" }}
            grid = {{ level = 3, region = "whole" }}
            [[device]]
            name = "hand"
            params = {{ path = [[0.0, -0.05, -0.1, {z}], [0.1, 0.05, -0.1, {z}]] }}
            [[tool]]
            name = "knife"
            device = "hand"
            radius = "1 mm"
            blade = {{ length = "200 mm", direction = [0, 1, 0], toughness = 0 }}
            [[edit]]
            kind = "cut"
            tool = "knife"
            end = "0.15 s"
            split = true
            "#
        );
        let bench = Bench::new();
        let mut session = open_file(&bench.write("scene.toml", text), 1, None);
        (0..200).for_each(|_| session.step());
        let events = session.events.described();
        let refused: Vec<&str> = events
            .iter()
            .filter(|(kind, _)| *kind == EventKind::SplitRefused)
            .map(|(_, event)| event.text.as_str())
            .collect();
        match says {
            "" => assert_eq!((refused.len(), session.bodies.len()), (0, 2), "{thickness} m: {refused:?}"),
            _ => assert!(refused.len() == 1 && refused[0].contains(says), "{thickness} m: {refused:?}"),
        }
    }
}

/// Cuts at any angle through a model with legs and ears that come near each other, by a blade that pulls at what it cuts: what the cut has parted in the surface, the
/// cells of the grid let go. They held it where the blade missed a link between voxels (case 6), where limbs share a cell beside the cut (case 30) or a node of cells
/// that no corner of a triangle is in (cases 38 and 58), and points where some of one part are in the cells of another (case 17).
///
/// `GRAZE=0..200` asks for those cases instead.
#[test]
fn cells_let_go_what_a_cut_has_parted() {
    let asked = asked_cases("GRAZE").map_or(vec![6, 17, 30, 38, 58], Iterator::collect);
    for case in asked {
        let random = &mut Random(300 + case);
        let level = 5 + case % 2;
        let down = random.direction();
        let along = down.cross(&random.direction()).normalize();
        let across = along.cross(&down);
        let start = 0.045 * random.signed() * across - 0.09 * down - 0.15 * along;
        let [from, to] = [start, start + 0.18 * down].map(|p| format!("{}, {}, {}", p.x, p.y, p.z));
        let text = format!(
            "format = 1\n[time]\nduration = 1\ndt = \"1 ms\"\n[[body]]\nmesh = \"model.obj\"\nsize = 0.1\n\
             material = {{ plugin = \"mass-spring\", params = {{ young = \"30 kPa\", damping-time = \"5 ms\" }} }}\ngrid = {{ level = {level} }}\n\
             [[device]]\nname = \"hand\"\nparams = {{ path = [[0, {from}], [0.15, {to}]] }}\n\
             [[tool]]\nname = \"knife\"\ndevice = \"hand\"\nradius = 0.004\nstiffness = 240\n\
             blade = {{ length = 0.3, direction = [{}, {}, {}], toughness = 1 }}\n\
             [[edit]]\nkind = \"cut\"\ntool = \"knife\"\nend = 0.16\n",
            along.x, along.y, along.z
        );
        let bench = Bench::new();
        bench.write("model.obj", std::fs::read(root().join("scenes/elephant.obj")).expect("a model"));
        let mut session = open_file(&bench.write("scene.toml", text), 1, None);
        (0..200).for_each(|_| session.step());
        // Smaller ones may stay with what is beside them: the voxels of a thin part need not be connected, and fewer than 32, half a cell, are merged.
        let least = 2.0 * (0.1 / f64::from(1 << level)).powi(3);
        let mesh = session.bodies[0].cut.as_ref().expect("a cut");
        let parts = mesh.parts().all.iter().filter(|part| part.volume > least).count();
        let _ = session.apply(SessionCommand::SplitBody { body: 0, triangle: None });
        let bodies = session.bodies.len();
        assert!(bodies >= parts, "case {case}, level {level}: {parts} parts of the surface, {bodies} bodies");
    }
}
