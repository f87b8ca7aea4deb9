//! Surfaces of solids whose elements have failed (`pliant.failure/1`): what is gone goes, what has come to light is there, in pictures, files and contact.

use pliant_engine::body::Body;
use pliant_engine::session::{EventKind, Session};
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::tetrahedra::{TetBox, TetFormat};
use pliant_mesh::testing::{Random, TestModel, scan};
use pliant_record::write_model_to;
use pliant_tests::breaking::{fail, is_in, open_edges, random_boxes, shown, written};
use pliant_tests::{Bench, open_file};
use std::collections::{BTreeMap, BTreeSet};

/// So strong that nothing fails but what a test has fail.
const MATERIAL: &str = "material = { plugin = \"quasi-brittle\", params = { young = 1e6, strength = 1e8, fracture-energy = 1e9, damping-time = 5e-3 } }";

/// A scene of one body that is simulated, with further lines of the body and of the scene.
fn scene(body: &str, rest: &str) -> String {
    format!(
        "format = 1\n{rest}\n[time]\ndt = 1e-3\nintegrator = \"backward-euler\"\n[[body]]\nname = \"b\"\n{MATERIAL}\n{body}\n"
    )
}

/// So little that it is none, but a body without a load is not simulated.
const WEIGHTLESS: &str = "gravity = [0, 0, -1e-9]";

/// A fixing of all nodes of the body, so that nothing but failure changes its shape.
const HELD: &str = "fixed = [{ box = [[-9, -9, -9], [9, 9, 9]] }]";

/// A session of a tetrahedral mesh, after a step.
fn of_mesh(mesh: &TetBox, body: &str, rest: &str, threads: usize) -> Session {
    let bench = Bench::new();
    bench.write("box.vtk", mesh.bytes(TetFormat::Vtk));
    let text = scene(&format!("mesh = \"box.vtk\"\n{body}"), rest);
    let mut session = open_file(&bench.write("scene.toml", text), threads, None);
    session.step();
    session
}

/// A session of a box in a grid, of random size, place and mesh, after a step.
fn in_grid(seed: u64, rest: &str) -> Session {
    let mut random = Random(seed);
    let size = [0, 1, 2].map(|_| 0.05 + 0.05 * random.unit());
    let at = [0, 1, 2].map(|_| 0.02 * random.signed());
    let (cells, level) = (8 + random.below(12), 4);
    let text = scene(
        &format!(
            "shape = {{ kind = \"box\", cells = {cells}, size = {size:?} }}\nposition = {at:?}\ngrid = {{ level = {level}, region = \"whole\" }}"
        ),
        rest,
    );
    let mut session = open_file(&Bench::new().write("scene.toml", text), 1, None);
    session.step();
    session
}

/// A point by its bits.
fn bits(point: Vec3) -> [u64; 3] {
    [0, 1, 2].map(|i| (point[i] + 0.0).to_bits())
}

/// Triangles as corners by their bits, each from its least corner on, sorted.
fn by_bits(triangles: impl Iterator<Item = [Vec3; 3]>) -> Vec<[[u64; 3]; 3]> {
    let mut all: Vec<_> = triangles
        .map(|corners| {
            let mut corners = corners.map(bits);
            let least = (0..3).min_by_key(|i| corners[*i]).expect("three");
            corners.rotate_left(least);
            corners
        })
        .collect();
    all.sort_unstable();
    all
}

/// Faces of the tetrahedra that are left and belong to one of them, at rest, counter-clockwise seen from outside.
fn boundary_left(body: &Body) -> Vec<[Vec3; 3]> {
    let set = body.system.sets.iter().find(|set| !set.failed().is_empty()).expect("tetrahedra");
    let mut faces: BTreeMap<[u32; 3], Vec<[u32; 3]>> = BTreeMap::new();
    for (t, _) in set.nodes().chunks(4).zip(set.failed()).filter(|(_, failed)| **failed == 0) {
        let [a, b, c, d] = [t[0], t[1], t[2], t[3]];
        for face in [[b, c, d], [a, d, c], [a, b, d], [a, c, b]] {
            let mut key = face;
            key.sort_unstable();
            faces.entry(key).or_default().push(face);
        }
    }
    let rest = &body.system.nodes.rest;
    faces.into_values().filter(|f| f.len() == 1).map(|f| f[0].map(|n| rest[n as usize])).collect()
}

/// Area of the faces that have come to light, m^2, at rest.
fn exposed_area(body: &Body) -> f64 {
    let exposed = body.failed_triangles.exposed();
    let faces = exposed.triangles().iter().zip(exposed.pieces_of()).filter(|(_, of)| of.is_none());
    let corners = faces.map(|(t, _)| t.map(|v| body.model.surface.points[v as usize]));
    corners.map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()).sum()
}

#[test]
fn a_layer_of_cubes_that_fails_brings_both_sides_of_its_crack_to_light() {
    for seed in 0..12 {
        let mut session = in_grid(seed, WEIGHTLESS);
        let before = shown(&mut session);
        let bytes = written(&mut session).0;
        let state = session.snapshot();
        let body = &session.bodies[0];
        let lattice = body.discretization.lattice().expect("a solid");
        let (edge, origin) = (lattice.edge(), Vec3::from(lattice.facts.origin));
        let bounds = body.model.surface.bounds();
        let axis = seed as usize % 3;
        // The layer of cubes in the middle, whose tetrahedra all fail.
        let index = ((bounds.centre()[axis] - origin[axis]) / edge).floor();
        let layer = |x: Vec3| ((x[axis] - origin[axis]) / edge).floor() == index;
        assert!(fail(&mut session, layer) > 20);
        let known = before.0.triangles.len() as u32;
        let (surface, _, triangles, _) = shown(&mut session);
        assert!(surface.triangles[..known as usize] == before.0.triangles, "{seed}");
        let size = bounds.max - bounds.min;
        let across: f64 = (0..3).filter(|i| *i != axis).map(|i| size[i]).product();
        let area = exposed_area(&session.bodies[0]);
        assert!((area / (2.0 * across) - 1.0).abs() < 1e-4, "{seed}: {area} of {} m^2", 2.0 * across);
        // What is drawn of the old surface has nothing in the layer.
        let body = &session.bodies[0];
        for corners in triangles.iter().map(|t| t.map(|v| surface.points[v as usize])) {
            let [low, high] = [0.0, 1.0].map(|side| origin[axis] + (index + side) * edge);
            let span = corners.iter().fold([f64::MAX, f64::MIN], |[l, h], x| [l.min(x[axis]), h.max(x[axis])]);
            let margin = 1e-4 * edge;
            assert!(span[1] <= low + margin || span[0] >= high - margin, "{seed}: {corners:?} in {low} to {high}");
        }
        assert_eq!(body.parts().iter().filter(|part| **part != pliant_mesh::NO_SHELL).max(), Some(&1), "two parts");
        assert_eq!(written(&mut session).1.triangles.len(), triangles.len(), "{seed}");
        session.restore(&state).expect("goes back");
        assert!(shown(&mut session) == before && written(&mut session).0 == bytes, "{seed}: an undo brings all back");
    }
}

/// A session of a body in a grid, after a step.
fn of_body_in_grid(body: &str, model: Option<&TestModel>, threads: usize) -> Session {
    let bench = Bench::new();
    if let Some(model) = model {
        bench.write("model.obj", &model.text);
    }
    let text = scene(&format!("{body}\ngrid = {{ level = 4, region = \"whole\" }}\n{HELD}"), WEIGHTLESS);
    let mut session = open_file(&bench.write("scene.toml", text), threads, None);
    session.step();
    session
}

/// Volume within triangles with vertices at `points` (m), m^3.
fn volume(triangles: &[[u32; 3]], points: &[Vec3]) -> f64 {
    let corners = triangles.iter().map(|t| t.map(|v| points[v as usize]));
    corners.map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0).sum()
}

/// Blocks, balls and noisy models in grids stay closed, whichever cubes fail: on screen and in the file, for what has failed and for all else, whose volumes add up.
#[test]
fn a_closed_body_in_a_grid_stays_closed_when_it_breaks() {
    let mut broken = 0;
    for seed in 0..36 {
        let mut random = Random(100 + seed);
        let genus = (seed / 3 % 3) as u32;
        let model = (seed % 3 == 2).then(|| scan(genus, 400, 0, seed));
        let at = [0, 1, 2].map(|_| 0.02 * random.signed());
        let size = [0, 1, 2].map(|_| 0.05 + 0.05 * random.unit());
        let body = match seed % 3 {
            0 => format!("shape = {{ kind = \"box\", cells = {}, size = {size:?} }}", 1 + random.below(14)),
            1 => {
                format!("shape = {{ kind = \"sphere\", cells = {}, size = {:?} }}", 8 + random.below(16), [size[0]; 3])
            }
            _ => "mesh = \"model.obj\"\nsize = 0.1".into(),
        };
        let body = format!("{body}\nposition = {at:?}");
        let mut session = of_body_in_grid(&body, model.as_ref(), 1);
        let before = shown(&mut session);
        let whole = volume(&before.2, &before.1);
        let bytes = written(&mut session).0;
        let state = session.snapshot();
        let boxes = random_boxes(&session.bodies[0], &mut random);
        let mut sum = 0.0;
        for is_inverted in [false, true] {
            let count = fail(&mut session, |point| is_in(&boxes, point) != is_inverted);
            let what = format!("{seed}, inverted {is_inverted}: {count} have failed");
            let (_, settled, drawn, _) = shown(&mut session);
            assert!(open_edges(&drawn).is_empty(), "{what}: {:?}", open_edges(&drawn));
            broken += usize::from(count > 0 && !drawn.is_empty());
            sum += volume(&drawn, &settled);
            if drawn.is_empty() {
                let mut bytes = Vec::new();
                write_model_to(&session.bodies[0], "fracture", &mut bytes).expect("a file without faces");
                assert!(!bytes.windows(2).any(|pair| pair == b"f "), "{what}");
            } else {
                let (_, file) = written(&mut session);
                assert_eq!(file.triangles.len(), drawn.len(), "{what}");
                assert!(open_edges(&file.triangles).is_empty(), "{what}: the file is closed");
            }
            session.restore(&state).expect("goes back");
            assert!(
                shown(&mut session) == before && written(&mut session).0 == bytes,
                "{what}: an undo brings all back"
            );
        }
        assert!((sum / whole - 1.0).abs() < 1e-5, "{seed}: {sum} of {whole} m^3");
    }
    assert!(broken > 50, "{broken} of 72");
}

#[test]
fn the_surface_of_tetrahedra_is_the_boundary_of_those_left() {
    let mut broken = 0;
    for seed in 0..40 {
        let mut random = Random(seed);
        let mesh = TetBox::random(seed).shuffled(seed);
        let mut session = of_mesh(&mesh, HELD, WEIGHTLESS, 1);
        let before = shown(&mut session);
        let bytes = written(&mut session).0;
        let state = session.snapshot();
        let boxes = random_boxes(&session.bodies[0], &mut random);
        let count = fail(&mut session, |point| is_in(&boxes, point));
        broken += usize::from(count > 0 && count < mesh.tetrahedra.len());
        let (surface, settled, triangles, _) = shown(&mut session);
        let body = &session.bodies[0];
        let corners = triangles.iter().map(|t| t.map(|v| settled[v as usize]));
        assert!(by_bits(corners) == by_bits(boundary_left(body).into_iter()), "{seed}: {count} have failed");
        assert!(open_edges(&triangles).is_empty(), "{seed}: {:?}", open_edges(&triangles));
        let known = before.0.triangles.len();
        assert!(surface.triangles[..known] == before.0.triangles, "{seed}: what the body had keeps its numbers");
        assert!(settled[..before.1.len()] == before.1, "{seed}: and its places");
        // The file has what is drawn, and the rows it had before where they are still used.
        let (text, file) = written(&mut session);
        assert_eq!(file.triangles.len(), triangles.len(), "{seed}");
        assert!(open_edges(&file.triangles).is_empty(), "{seed}: the file is closed");
        let rows: BTreeSet<&[u8]> = bytes.split(|b| *b == b'\n').filter(|line| line.starts_with(b"v ")).collect();
        let kept = text.split(|b| *b == b'\n').filter(|line| line.starts_with(b"v ") && rows.contains(line)).count();
        let used: BTreeSet<u32> =
            triangles.iter().flatten().filter(|v| (**v as usize) < before.1.len()).copied().collect();
        assert!(count > 0 || text == bytes, "{seed}");
        assert_eq!(kept, used.len(), "{seed}: rows that are used are as they were, and no others");
        session.restore(&state).expect("goes back");
        assert!(shown(&mut session) == before && written(&mut session).0 == bytes, "{seed}: an undo brings all back");
    }
    assert!(broken > 25, "{broken} of 40 were broken in part");
}

/// What is shown follows from which elements have failed, in whatever order and on however many threads.
#[test]
fn neither_the_order_of_failures_nor_threads_are_in_the_surface() {
    for seed in 0..8 {
        let mesh = TetBox::random(seed).shuffled(seed);
        let results = [(1, false), (3, false), (1, true)].map(|(threads, is_in_turn)| {
            let mut session = of_mesh(&mesh, HELD, WEIGHTLESS, threads);
            let (mut random, body) = (Random(seed), &session.bodies[0]);
            let [first, second] = [0, 1].map(|_| random_boxes(body, &mut random));
            let is_first = |x: Vec3| is_in(&first, x);
            let is_any = |x: Vec3| is_first(x) || is_in(&second, x);
            if is_in_turn {
                fail(&mut session, is_first);
            }
            fail(&mut session, is_any);
            (shown(&mut session), written(&mut session).0)
        });
        assert!(results[0] == results[1], "{seed}: threads");
        assert!(results[0] == results[2], "{seed}: order");
    }
}

/// A piece that comes free falls as a stone does, and what is held stays; both are parts of their own.
#[test]
fn free_pieces_fall() {
    for is_in_grid in [false, true] {
        let rest = "gravity = [0, 0, -9.81]";
        let held = "fixed = [{ box = [[-1, -1, -1], [1e-3, 1, 1]] }]";
        let mut session = if is_in_grid {
            let body = format!(
                "shape = {{ kind = \"box\", cells = 20, size = [0.1, 0.04, 0.04] }}\nposition = [0.05, 0.02, 0.02]\ngrid = {{ level = 5, region = \"whole\" }}\n{held}"
            );
            let mut session = open_file(&Bench::new().write("scene.toml", scene(&body, rest)), 1, None);
            session.step();
            session
        } else {
            of_mesh(&TetBox::new([10, 4, 4], [0.1, 0.04, 0.04], 0.0, 1), held, rest, 1)
        };
        assert!(fail(&mut session, |x| (x.x - 0.055).abs() < 0.008) > 50);
        let start = session.time();
        let before = session.bodies[0].system.nodes.x.clone();
        let speed: Vec<Vec3> = session.bodies[0].system.nodes.v.clone();
        while session.time() < start + 0.1 - 1e-9 {
            session.step();
        }
        let nodes = &session.bodies[0].system.nodes;
        let mean = |range: [f64; 2]| {
            let those: Vec<usize> =
                (0..nodes.len()).filter(|i| (range[0]..range[1]).contains(&nodes.rest[*i].x)).collect();
            let mass: f64 = those.iter().map(|i| nodes.mass[*i]).sum();
            let fallen = |i: &usize| nodes.mass[*i] / mass * (nodes.x[*i].z - before[*i].z - 0.1 * speed[*i].z);
            those.iter().map(fallen).sum::<f64>()
        };
        // Backward Euler falls by g t (t + dt) / 2.
        let expected = -9.81 * 0.1 * (0.1 + 1e-3) / 2.0;
        let (free, held) = (mean([0.07, 1.0]), mean([-1.0, 0.04]));
        assert!((free / expected - 1.0).abs() < 1e-3, "grid {is_in_grid}: {free} of {expected} m");
        assert!(held.abs() < 0.02 * expected.abs(), "grid {is_in_grid}: {held} m");
        let parts = session.bodies[0].parts();
        assert_eq!(parts.iter().filter(|part| **part != pliant_mesh::NO_SHELL).max(), Some(&1), "grid {is_in_grid}");
    }
}

/// Size of a block from the origin on, m.
const BLOCK: [f64; 3] = [0.1, 0.1, 0.035];

/// A block that is held at both ends of x, in a grid or as a tetrahedral mesh, with further lines of the scene, after a step.
fn held_block(is_in_grid: bool, mesh: &TetBox, rest: &str) -> Session {
    let held = "fixed = [{ box = [[-1, -1, -1], [1e-3, 1, 1]] }, { box = [[0.099, -1, -1], [1, 1, 1]] }]";
    if !is_in_grid {
        return of_mesh(mesh, held, rest, 1);
    }
    let middle = BLOCK.map(|edge| 0.5 * edge);
    let body = format!(
        "shape = {{ kind = \"box\", cells = 20, size = {BLOCK:?} }}\nposition = {middle:?}\ngrid = {{ level = 5, region = \"whole\" }}\n{held}"
    );
    let mut session = open_file(&Bench::new().write("scene.toml", scene(&body, rest)), 1, None);
    session.step();
    session
}

/// Largest force on a tool (N) and impulse of an obstacle (N s) that go down at two places of a block, then the force on the tool as it goes aside within it. The block may have failed
/// around both places before, on a session of its own or on one that was broken and then taken back.
fn crossed(is_in_grid: bool, radius: f64, is_broken: bool, is_undone: bool) -> [f64; 3] {
    let rest = format!(
        r#"
        {WEIGHTLESS}
        [[device]]
        name = "hand"
        plugin = "scripted"
        params = {{ path = [[0, 0.03, 0.05, 0.055], [0.02, 0.03, 0.05, 0.055], [0.06, 0.03, 0.05, 0.0175], [0.065, 0.03, 0.05, 0.0175], [0.11, 0.06, 0.05, 0.0175]] }}
        [[tool]]
        name = "tip"
        device = "hand"
        radius = {radius}
        [[edit]]
        kind = "touch"
        tool = "tip"
        [[obstacle]]
        name = "ball"
        shape = {{ kind = "sphere", radius = 0.006 }}
        position = [0.07, 0.05, 0.055]
        path = [[0, 0, 0, 0], [0.02, 0, 0, 0], [0.06, 0, 0, -0.0165]]
        "#
    );
    let mut session = held_block(is_in_grid, &TetBox::new([14, 14, 5], BLOCK, 0.0, 1), &rest);
    let whole = session.snapshot();
    if is_broken {
        let holes = |x: Vec3| [0.03, 0.07].iter().any(|at| (x.x - at).abs() < 0.0175 && (x.y - 0.05).abs() < 0.0175);
        assert!(fail(&mut session, holes) > 50);
        (0..3).for_each(|_| session.step());
        assert!(session.events.count(EventKind::ElementsFailed) > 50);
    }
    if is_undone {
        session.restore(&whole).expect("goes back");
    }
    let mut most = [0.0_f64; 3];
    while session.time() < 0.11 {
        session.step();
        assert!(session.bodies[0].frozen.is_none(), "{:?}", session.bodies[0].frozen);
        let (tip, ball) = (session.frame().tools[0].force.norm(), session.obstacles()[0].force.norm());
        let phase = if session.time() < 0.063 { 0 } else { 2 };
        most[phase] = most[phase].max(tip);
        most[1] += 1e-3 * ball;
    }
    most
}

#[test]
fn contact_meets_what_has_come_to_light_and_nothing_that_is_gone() {
    for is_in_grid in [false, true] {
        // Smaller than a cell, which meets triangles, and larger, which meets samples.
        for radius in [0.003, 0.009] {
            let what = format!("grid {is_in_grid}, {radius} m");
            let [tip, ball, _] = crossed(is_in_grid, radius, false, false);
            assert!(tip > 1e-3 && ball > 1e-3, "{what}: a whole block is met: {tip} N and {ball} N s");
            let [tip_gone, ball_gone, aside] = crossed(is_in_grid, radius, true, false);
            assert_eq!([tip_gone, ball_gone], [0.0; 2], "{what}: nothing is left there");
            assert!(aside > 1e-3, "{what}: the side of the hole is met: {aside} N");
            let [again, ball_again, _] = crossed(is_in_grid, radius, true, true);
            let error = (again / tip - 1.0).abs().max((ball_again / ball - 1.0).abs());
            assert!(
                error < 0.05,
                "{what}: {again} N and {ball_again} N s after an undo, {tip} N and {ball} N s before"
            );
        }
    }
}

/// A block that is held at two ends and has failed across its middle, at whose broken side a tool makes an edit from 20 to 60 ms.
fn edited(is_in_grid: bool, edit: &str, seed: u64) -> Session {
    let rest = format!(
        r#"
        {WEIGHTLESS}
        [[device]]
        name = "hand"
        plugin = "scripted"
        params = {{ path = [[0, 0.03, 0.05, 0.055], [0.02, 0.03, 0.05, 0.055], [0.05, 0.036, 0.05, 0.04], [0.1, 0.036, 0.05, 0.055]] }}
        [[tool]]
        name = "tip"
        device = "hand"
        radius = 0.009
        [[edit]]
        {edit}
        tool = "tip"
        radius = 0.02
        start = 0.02
        end = 0.06
        "#
    );
    let rest = if edit.contains("touch") { rest.replace("radius = 0.02\n", "\n") } else { rest };
    let mesh = TetBox::new([14, 14, 5], BLOCK, 0.1, seed).shuffled(seed);
    let mut session = held_block(is_in_grid, &mesh, &rest);
    assert!(fail(&mut session, |x| (x.x - 0.05).abs() < 0.006) > 50);
    while session.time() < 0.09 {
        session.step();
        assert!(session.bodies[0].frozen.is_none(), "{edit}: {:?}", session.bodies[0].frozen);
    }
    session
}

/// What has failed stays so: an edit that keeps the shape would join its pieces, so the shape springs back and an event says why.
#[test]
fn the_shape_of_what_has_failed_is_not_kept() {
    for is_in_grid in [false, true] {
        let session = edited(is_in_grid, "kind = \"touch\"\nrelease = \"keep\"", 1);
        let body = &session.bodies[0];
        assert_eq!(session.events.count(EventKind::NotKept), 1, "grid {is_in_grid}");
        assert!(body.system.failed_count() > 50 && !body.failed_triangles.exposed().triangles().is_empty());
        assert_eq!(body.parts().iter().filter(|part| **part != pliant_mesh::NO_SHELL).max(), Some(&1));
    }
}

/// Edits of the shape at rest take faces along that have come to light.
#[test]
fn the_shape_at_rest_of_what_has_failed_can_be_edited() {
    for (kind, seed) in ["inflate", "grow", "smooth", "relax"].into_iter().zip(1..) {
        for is_in_grid in [false, true] {
            let mut session = edited(is_in_grid, &format!("kind = \"{kind}\""), seed);
            let (_, settled, triangles, _) = shown(&mut session);
            let body = &session.bodies[0];
            let what = format!("{kind}, grid {is_in_grid}");
            assert!(body.system.failed_count() > 50, "{what}");
            let exposed = body.failed_triangles.exposed();
            assert!(
                !exposed.triangles().is_empty()
                    && settled.iter().chain(&body.skin.x).all(|p| p.iter().all(|c| c.is_finite())),
                "{what}"
            );
            if !is_in_grid {
                let corners = triangles.iter().map(|t| t.map(|v| settled[v as usize]));
                assert!(
                    by_bits(corners) == by_bits(boundary_left(body).into_iter()),
                    "{what}: faces are at their nodes"
                );
            }
            // What is gone stays out of searches.
            for t in (0..body.model.surface.triangles.len() as u32).filter(|t| body.failed_triangles.contains(*t)) {
                let centre =
                    body.model.surface.triangles[t as usize].map(|v| settled[v as usize]).iter().sum::<Vec3>() / 3.0;
                body.skin.tree.near(centre, 1e-9, |found| assert_ne!(found, t, "{what}"));
            }
        }
    }
}
