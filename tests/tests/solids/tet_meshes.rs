//! Bodies of tetrahedra from files: against closed forms, against the same body in a grid, and as users meet them.

#![allow(clippy::print_stdout, reason = "the tables of errors")]

use nalgebra::Matrix3;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_mesh::testing::tetrahedra::{TetBox, TetFormat};
use pliant_mesh::{ObjDocument, TetMesh};
use pliant_tests::solid::{forces, hold, settle};
use pliant_tests::tetrahedral::{open, orders, run, scene};
use pliant_tests::{Bench, loaded_kinds, open_file, root};
use std::path::Path;

const SOLIDS: [&str; 2] = ["neo-hookean", "corotational"];
/// The box of `scenes/tet-beam.msh`, in mm.
const BEAM: ([u32; 3], [f64; 3]) = ([16, 4, 4], [160.0, 40.0, 40.0]);

/// A linear displacement of the boundary is linear inside too, on any mesh: forces on inner nodes vanish and they find their places, to rounding.
#[test]
fn patch_test() {
    let cases = (0..9).flat_map(|seed| SOLIDS.map(|name| (seed, name)));
    for (seed, name) in cases {
        let linear = TetBox::new([4, 3, 5], [0.04, 0.03, 0.05], 0.12, seed);
        let mesh = orders(&linear)[seed as usize % 3].shuffled(seed);
        let mut session = open(
            &mesh,
            &scene("dt = 1e-3\nduration = 1\nintegrator = \"backward-euler\"", name, "", "gravity = [0, 0, -1]"),
        );
        let system = &mut session.bodies[0].system;
        let mut random = Random(seed);
        let f = Matrix3::identity() + 0.15 * Matrix3::from_fn(|_, _| random.signed());
        let on_face = |p: Vec3| (0..3).any(|i| p[i] < 1e-9 || p[i] > mesh.size[i] - 1e-9);
        for i in 0..system.nodes.len() {
            system.nodes.x[i] = f * system.nodes.rest[i];
        }
        let all = forces(system);
        let most = |inner: bool| {
            let of = (0..all.len()).filter(|i| on_face(system.nodes.rest[*i]) != inner);
            of.map(|i| all[i].norm()).fold(0.0, f64::max)
        };
        assert!(most(true) < 1e-12 * most(false), "{name}, {seed}: {} N inside, {} N outside", most(true), most(false));
        hold(system, |p| on_face(p).then(|| f * p));
        let free: Vec<usize> = (0..system.nodes.len()).filter(|i| !on_face(system.nodes.rest[*i])).collect();
        free.iter().for_each(|i| system.nodes.x[*i] += 1e-3 * random.vector());
        settle(system, &[], 20);
        let off = |i: &usize| (system.nodes.x[*i] - f * system.nodes.rest[*i]).norm();
        let worst = free.iter().map(off).fold(0.0, f64::max);
        assert!(free.len() > 20 && worst < 1e-12, "{name}, {seed}: {worst} m");
    }
}

/// Sag of the end of a cantilever of length 8 and side 1 (times 5 mm) under its weight, over that of Timoshenko's beam.
fn sag(name: &str, n: u32, nu: f64, is_quadratic: bool) -> f64 {
    let (side, length, young, g) = (0.005, 0.04, 1e5, 0.1);
    let seed = u64::from(n);
    let linear = TetBox::new([8 * n, n, n], [length, side, side], 0.15, seed);
    let mesh = if is_quadratic { linear.quadratic() } else { linear }.shuffled(seed);
    let body = "[[body.fixed]]\ngroup = \"low end\"";
    let time =
        "dt = 1e-2\nduration = 0.1\nintegrator = \"quasi-static\"\npatience = \"300 s\"\n[solver]\ntolerance = 1e-9";
    let text = scene(time, name, body, &format!("gravity = [0, 0, -{g}]"));
    let mut session = open(&mesh, &text.replace("poisson = 0.3", &format!("poisson = {nu}")));
    run(&mut session, 4);
    assert_eq!(session.bodies[0].frozen, None);
    let nodes = &session.bodies[0].system.nodes;
    let end = || (0..nodes.len()).filter(|i| nodes.rest[*i][0] > length - 1e-9);
    let sag = -end().map(|i| nodes.x[i][2] - nodes.rest[i][2]).sum::<f64>() / end().count() as f64;
    let weight = 1000.0 * g * side * side;
    let (inertia, shear) =
        (side.powi(4) / 12.0, young / (2.0 * (1.0 + nu)) * side * side * 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu));
    sag / (weight * length.powi(4) / (8.0 * young * inertia) + weight * length * length / (2.0 * shear))
}

/// A cantilever under its own weight meets beam theory with the order of linear elements at a held end with corners (Timoshenko 1921; Cowper 1966).
#[test]
fn a_cantilever_converges_to_beam_theory() {
    for name in SOLIDS {
        let errors = [2, 4, 8].map(|n| 1.0 - sag(name, n, 0.3, false));
        let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
        println!("{name}: cantilever of tetrahedra too stiff by {errors:.4?}, orders {orders:.2?}");
        assert!(errors.iter().all(|e| *e > 0.0), "{name}: linear tetrahedra are never too soft: {errors:?}");
        assert!(errors[2] < 0.1 && orders[0] > 1.1 && orders[1] > 1.4, "{name}: {errors:?} {orders:?}");
    }
}

/// With quadratic tetrahedra the same cantilever is near beam theory with one element across, and far less stiff than linear ones with as many nodes where it
/// hardly changes its volume. Beam theory itself leaves out that the held end cannot contract.
#[test]
fn a_cantilever_of_quadratic_tetrahedra_bends_as_beam_theory_says() {
    for (name, nu, most) in [("neo-hookean", 0.3, 0.05), ("corotational", 0.3, 0.05), ("neo-hookean", 0.49, 0.2)] {
        let linear = [2, 4].map(|n| 1.0 - sag(name, n, nu, false));
        let quadratic = [1, 2].map(|n| 1.0 - sag(name, n, nu, true));
        println!("{name}, {nu}, equal nodes: too stiff by {linear:.4?} (linear), {quadratic:.4?} (quadratic)");
        assert!(quadratic[0] < most && (0.0..0.6 * quadratic[0]).contains(&quadratic[1]), "{name}: {quadratic:?}");
        assert!((0..2).all(|n| quadratic[n] < 0.2 * linear[n]), "{name}: {linear:?} {quadratic:?}");
    }
}

/// Mass is density times volume, and a free body falls with its weight as its momentum, without turning or straining.
#[test]
fn mass_and_momentum_are_those_of_the_volume() {
    for (seed, mesh) in (0..8).flat_map(|seed| orders(&TetBox::random(seed)).map(|mesh| (seed, mesh.shuffled(seed)))) {
        let mut session =
            open(&mesh, &scene("dt = 1e-3\nduration = 1", SOLIDS[seed as usize % 2], "", "gravity = [1, 2, -3]"));
        let volume = mesh.size.iter().product::<f64>() * f64::from(mesh.parts);
        let mass: f64 = session.bodies[0].system.nodes.mass.iter().sum();
        assert!((mass / (1000.0 * volume) - 1.0).abs() < 1e-12, "{seed}: {mass} kg");
        run(&mut session, 20);
        let nodes = &session.bodies[0].system.nodes;
        let momentum: Vec3 = (0..nodes.len()).map(|i| nodes.mass[i] * nodes.v[i]).sum();
        let expected = mass * 0.02 * Vec3::new(1.0, 2.0, -3.0);
        assert!((momentum - expected).norm() < 1e-9 * expected.norm(), "{seed}: {momentum} of {expected}");
        let fall = nodes.x[0] - nodes.rest[0];
        let same = (0..nodes.len()).all(|i| (nodes.x[i] - nodes.rest[i] - fall).norm() < 1e-9 * fall.norm());
        assert!(same && fall.norm() > 1e-4, "{seed}");
    }
}

/// Energy of a bar that is let go, without damping and with explicit steps, comes back: what elastic energy loses motion has.
#[test]
fn energy_is_kept() {
    for mesh in orders(&TetBox::new([6, 2, 2], [0.06, 0.02, 0.02], 0.12, 3)) {
        energy_is_kept_of(&mesh);
    }
}

fn energy_is_kept_of(mesh: &TetBox) {
    let time = "dt = 1e-5\nduration = 1\nintegrator = \"symplectic-euler\"";
    let body = "[[body.fixed]]\ngroup = \"low end\"";
    let mut session = open(mesh, &scene(time, "neo-hookean", body, "gravity = [0, 0, 0.001]\n[output]\nenergy = true"));
    let stretch = Matrix3::from_diagonal(&Vec3::new(1.02, 0.99, 1.0));
    let nodes = &mut session.bodies[0].system.nodes;
    for i in 0..nodes.len() {
        nodes.x[i] = stretch * nodes.rest[i];
    }
    let now = pliant_tests::NOW;
    let start = session.bodies[0].system.energy(now).unwrap();
    let (mut most_motion, mut worst) = (0.0_f64, 0.0_f64);
    for _ in 0..800 {
        run(&mut session, 1);
        let system = &mut session.bodies[0].system;
        let motion: f64 =
            (0..system.nodes.len()).map(|i| 0.5 * system.nodes.mass[i] * system.nodes.v[i].norm_squared()).sum();
        most_motion = most_motion.max(motion);
        worst = worst.max(((motion + system.energy(now).unwrap()) / start - 1.0).abs());
    }
    assert!(most_motion > 0.3 * start && worst < 0.05, "{most_motion} J of {start} J; {worst}");
}

/// The order of nodes and tetrahedra in the file changes results by rounding alone.
#[test]
fn results_do_not_depend_on_the_order_in_the_file() {
    for seed in 0..9 {
        let mesh = orders(&TetBox::random(100 + seed))[seed as usize % 3].clone();
        let text = scene(
            "dt = 1e-3\nduration = 1\n[solver]\ntolerance = 1e-10",
            SOLIDS[seed as usize % 2],
            "[[body.fixed]]\ngroup = \"low end\"",
            "gravity = [0, 0, -9.81]",
        );
        let places = |mesh: &TetBox| {
            let mut session = open(mesh, &text);
            run(&mut session, 30);
            let nodes = &session.bodies[0].system.nodes;
            let mut all: Vec<(Vec3, Vec3)> = nodes.rest.iter().copied().zip(nodes.x.iter().copied()).collect();
            all.sort_by(|a, b| a.0.as_slice().partial_cmp(b.0.as_slice()).unwrap());
            all
        };
        let (straight, shuffled) = (places(&mesh), places(&mesh.shuffled(seed)));
        let moved = straight.iter().map(|(rest, x)| (x - rest).norm()).fold(0.0, f64::max);
        for ((rest, x), (other, y)) in straight.iter().zip(&shuffled) {
            assert!(rest == other && (x - y).norm() < 1e-7 * moved, "{seed}: {x} {y}");
        }
        assert!(moved > 1e-5, "{seed}: {moved}");
    }
}

/// The same bar as a mesh of tetrahedra and in a grid, whose cells fit it: both are near beam theory, and near each other.
#[test]
fn a_mesh_and_a_grid_of_one_body_agree() {
    let [length, side] = [0.08, 0.01];
    let sag = |body: &str| {
        let bench = Bench::new();
        bench.write("box.msh", TetBox::new([64, 8, 8], [length, side, side], 0.1, 1).bytes(TetFormat::Msh4));
        let text = format!(
            "format = 1\ngravity = [0, 0, -0.1]\n[time]\ndt = 1e-2\nduration = 0.1\nintegrator = \"quasi-static\"\n[[body]]\n{body}\nmaterial = {{ plugin = \
             \"corotational\", params = {{ young = 1e5, poisson = 0.3, density = 1000 }} }}\n[[body.fixed]]\nbox = [[-0.041, -1, -1], [-0.03999, 1, 1]]\n"
        );
        let mut session = open_file(&bench.write("scene.toml", text), 1, None);
        run(&mut session, 4);
        let nodes = &session.bodies[0].system.nodes;
        let mass: f64 = nodes.mass.iter().sum();
        let end = || (0..nodes.len()).filter(|i| nodes.rest[*i][0] > 0.04 - 1e-9);
        (-end().map(|i| nodes.x[i][2] - nodes.rest[i][2]).sum::<f64>() / end().count() as f64, mass)
    };
    let mesh = sag("mesh = \"box.msh\"\nposition = [-0.04, -0.005, -0.005]");
    let grid = sag(&format!(
        "shape = {{ kind = \"box\", cells = 8, size = [{length}, {side}, {side}] }}\ngrid = {{ level = 7, region = \"whole\" }}"
    ));
    println!("sag and mass of the mesh {mesh:?}, of the grid {grid:?}");
    assert!((mesh.0 / grid.0 - 1.0).abs() < 0.15, "{mesh:?} {grid:?}");
}

/// The mesh of the shipped scene is the one that docs/scenes.md describes.
#[test]
fn the_mesh_of_the_shipped_scene_is_generated() {
    let made = TetBox::new(BEAM.0, BEAM.1, 0.12, 7).shuffled(7);
    let path = root().join("scenes/beam.msh");
    assert_eq!(std::fs::read(&path).expect("scenes/beam.msh"), made.bytes(TetFormat::Msh4));
}

/// A scene in which a hand presses on the top of the free end and lets go, at half a second undone.
fn pressed(more: &str) -> String {
    let hand = "[[device]]\nname = \"hand\"\nframe = { origin = [-0.01, 0.05, 0.02] }\nparams = { path = [[0, 0, 0, 0.01], [0.1, 0, 0, 0], [0.2, 0, 0, 0], [0.3, 0, 0, \
                0.02]] }\n[[tool]]\nname = \"finger\"\ndevice = \"hand\"\nradius = \"4 mm\"\n[[edit]]\ntool = \"finger\"\n";
    let text = scene(
        "dt = 2e-3\nduration = 0.6\nintegrator = \"backward-euler\"",
        "neo-hookean",
        "scale = 0.001\nrotation = { axis = [0, 0, 1], angle = \"90 deg\" }\n[[body.fixed]]\ngroup = \"low end\"",
        "",
    );
    text.replace("damping-time = 0 ", "damping-time = 0.01 ") + hand + more
}

#[test]
fn a_body_of_tetrahedra_is_touched_kept_undone_recorded_and_written() {
    // In mm, and along y in the scene.
    touch(&TetBox::new([12, 4, 4], [60.0, 20.0, 20.0], 0.12, 5).shuffled(5));
    let [_, straight, curved] = orders(&TetBox::new([6, 2, 2], [60.0, 20.0, 20.0], 0.12, 5));
    touch(&straight.shuffled(5));
    touch(&curved.shuffled(5));
}

/// Touches a mesh, keeps the dent, undoes it, replays a recording, and reads what was written.
fn touch(mesh: &TetBox) {
    let bench = Bench::new();
    bench.write("box.msh", mesh.bytes(TetFormat::Msh4Binary));
    let touch = "kind = \"touch\"\nend = 0.15\nrelease = \"keep\"\n";
    bench.write("kept.toml", pressed(touch));
    bench.write("undone.toml", pressed(&format!("{touch}[[edit]]\nkind = \"undo\"\nstart = 0.5\n")));
    let ran = bench
        .pliant(&[
            "run",
            "kept.toml",
            "-q",
            "--out",
            "kept",
            "--threads",
            "2",
            "--oversubscribe",
            "--record",
            "kept.rec",
        ])
        .expect(0);
    assert_eq!(ran.err, "", "no warning");
    bench.pliant(&["run", "kept.toml", "-q", "--out", "again", "--threads", "1"]).expect(0);
    bench.pliant(&["replay", "kept.rec", "-q", "--out", "replayed"]).expect(0);
    bench.pliant(&["run", "undone.toml", "-q", "--out", "undone"]).expect(0);
    for file in ["final.obj", "final.vtk"] {
        for other in ["again", "replayed"] {
            assert!(bench.read(&format!("kept/{file}")) == bench.read(&format!("{other}/{file}")), "{file} of {other}");
        }
    }
    let read = |folder: &str| {
        let vtk = TetMesh::parse(&bench.read(&format!("{folder}/final.vtk")), Path::new("final.vtk")).unwrap();
        let obj = ObjDocument::parse(bench.read(&format!("{folder}/final.obj")), Path::new("final.obj")).unwrap();
        let text = String::from_utf8(bench.read(&format!("{folder}/final.vtk"))).unwrap();
        let values = text.split("VECTORS displacement double\n").nth(1).unwrap().lines();
        let vector = |line: &str| {
            let all: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
            Vec3::new(all[0], all[1], all[2])
        };
        let moved: Vec<Vec3> = values.take(vtk.points.len()).map(vector).collect();
        (vtk, obj, moved)
    };
    let (vtk, obj, moved) = read("kept");
    let is_same = match mesh.quadratic.is_empty() {
        true => vtk.tetrahedra == mesh.tetrahedra && vtk.quadratic.is_empty(),
        false => vtk.quadratic == mesh.quadratic,
    };
    assert!(vtk.points == mesh.points && is_same, "the mesh of the file");
    // The surface is where the nodes are.
    for (vertex, node) in vtk.vertices().iter().map(|node| *node as usize).enumerate() {
        assert!((obj.positions()[vertex] - vtk.points[node] - moved[node]).norm() < 1e-10);
    }
    let depth = |moved: &[Vec3]| moved.iter().map(|u| u.norm()).fold(0.0, f64::max);
    assert!(depth(&moved) > 1.0, "a dent stays: {}", depth(&moved));
    assert!(depth(&read("undone").2) < 1e-2, "the undone shape is that of the file: {}", depth(&read("undone").2));
    let force = bench.summary("kept")["largest_force"].as_f64().unwrap();
    assert!((0.05..3.0).contains(&force), "{force} N");
    // A mesh goes through `final.vtk` into another scene.
    bench.write(
        "next.toml",
        pressed(touch)
            .replace("box.msh", "kept/final.vtk")
            .replace("group = \"low end\"", "box = [[-1, -1, -1], [1, 1e-9, 1]]"),
    );
    bench.pliant(&["run", "next.toml", "-q", "--out", "next"]).expect(0);
}

/// A mesh rests on a floor with its weight, and a ball larger than its edges is met with the force that a grid of the same body gives.
#[test]
fn floors_and_large_tools_meet_a_mesh_as_they_meet_a_grid() {
    meets_floors_and_tools(&TetBox::new([8, 4, 4], [0.08, 0.04, 0.04], 0.12, 4).shuffled(4));
    let [_, straight, _] = orders(&TetBox::new([4, 2, 2], [0.08, 0.04, 0.04], 0.12, 4));
    meets_floors_and_tools(&straight.shuffled(4));
}

fn meets_floors_and_tools(mesh: &TetBox) {
    let floor = "[[obstacle]]\nname = \"floor\"\nshape = { kind = \"plane\" }\n";
    let falling =
        scene("dt = 2e-3\nduration = 1", "neo-hookean", "position = [0, 0, 0.001]", "gravity = [0, 0, -9.81]");
    let mut session = open(mesh, &(falling.replace("damping-time = 0 ", "damping-time = 0.02 ") + floor));
    run(&mut session, 400);
    let nodes = &session.bodies[0].system.nodes;
    assert!(nodes.x.iter().all(|x| x.z > -1e-5), "nothing is below the floor");
    let speed = nodes.v.iter().map(|v| v.norm()).fold(0.0, f64::max);
    assert!(speed < 1e-3 && nodes.x.iter().any(|x| x.z < 1e-4), "it rests: {speed} m/s");
    let pressed = |body: &str| {
        let hand = "[[body.fixed]]\nbox = [[-1, -1, -1], [1, 1, 1e-6]]\n[[device]]\nname = \"hand\"\nframe = { origin = [0.04, 0.02, 0.04] }\nparams = { path = [[0, 0, 0, \
                    0.025], [0.2, 0, 0, 0.005], [0.4, 0, 0, 0.005]] }\n[[tool]]\nname = \"ball\"\ndevice = \"hand\"\nradius = \"15 mm\"\n[[edit]]\nkind = \
                    \"touch\"\ntool = \"ball\"\n";
        let text = scene("dt = 1e-3\nduration = 1", "neo-hookean", "", "").replace("mesh = \"box.msh\"", body);
        let mut session = open(mesh, &(text.replace("damping-time = 0 ", "damping-time = 0.01 ") + hand));
        run(&mut session, 350);
        session.frame().tools[0].force.norm()
    };
    let of_mesh = pressed("mesh = \"box.msh\"");
    let of_grid = pressed(
        "shape = { kind = \"box\", cells = 16, size = [0.08, 0.04, 0.04] }\nposition = [0.04, 0.02, 0.02]\ngrid = { level = 4, region = \"whole\" }",
    );
    println!("a ball of 15 mm meets {of_mesh} N of the mesh, {of_grid} N of the grid");
    assert!((of_mesh / of_grid - 1.0).abs() < 0.25 && of_grid > 0.1, "{of_mesh} N, {of_grid} N");
}

/// Every edit that is not refused acts on a mesh, and no other edit freezes it.
#[test]
fn every_edit_acts_on_a_mesh() {
    every_edit_acts_on(&TetBox::new([8, 4, 4], [0.08, 0.04, 0.04], 0.12, 6).shuffled(6));
    let [_, _, curved] = orders(&TetBox::new([4, 2, 2], [0.08, 0.04, 0.04], 0.12, 6));
    every_edit_acts_on(&curved.shuffled(6));
}

fn every_edit_acts_on(mesh: &TetBox) {
    let shapes = ["touch", "pull", "grab", "inflate", "flatten", "pinch", "relax", "grow", "smooth"];
    for kind in shapes.into_iter().chain(["pin", "paint"]) {
        let hand = format!(
            "[[device]]\nname = \"hand\"\nframe = {{ origin = [0.04, 0.02, 0.04] }}\nparams = {{ path = [[0, 0, 0, 0.02], [0.1, 0, 0, 0.002], [0.2, 0, 0.004, 0.001], [0.3, 0, \
             0.004, 0.001]] }}\n[[tool]]\nname = \"tip\"\ndevice = \"hand\"\nradius = \"5 mm\"\n[[edit]]\nkind = \"{kind}\"\ntool = \"tip\"\nrelease = \"keep\"\nend = 0.3\n"
        );
        let body = "[[body.fixed]]\ngroup = \"low end\"";
        let text = scene("dt = 2e-3\nduration = 1\nintegrator = \"backward-euler\"", "neo-hookean", body, "");
        let mut session = open(mesh, &(text.replace("damping-time = 0 ", "damping-time = 0.01 ") + &hand));
        let before = session.bodies[0].skin.settled.clone();
        run(&mut session, 250);
        let body = &session.bodies[0];
        assert_eq!(body.frozen, None, "{kind}");
        let moved = body.skin.settled.iter().zip(before.iter()).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let lattice = body.discretization.lattice().expect("a solid");
        match kind {
            "pin" => assert!(lattice.pinned_points().count() > 0, "{kind}"),
            "paint" => assert!(!lattice.painted().is_empty(), "{kind}"),
            _ => assert!(moved > 1e-5 && moved < 0.05, "{kind}: {moved} m"),
        }
        let least = lattice
            .region()
            .cell_corners
            .iter()
            .map(|c| TetMesh::six_volumes(&body.system.nodes.rest, [c[0], c[1], c[2], c[3]]));
        assert!(least.fold(f64::INFINITY, f64::min) > 0.0, "{kind}: no tetrahedron at rest is inverted");
    }
}

/// Groups and numbers of the file select nodes and tetrahedra.
#[test]
fn groups_and_numbers_of_the_file_select_its_parts() {
    for mesh in orders(&TetBox::new([4, 2, 2], [0.04, 0.02, 0.02], 0.1, 2)) {
        parts_are_selected(&mesh.shuffled(9));
    }
}

fn parts_are_selected(mesh: &TetBox) {
    let low: Vec<usize> = (0..mesh.points.len()).filter(|node| mesh.points[*node].x == 0.0).collect();
    let numbers: Vec<String> = low.iter().map(|node| (node + 1).to_string()).collect();
    let time = "dt = 1e-3\nduration = 1";
    let held = |fixed: &str| {
        let session =
            open(mesh, &scene(time, "neo-hookean", &format!("[[body.fixed]]\n{fixed}"), "gravity = [0, 0, -1]"));
        let nodes = &session.bodies[0].system.nodes;
        (0..nodes.len()).filter(|node| !nodes.constraint[*node].is_free()).collect::<Vec<_>>()
    };
    assert_eq!(held("group = \"low end\""), low);
    assert_eq!(held(&format!("nodes = [{}]", numbers.join(", "))), low);
    assert_eq!(held("group = \"body\"").len(), mesh.points.len());
    let mass = |field: &str| {
        let session = open(
            mesh,
            &scene(
                time,
                "neo-hookean",
                &format!("[[body.field]]\nparam = \"density\"\n{field}"),
                "gravity = [0, 0, -1]",
            ),
        );
        session.bodies[0].system.nodes.mass.iter().sum::<f64>() / (1000.0 * mesh.size.iter().product::<f64>())
    };
    assert!((mass("group = \"body\"\nfactor = 3") - 3.0).abs() < 1e-12);
    // Half of the box, up to one cell.
    let half = mass("box = [[-1, -1, -1], [0.02, 1, 1]]\nfactor = 3");
    // A node's mass is that of its shares of the tetrahedra, whose densities are those at their middles.
    let factor = |x: f64| if x < 0.02 { 3.0 } else { 1.0 };
    let middle = |nodes: &[u32; 4]| nodes.iter().map(|node| mesh.points[*node as usize].x).sum::<f64>() / 4.0;
    let linear = |t: &[u32; 4]| (TetMesh::six_volumes(&mesh.points, *t) / 6.0, factor(middle(t)));
    // The parts of a quadratic tetrahedron at its corners have a quarter of its mass each.
    let quadratic = |nodes: &[u32; 10]| {
        let [a, b, c, d, ab, bc, ac, ad, bd, cd] = *nodes;
        let parts = [[a, ab, ac, ad], [b, ab, bc, bd], [c, ac, bc, cd], [d, ad, bd, cd]];
        let mean = parts.iter().map(|part| factor(middle(part))).sum::<f64>() / 4.0;
        (TetMesh::quadratic_volume(&mesh.points, nodes), mean)
    };
    let all: Vec<(f64, f64)> = match mesh.quadratic.is_empty() {
        true => mesh.tetrahedra.iter().map(linear).collect(),
        false => mesh.quadratic.iter().map(quadratic).collect(),
    };
    let exact = all.iter().map(|(v, factor)| v * factor).sum::<f64>() / all.iter().map(|(v, _)| v).sum::<f64>();
    assert!((half / exact - 1.0).abs() < 1e-12, "{half}, exact {exact}");
    let ends = mass("group = \"low end\"\nfactor = 3");
    assert!(1.05 < ends && ends < 2.0, "material nearest to the faces: {ends}");
}

/// What does not work on tetrahedra is refused, with the line and what is allowed.
#[test]
fn what_does_not_work_on_tetrahedra_is_refused() {
    let bench = Bench::new();
    let mesh = TetBox::new([2, 2, 2], [0.04, 0.02, 0.02], 0.1, 2);
    bench.write("box.msh", mesh.bytes(TetFormat::Msh2));
    bench.write("box.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    bench.write("broken.vtk", &mesh.bytes(TetFormat::Vtk)[..200]);
    let knife = "[[device]]\nname = \"hand\"\n[[tool]]\nname = \"knife\"\ndevice = \"hand\"\nradius = 0.001\nblade = { length = 0.1 }\n[[edit]]\ntool = \"knife\"\nkind = ";
    let body = |more: &str| scene("duration = 0.01", "neo-hookean", more, "gravity = [0, 0, -1]");
    let cases = [
        (body("sheet = {}"), "`sheet` of body `body`, a tetrahedral mesh (box.msh)"),
        (body("subdivide = 1"), "`subdivide` of body `body`, a tetrahedral mesh (box.msh): refine the mesh"),
        (
            body("[body.grid]\nregion = \"local\""),
            "`grid` of body `body`, a tetrahedral mesh (box.msh): it is simulated as it is",
        ),
        (body("[[body.stitch]]\npairs = [[0, 1]]"), "`stitch` of body `body`"),
        (body("") + knife + "\"cut\"\n", "edit kind `cut` where body `body` is a tetrahedral mesh"),
        (body("") + knife + "\"stitch\"\n", "edit kind `stitch` where body `body` is a tetrahedral mesh"),
        (
            body("") + "[[obstacle]]\nname = \"wall\"\nmesh = \"box.msh\"\n",
            "obstacle `wall` of a tetrahedral mesh; allowed is an OBJ file",
        ),
        (
            body("[[body.fixed]]\ngroup = \"wall\""),
            "no group `wall` in the model; allowed is `low end` (faces), `high end` (faces), `body` (tetrahedra)",
        ),
        (body("[[body.fixed]]\nnodes = [1, 28]"), "no tetrahedron of"),
        (
            body("[[body.fixed]]\ncolour = \"red\""),
            "`fixed` of body `body` has `colour`, and a tetrahedral mesh has neither colours nor texture coordinates; allowed is",
        ),
        (body("[[body.fixed]]\ntexture = \"pins.png\""), "`fixed` of body `body` has `texture`"),
        (
            body("").replace("neo-hookean", "mass-spring").replace("poisson = 0.3, ", ""),
            "material `mass-spring` wants links, which a tetrahedral mesh does not give",
        ),
        (body("").replace("box.msh", "broken.vtk"), "broken.vtk:"),
        (body("").replace("box.msh", "none.msh"), "no file"),
    ];
    for (text, expected) in cases {
        bench.write("scene.toml", text);
        for verb in ["plan", "run"] {
            bench.pliant(&[verb, "scene.toml"]).expect(2).says(&[expected]);
        }
    }
    bench.write("scene.toml", body(""));
    let wrong = bench.pliant(&["run", "scene.toml", "--mesh", "box.obj"]).expect(2);
    wrong.says(&["box.obj", "in the place of that of body `body`; allowed is a tetrahedral mesh (.msh, .vtk or .vtu)"]);
    for (file, nodes) in [(None, 4), (Some(mesh.quadratic().bytes(TetFormat::Msh2Binary)), 10)] {
        file.into_iter().for_each(|bytes| drop(bench.write("box.msh", bytes)));
        let plan = bench.pliant(&["plan", "scene.toml", "--json"]).expect(0).json();
        let body = &plan["bodies"][0];
        assert_eq!((&body["tetrahedra"], &body["nodes_of_tetrahedron"]), (&48.into(), &nodes.into()), "{plan}");
        let kinds = loaded_kinds(&plan);
        assert!(kinds.iter().all(|kind| kind != "grid"), "no grid plugin is opened: {plan}");
        let left_out = plan["left_out"].as_array().expect("a list");
        assert!(left_out.iter().any(|part| part["what"] == "grid of body `body`"), "{plan}");
    }
    // What may surprise is told with a code.
    let mut turned = mesh.clone();
    turned.tetrahedra[3].swap(0, 1);
    bench.write("box.msh", turned.bytes(TetFormat::Msh2));
    bench
        .pliant(&["plan", "scene.toml"])
        .expect(0)
        .says(&["doubtful-mesh", "1 of 48 tetrahedra list their nodes the other way around"]);
}
