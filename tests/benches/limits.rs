//! How far the hot loops are from what the machine can do: a triad, a loop of fused multiply-adds, and beside them the products of
//! a cloth's matrix, its assembly, and lattices on one thread and two: `cargo build --release && cargo bench -p pliant-tests --bench limits`.
#![allow(clippy::print_stdout, reason = "a bench prints its figures")]

use pliant_host::{Material, ParamValue};
use pliant_mesh::geometry::Vec3;
use pliant_plugin_api::{abi, kit};
use pliant_solver::{
    F32Matrix, HessianApproximation, Integrator, Loads, Matrix, Nodes, Pool, Scheme, StepTime, System, SystemScales,
};
use pliant_tests::{NOW, library, open};
use pulp::{Simd, WithSimd};
use std::hint::black_box;
use std::time::Instant;

/// Numbers of a triad that no cache holds.
const LONG: usize = 1 << 23;

fn main() {
    println!("one core: {:.1} GFLOP/s of fused multiply-adds in double precision", 1e-9 * peak());
    for n in [1 << 14, 1 << 16, 1 << 18, LONG] {
        println!("triad of 3 x {:8.3} MB: {:6.1} GB/s", n as f64 * 8e-6, triad(&Pool::new(1), n));
    }
    [32, 64, 128].into_iter().for_each(cloth);
    for pool in [1, 2].map(Pool::new) {
        // Right before, for what memory gives changes by the minute where others use it too.
        [15, 31, 63].into_iter().for_each(|cells| lattice(&pool, cells, triad(&pool, LONG)));
    }
}

/// The least of `times` runs, s.
fn least(times: usize, mut run: impl FnMut()) -> f64 {
    let once = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..times).map(once).fold(f64::INFINITY, f64::min)
}

/// `a = b + s c` of `n` numbers, GB/s.
fn triad(pool: &Pool, n: usize) -> f64 {
    let (mut a, b, c) = (vec![0.0; n], vec![1.0; n], vec![2.0; n]);
    let seconds = least(1 + (1 << 25) / n, || {
        pool.install(|| {
            pool.par_chunks(&mut a[..], 1, &|first, a: &mut [f64]| {
                let (b, c) = (&b[first..], &c[first..]);
                pulp::Arch::new().dispatch(|| a.iter_mut().zip(b).zip(c).for_each(|((a, b), c)| *a = b + 3.0 * c));
            });
        });
        black_box(&mut a);
    });
    24e-9 * n as f64 / seconds
}

/// Chains that do not wait for each other; gives the operations done.
struct MultiplyAdds;

impl WithSimd for MultiplyAdds {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        const CHAINS: usize = 12;
        const ROUNDS: usize = 100_000;
        let (a, b) = (simd.splat_f64s(black_box(0.999)), simd.splat_f64s(black_box(1e-3)));
        let mut sums = [simd.splat_f64s(black_box(1.0)); CHAINS];
        for _ in 0..ROUNDS {
            for c in 0..CHAINS {
                sums[c] = simd.mul_add_f64s(sums[c], a, b);
            }
        }
        black_box(sums);
        (2 * CHAINS * ROUNDS * S::F64_LANES) as f64
    }
}

/// Operations in double precision a second, fused multiply-adds alone.
fn peak() -> f64 {
    let mut operations = 0.0;
    let seconds = least(20, || operations = pulp::Arch::new().dispatch(MultiplyAdds));
    operations / seconds
}

/// One line: what is done at which rates.
fn line(what: &str, seconds: f64, bytes: f64, flops: f64) {
    println!(
        "{what:52} {:9.1} us, {:8.3} MB {:6.1} GB/s, {:7.3} MFLOP {:6.2} GFLOP/s",
        1e6 * seconds,
        1e-6 * bytes,
        1e-9 * bytes / seconds,
        1e-6 * flops,
        1e-9 * flops / seconds
    );
}

/// Products and assembly of a hanging cloth of `n` vertices a side.
fn cloth(n: usize) {
    let cells = n - 1;
    let mut session = open(
        &format!(
            r#"
            format = 1
            gravity = [0, -9.81, 0]
            [time]
            integrator = "backward-euler"
            [[body]]
            shape = {{ kind = "sheet", cells = {cells}, rows = {cells}, pattern = "alternating", size = [0.2, 0.2, 0] }}
            sheet = {{ warp = [1, 0, 0] }}
            material = {{ plugin = "cloth", params = {{ density = 0.15, young-warp = 500, poisson = 0.3, bending-warp = 10e-6 }} }}
            [[body.fixed]]
            box = [[-1, 0.19999, -1], [1, 1, 1]]
            "#
        ),
        1,
    );
    (0..5).for_each(|_| session.step());
    let (pool, system) = (Pool::new(1), &mut session.bodies[0].system);
    let mut matrix = system.matrix.take().unwrap();
    let (rows, blocks) = (matrix.rows() as f64, matrix.blocks() as f64);
    let off = 2.0 * (blocks - rows);
    let x: Vec<Vec3> = (0..matrix.rows()).map(|i| Vec3::new((i as f64).sin(), (2.0 * i as f64).cos(), 1.0)).collect();
    let mut out = x.clone();
    let seconds = least(200, || matrix.product(&pool, &x, black_box(&mut out)));
    line(&format!("cloth {n}: product"), seconds, matrix.bytes() as f64 + 48.0 * rows, 18.0 * (off + rows));
    let mut single = F32Matrix::default();
    let seconds = least(50, || single.update(&pool, black_box(&matrix)));
    let bytes = (matrix.bytes() + single.bytes()) as f64;
    line(&format!("cloth {n}: its matrix in single precision"), seconds, bytes, 9.0 * (off + 2.0 * blocks));
    let sixteens = x.as_chunks::<16>().0.iter();
    let vectors = sixteens.map(|all| [0, 1, 2].map(|c| all.map(|x| x[c] as f32)));
    single.start();
    single.update_direction(&pool, &vectors.collect::<Vec<_>>(), 0.0, 0.0);
    let seconds = least(200, || {
        black_box(single.product(black_box(&pool)));
    });
    // What it has to read: each block once.
    let bytes = 36.0 * blocks + 24.0 * rows;
    let flops = 18.0 * (off + rows) + 3.0 * off + 6.0 * rows;
    line(&format!("cloth {n}: product in single precision"), seconds, bytes, flops);
    let mut force = out;
    let seconds = least(50, || system.forces(&pool, None, NOW, black_box(&mut force)).unwrap());
    let of_elements: f64 = system
        .sets
        .iter()
        .map(|set| {
            (set.count() * (4 * set.nodes().len() / set.count().max(1) + 8 * set.request().rest_stride as usize)) as f64
        })
        .sum();
    line(&format!("cloth {n}: forces (elements and nodes read once)"), seconds, of_elements + 96.0 * rows, 0.0);
    let exact = SystemScales {
        mass: 1.0,
        stiffness: 1e-6,
        damping: 1e-3,
        hessian: HessianApproximation::AtLeastHalf,
        strains_are_current: true,
        allow_f32: false,
    };
    for (how, allow_f32, block) in [("assembly", false, 72.0), ("assembly in single precision", true, 36.0)] {
        let factors = SystemScales { allow_f32, ..exact };
        let seconds = least(50, || assemble(&mut matrix, &pool, system, factors));
        let bytes = of_elements + 96.0 * rows + 2.0 * block * blocks;
        line(&format!("cloth {n}: {how} (and the matrix written)"), seconds, bytes, 0.0);
    }
    let seconds = least(50, || single.update(&pool, &matrix));
    line(&format!("cloth {n}: that taken over"), seconds, 72.0 * blocks, 0.0);
    let mut out = vec![Vec3::zeros(); x.len()];
    let seconds = least(200, || single.exact_products(&pool, &matrix, [black_box(&x)], [black_box(&mut out)]));
    line(&format!("cloth {n}: product of that, in double precision"), seconds, bytes, flops);
}

fn assemble(matrix: &mut Matrix, pool: &Pool, system: &mut System, factors: SystemScales) {
    let (state, coupled) = system.assembly_parts(NOW);
    matrix.assemble(pool, state, coupled, factors).unwrap();
}

/// A block of springs, `cells` a side, explicit and implicit; beside the explicit step what memory alone asks for.
fn lattice(pool: &Pool, cells: usize, memory: f64) {
    let library = library("mass-spring");
    let place = |key: &str| library.plugins()[0].params.iter().position(|p| p.key == key).unwrap();
    for scheme in [Scheme::SymplecticEuler, Scheme::BackwardEuler] {
        let settings =
            [("flexion", 0.125), ("damping-time", 1e-4)].map(|(key, v)| (place(key), ParamValue::Number(v))).to_vec();
        let material = Material::open(library, "mass-spring", &settings, 1e-4).unwrap();
        let mut system = System::new(Box::new(material));
        let block = kit::block([cells as u32; 3], 2.5e-3, abi::STRUCTURAL | abi::SHEAR | abi::FLEXION);
        system.nodes = Nodes::at_rest(block.rest.iter().copied().map(Vec3::from).collect());
        for set in &mut system.sets {
            let given = block.elements(set.request().kind);
            let list = set.list_mut();
            (list.nodes, list.family, list.measure) = (given.nodes, given.family, given.measure);
        }
        system.prepare().unwrap();
        if scheme.is_implicit() {
            system.enable_matrix();
        }
        for (i, v) in system.nodes.v.iter_mut().enumerate() {
            *v = Vec3::new(0.01 * (i as f64).sin(), 0.01 * (2.0 * i as f64).cos(), 0.0);
        }
        let mut integrator = Integrator::new(scheme, 1e-4, 1000);
        let n = system.nodes.len();
        integrator.resize(n);
        let dt = if scheme.is_implicit() { 1e-3 } else { 1e-4 };
        let (mut at, mut iterations) = (0, 0);
        let steps = (400_000 / n).clamp(5, 100);
        let seconds = least(steps, || {
            let now = StepTime { start: f64::from(at) * dt, dt };
            let report = pool.install(|| integrator.step(pool, &mut system, &Loads::default(), now, 1)).unwrap();
            (at, iterations) = (at + 1, iterations + report.iterations);
        });
        // Of a spring: its ends and what it is at rest; family and measure are not looked at in a step.
        let per_element = |set: &pliant_solver::ElementSet| {
            (set.nodes().len() * 4 + set.count() * 8 * set.request().rest_stride as usize) as f64
        };
        // Of a node: place, speed, force and what it was, each read and written, mass and constraint.
        let springs = system.sets.iter().filter(|set| set.has(abi::HAS_FORCES));
        let bytes: f64 = springs.map(per_element).sum::<f64>() + n as f64 * (6.0 * 24.0 + 48.0 + 8.0 + 32.0);
        let limit = 1e-9 * bytes / memory;
        println!(
            "{} threads, lattice {n:7} particles, {:16} {:9.3} ms, {:6.1} ns a particle, {:5.1} iterations; memory alone {:5.1} ns",
            pool.threads(),
            scheme.name(),
            1e3 * seconds,
            1e9 * seconds / n as f64,
            iterations as f64 / f64::from(at),
            1e9 * limit / n as f64,
        );
    }
}
