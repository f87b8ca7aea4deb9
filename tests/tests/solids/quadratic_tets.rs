//! Bodies of quadratic tetrahedra: against closed forms, and beside linear ones.

#![allow(clippy::print_stdout, reason = "the tables of errors")]

use nalgebra::Matrix3;
use pliant_mesh::geometry::Vec3;
use pliant_mesh::testing::Random;
use pliant_mesh::testing::tetrahedra::{TetBox, TetFormat};
use pliant_solver::{HessianApproximation, Pool, System, SystemScales};
use pliant_tests::solid::{forces, hold, settle};
use pliant_tests::tetrahedral::{open, orders, run, scene};
use pliant_tests::{Bench, NOW};

const SOLIDS: [&str; 2] = ["neo-hookean", "corotational"];
const IMPLICIT: &str = "dt = 1e-3\nduration = 1\nintegrator = \"backward-euler\"";
/// Of a bar along x: its length and its side, m.
const BAR: [f64; 2] = [0.04, 0.01];

/// A bar of `n` cubes across, each cut into six.
fn bar(n: u32) -> TetBox {
    TetBox::new([4 * n, n, n], [BAR[0], BAR[1], BAR[1]], 0.1, 3)
}

/// Displacements of a state in which nothing is special: a turn, a strain, and something at random.
fn deform(system: &mut System, seed: u64) {
    let mut random = Random(seed);
    let f = Matrix3::identity() + 0.2 * Matrix3::from_fn(|_, _| random.signed());
    let length = system.nodes.rest.iter().map(|x| x.norm()).fold(0.0, f64::max);
    for i in 0..system.nodes.len() {
        system.nodes.x[i] = f * system.nodes.rest[i] + 0.01 * length * random.vector();
        system.nodes.v[i] = random.vector();
    }
}

/// Forces are the slopes of the energy, the matrix is that of the forces, and inner forces have neither a sum nor a torque.
#[test]
fn forces_and_stiffness_are_derivatives_of_the_energy() {
    for (seed, name) in (0..2).flat_map(|seed| SOLIDS.map(|name| (seed, name))) {
        for mesh in &orders(&TetBox::new([2, 2, 2], [0.03, 0.02, 0.04], 0.1, seed))[1..] {
            let text = scene(IMPLICIT, name, "", "gravity = [0, 0, -1]");
            // Where elements are inverted the default matrix is another one, made positive.
            let text = text.replace("damping-time = 0 ", "damping-time = 0, tangent = \"exact\" ");
            let system = &mut open(&mesh.shuffled(seed), &text).bodies[0].system;
            deform(system, seed);
            let mut random = Random(seed + 10);
            let way: Vec<Vec3> = (0..system.nodes.len()).map(|_| random.vector()).collect();
            let start = system.nodes.x.clone();
            let step = 1e-6 * BAR[1];
            let mut at = |by: f64| {
                for i in 0..way.len() {
                    system.nodes.x[i] = start[i] + by * way[i];
                }
                (system.energy(NOW).unwrap(), forces(system))
            };
            let [(low, before), (_, now), (high, after)] = [-step, 0.0, step].map(&mut at);
            let dot = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
            let slope = (high - low) / (2.0 * step);
            let size = dot(&now, &now).sqrt();
            assert!((slope + dot(&now, &way)).abs() < 1e-6 * size * dot(&way, &way).sqrt(), "{name}, {seed}");
            let sum: Vec3 = now.iter().sum();
            let torque: Vec3 = now.iter().zip(&start).map(|(f, x)| x.cross(f)).sum();
            assert!(sum.norm() < 1e-11 * size && torque.norm() < 1e-11 * size, "{name}, {seed}: {sum} {torque}");
            at(0.0);
            let (pool, mut matrix) = (Pool::new(1), system.matrix.take().unwrap());
            // In single precision diagonal blocks are the negative sums of the others.
            for allow_f32 in [false, true] {
                matrix.assemble(&pool, system.state(NOW), None, stiffness(allow_f32)).unwrap();
                let mut product = vec![Vec3::zeros(); way.len()];
                matrix.product(&pool, &way, &mut product);
                let scale = dot(&product, &product).sqrt();
                for i in 0..way.len() {
                    let off = (product[i] - (before[i] - after[i]) / (2.0 * step)).norm();
                    assert!(off < 1e-5 * scale, "{name}, {seed}, {allow_f32}, node {i}: {off} of {scale}");
                }
            }
        }
    }
}

/// Stiffness alone, in single precision if `allow_f32` and the material offers it.
fn stiffness(allow_f32: bool) -> SystemScales {
    SystemScales {
        mass: 0.0,
        stiffness: 1.0,
        damping: 0.0,
        hessian: HessianApproximation::UpperBound,
        strains_are_current: false,
        allow_f32,
    }
}

/// Forces, energies and matrices of a mesh of many chunks have the same bytes with any number of threads.
#[test]
fn bytes_do_not_depend_on_threads() {
    let mesh = TetBox::new([10, 5, 5], [0.1, 0.05, 0.05], 0.1, 4).quadratic();
    for mesh in [mesh.curved(0.002, 4), mesh.shuffled(4)] {
        let system = &mut open(&mesh, &scene(IMPLICIT, "neo-hookean", "", "gravity = [0, 0, -1]")).bodies[0].system;
        deform(system, 4);
        let mut matrix = system.matrix.take().unwrap();
        let way = system.nodes.v.clone();
        let [one, three] = [1, 3].map(|threads| {
            let pool = Pool::new(threads);
            let (mut force, mut products) = (vec![Vec3::zeros(); way.len()], Vec::new());
            system.forces(&pool, None, NOW, &mut force).unwrap();
            for allow_f32 in [false, true] {
                matrix.assemble(&pool, system.state(NOW), None, stiffness(allow_f32)).unwrap();
                let mut product = vec![Vec3::zeros(); way.len()];
                matrix.product(&pool, &way, &mut product);
                products.extend(product);
            }
            force.extend(products);
            force.iter().flat_map(|v| [v.x, v.y, v.z].map(f64::to_bits)).collect::<Vec<_>>()
        });
        assert!(one.iter().any(|bits| *bits != 0) && one == three);
    }
}

/// Bending with a curvature so small that geometry is linear: its displacement is quadratic, and quadratic elements have it exactly on any mesh with straight edges, with its
/// stresses, which hold themselves in equilibrium without forces at the sides. Linear ones are far too stiff.
#[test]
fn pure_bending_is_exact() {
    let (nu, curvature) = (0.3, 1e-6);
    let bent = |p: Vec3| {
        let q = p - Vec3::new(0.0, 0.5 * BAR[1], 0.5 * BAR[1]);
        let across = 0.5 * (q.x * q.x + nu * (q.z * q.z - q.y * q.y));
        p + curvature * Vec3::new(-q.x * q.z, nu * q.y * q.z, across)
    };
    let is_end = |p: Vec3| p.x < 1e-9 || p.x > BAR[0] - 1e-9;
    let moment = 1e5 * BAR[1].powi(4) / 12.0 * curvature;
    for name in SOLIDS {
        let [linear, straight, _] = orders(&bar(2));
        let [linear, quadratic] = [linear, straight].map(|mesh| {
            let text = scene(IMPLICIT, name, "", "gravity = [0, 0, -1]");
            let system = &mut open(&mesh.shuffled(2), &text).bodies[0].system;
            hold(system, |p| is_end(p).then(|| bent(p)));
            settle(system, &[], 6);
            let off = (0..system.nodes.len()).map(|i| (system.nodes.x[i] - bent(system.nodes.rest[i])).norm());
            let off = off.fold(0.0, f64::max) / (curvature * BAR[0] * BAR[0]);
            let (all, rest) = (forces(system), &system.nodes.rest);
            let held = (0..all.len()).filter(|i| rest[*i].x > BAR[0] - 1e-9);
            (off, held.map(|i| (rest[i].z - 0.5 * BAR[1]) * all[i].x).sum::<f64>() / moment - 1.0)
        });
        println!("{name}: pure bending: off by {linear:?} (linear), {quadratic:?} (quadratic): position, moment");
        // Geometry is linear up to the strain, 1e-8, and solves have a tolerance of 1e-10 of forces that bend nothing.
        assert!(quadratic.0 < 1e-5 && quadratic.1.abs() < 1e-5, "{name}: {quadratic:?}");
        assert!(linear.1 > 0.2, "{name}: {linear:?}");
    }
}

/// A block between plates that it sticks to, nearly incompressible, is pressed: linear elements lock.
#[test]
fn a_nearly_incompressible_block_locks_less() {
    let force = |mesh: &TetBox| {
        let text =
            scene(IMPLICIT, "neo-hookean", "", "gravity = [0, 0, -1]").replace("poisson = 0.3", "poisson = 0.49");
        let system = &mut open(mesh, &text).bodies[0].system;
        let top = |p: Vec3| p.z > 0.02 - 1e-9;
        hold(system, |p| if top(p) { Some(p - Vec3::z() * 2e-6) } else { (p.z < 1e-9).then_some(p) });
        settle(system, &[], 4);
        let all = forces(system);
        (0..all.len()).filter(|i| top(system.nodes.rest[*i])).map(|i| all[i].z).sum::<f64>()
    };
    let block = |n: u32| TetBox::new([2 * n, 2 * n, n], [0.04, 0.04, 0.02], 0.1, 5);
    let reference = force(&block(6).quadratic());
    let [linear, quadratic] = [block(4), block(2).quadratic()].map(|mesh| force(&mesh) / reference - 1.0);
    println!("a block at 0.49 with equal nodes is too stiff by {linear:.4} (linear), {quadratic:.4} (quadratic)");
    assert!(linear > 0.3 && quadratic < 0.2 * linear, "{linear} {quadratic}");
}

/// Mass of a body is density times volume, each node has a part of it, and the first frequency of a bar along its length is that of a rod.
#[test]
fn mass_is_exact_and_positive_and_a_bar_rings_as_a_rod() {
    for (seed, mesh) in (0..6).flat_map(|seed| orders(&TetBox::random(seed)).map(|mesh| (seed, mesh))) {
        let session = open(&mesh.shuffled(seed), &scene(IMPLICIT, "neo-hookean", "", "gravity = [0, 0, -1]"));
        let nodes = &session.bodies[0].system.nodes;
        let exact = 1000.0 * mesh.size.iter().product::<f64>() * f64::from(mesh.parts);
        assert!((nodes.mass.iter().sum::<f64>() / exact - 1.0).abs() < 1e-12 && nodes.mass.iter().all(|m| *m > 0.0));
    }
    let frequency = |mesh: &TetBox| {
        let text = scene(IMPLICIT, "corotational", "", "gravity = [0, 0, -1]").replace("poisson = 0.3", "poisson = 0");
        let system = &mut open(mesh, &text).bodies[0].system;
        hold(system, |p| (p.x < 1e-9).then_some(p));
        let quarter = std::f64::consts::FRAC_PI_2 / BAR[0];
        // One step of inverse iteration from the wave of a rod, and Rayleigh's quotient.
        let wave: Vec<Vec3> = system.nodes.rest.iter().map(|p| Vec3::x() * (quarter * p.x).sin()).collect();
        let loads: Vec<Vec3> = wave.iter().zip(&system.nodes.mass).map(|(u, m)| 1e-3 * *m * u).collect();
        settle(system, &loads, 5);
        let nodes = &system.nodes;
        let u: Vec<Vec3> = (0..nodes.len()).map(|i| nodes.x[i] - nodes.rest[i]).collect();
        let work: f64 = loads.iter().zip(&u).map(|(f, u)| f.dot(u)).sum();
        let inertia: f64 = u.iter().zip(&nodes.mass).map(|(u, m)| m * u.norm_squared()).sum();
        (work / inertia).sqrt() / (quarter * (1e5_f64 / 1000.0).sqrt())
    };
    let linear = [1, 2, 4].map(|n| frequency(&bar(n)) - 1.0);
    let quadratic = [1, 2, 4].map(|n| frequency(&bar(n).quadratic()) - 1.0);
    println!(
        "first frequency of a bar with 1, 2, 4 elements across: off by {linear:?} (linear), {quadratic:?} (quadratic)"
    );
    // The scaled masses are of order four, so the coarsest bar is worse than a linear one and all others are better.
    assert!(
        quadratic[1].abs() < quadratic[0].abs() / 8.0 && quadratic[2].abs() < quadratic[1].abs() / 8.0,
        "{quadratic:?}"
    );
    assert!(quadratic[1].abs() < 0.5 * linear[1].abs() && quadratic[2].abs() < 0.25 * linear[2].abs());
}

/// Plastic flow has a history at each point of an element, which an undo and a new start of the region bring back; fibres have directions there.
#[test]
fn histories_and_fibres_are_at_the_points_of_elements() {
    let mesh = bar(2).quadratic().shuffled(1);
    let pulled = |material: &str, params: &str, body: &str| {
        let body = format!(
            "{body}\n[[body.fixed]]\ngroup = \"low end\"\n[[body.fixed]]\ngroup = \"high end\"\npath = [[0, 0, 0, 0], [0.05, 0.008, 0, 0], [0.1, 0.008, 0, 0]]"
        );
        let text = scene("dt = 2e-3\nduration = 1\nintegrator = \"backward-euler\"", material, &body, "");
        let mut session = open(&mesh, &text.replace("damping-time = 0 ", params));
        run(&mut session, 50);
        assert_eq!(session.bodies[0].frozen, None);
        session
    };
    let mut plastic = pulled("neo-hookean", "damping-time = 0.01, yield-strain = 0.05 ", "");
    let set = plastic.bodies[0].system.sets.iter().find(|set| !set.history().is_empty()).unwrap();
    assert_eq!(set.count(), 4 * mesh.quadratic.len());
    let flowed = set.history().iter().filter(|value| value.abs() > 1e-3).count();
    assert!(flowed > set.count(), "{flowed} of {}", set.history().len());
    let history = set.history().to_vec();
    let elements: Vec<u32> = set.nodes().to_vec();
    let saved = plastic.bodies[0].save();
    run(&mut plastic, 20);
    plastic.bodies[0].restore(&saved).unwrap();
    let set = plastic.bodies[0].system.sets.iter().find(|set| !set.history().is_empty()).unwrap();
    assert!(set.history() == history && set.nodes() == elements, "histories are those of the state");
    let force = |fibre: &str| {
        let params = "damping-time = 0.01, fibre-stiffness = 1e5 ";
        let mut session = pulled("fibre-reinforced", params, fibre);
        let all = forces(&mut session.bodies[0].system);
        let rest = &session.bodies[0].system.nodes.rest;
        -(0..all.len()).filter(|i| rest[*i].x > BAR[0] - 1e-9).map(|i| all[i].x).sum::<f64>()
    };
    let [along, across] = [[1, 0, 0], [0, 0, 1]].map(|way| force(&format!("[[body.fibre]]\ndirection = {way:?}")));
    assert!(across > 0.0 && along > 2.0 * across, "fibres carry along themselves: {along} N, {across} N");
}

/// A material whose elements can fail or that wants whole lists is refused where it is named, with the remedy, for straight and curved elements; linear ones of the same
/// mesh are simulated.
#[test]
fn materials_that_quadratic_tetrahedra_cannot_serve_are_refused() {
    let linear = bar(1);
    let materials = [("quasi-brittle", "can fail"), ("faulty-plugins#sound-listed-fibres", "wants whole lists")];
    for (plugin, why) in materials {
        for (mesh, is_refused) in [(linear.clone(), false), (linear.clone().quadratic(), true)] {
            let bench = Bench::new();
            bench.write("bar.vtk", mesh.bytes(TetFormat::Vtk));
            let scene = format!(
                "format = 1\ngravity = [0, 0, -9.81]\n[time]\ndt = 1e-3\nduration = 2e-3\nintegrator = \"backward-euler\"\n[[body]]\nname = \"bar\"\n\
                 mesh = \"bar.vtk\"\nmaterial = {{ plugin = \"{plugin}\" }}\n"
            );
            bench.write("scene.toml", scene);
            let ran = bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(if is_refused { 2 } else { 0 });
            if is_refused {
                let id = plugin.rsplit('#').next().unwrap();
                let named = format!("`{id}` of body `bar` {why}");
                let nodes = "quadratic tetrahedra of 10 nodes";
                ran.says(&["scene.toml:10:23", &named, nodes, "allowed are tetrahedra of 4 nodes"]);
            }
        }
    }
}
