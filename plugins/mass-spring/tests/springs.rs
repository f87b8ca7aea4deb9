//! Forces and stiffness of springs: differences of the energy, conservation laws, and moduli in closed form.

use pliant_mass_spring::MassSpring;
use pliant_plugin_api::kit::{self, Block, Body, Random};
use pliant_plugin_api::{Material, TangentScale, abi};

const ALL: u32 = abi::STRUCTURAL | abi::SHEAR | abi::FLEXION;

/// A body of the material on a block, at rest.
fn body(material: &MassSpring, block: &Block) -> Body {
    let families = material.elements().iter().fold(0, |all, r| all | r.families);
    assert_eq!(families & !ALL, 0);
    Body::new(material, block.rest.clone(), |r| block.elements(r.kind)).unwrap()
}

/// Displaces every node by up to `size` (m) and sets velocities of up to 1 m/s, the same in every run.
fn perturb(body: &mut Body, size: f64) {
    let mut random = Random(1);
    for i in 0..body.x.len() {
        for c in 0..3 {
            body.x[i][c] += size * random.signed();
            body.v[i][c] = random.signed();
        }
    }
}

fn forces(material: &MassSpring, body: &Body) -> Vec<[f64; 3]> {
    let mut force = vec![[0.0; 3]; body.x.len()];
    body.add_forces(material, &mut force).unwrap();
    force
}

fn without_velocities(body: &Body) -> Body {
    let mut body = body.clone();
    body.v.fill([0.0; 3]);
    body
}

#[test]
fn forces_are_minus_the_gradient_of_the_energy() {
    let block = kit::block([3, 4, 2], 0.01, ALL);
    let material: MassSpring = kit::material(&[("flexion", 0.1)]).unwrap();
    let mut body = body(&material, &block);
    perturb(&mut body, 2e-3);
    let body = without_velocities(&body);
    let force = forces(&material, &body);
    let largest = force.iter().flatten().fold(0.0_f64, |m, f| m.max(f.abs()));
    for node in [0, 7, 31, 59] {
        for c in 0..3 {
            let eps = 1e-7;
            let energy_at = |step: f64| {
                let mut moved = body.clone();
                moved.x[node][c] += step;
                moved.energy(&material).unwrap()
            };
            let gradient = (energy_at(eps) - energy_at(-eps)) / (2.0 * eps);
            assert!((force[node][c] + gradient).abs() < 1e-6 * largest, "node {node}: {} {gradient}", force[node][c]);
            assert!((force[node][c] - gradient).abs() > 1e-4 * largest, "the force is too small to have a sign");
        }
    }
}

#[test]
fn stiffness_and_damping_are_minus_the_gradients_of_the_forces() {
    let block = kit::block([2, 1, 1], 0.01, ALL);
    let material: MassSpring = kit::material(&[("flexion", 0.1), ("damping-time", 0.01)]).unwrap();
    let mut body = body(&material, &block);
    for x in &mut body.x {
        *x = x.map(|c| 1.2 * c); // all springs in tension: only there the matrix is the exact Hessian
    }
    let width = 3 * body.x.len();
    let k = body.tangent(&material, TangentScale { stiffness: 1.0, damping: 0.0 }).unwrap();
    let c = body.tangent(&material, TangentScale { stiffness: 0.0, damping: 1.0 }).unwrap();
    let scale = k.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    for column in 0..width {
        let difference = |by_velocity: bool, eps: f64| {
            let forces_at = |step: f64| {
                let mut moved = body.clone();
                let field = if by_velocity { &mut moved.v } else { &mut moved.x };
                field[column / 3][column % 3] += step;
                forces(&material, &moved)
            };
            let (plus, minus) = (forces_at(eps), forces_at(-eps));
            (0..width)
                .map(move |row| (plus[row / 3][row % 3] - minus[row / 3][row % 3]) / (2.0 * eps))
                .collect::<Vec<_>>()
        };
        for (row, (dx, dv)) in difference(false, 1e-7).into_iter().zip(difference(true, 1e-3)).enumerate() {
            assert!((k[row * width + column] + dx).abs() < 1e-5 * scale, "K {row} {column}");
            assert!((c[row * width + column] + dv).abs() < 1e-7 * scale, "C {row} {column}");
        }
    }
}

#[test]
fn rest_and_rigid_motion_have_no_forces() {
    let block = kit::block([4, 3, 3], 0.01, ALL);
    let material: MassSpring = kit::material(&[("flexion", 0.1), ("damping-time", 0.01)]).unwrap();
    let mut body = body(&material, &block);
    assert!(forces(&material, &body).iter().flatten().all(|&f| f == 0.0), "rest");
    let (s, c) = 0.7_f64.sin_cos();
    let moved_rigidly = |p: [f64; 3]| [c * p[0] - s * p[1] + 1.0, s * p[0] + c * p[1] - 2.0, p[2] + 3.0];
    for i in 0..body.x.len() {
        body.x[i] = moved_rigidly(body.rest[i]);
        // A rigid rotation at 3 rad/s about the z axis.
        body.v[i] = [-3.0 * body.x[i][1], 3.0 * body.x[i][0], 0.0];
    }
    let stiffness = 0.4 * 1e4 * 0.01;
    for f in forces(&material, &body).iter().flatten() {
        assert!(f.abs() < 1e-12 * stiffness, "{f}");
    }
}

#[test]
fn forces_have_no_resultant_and_no_moment() {
    let block = kit::block([4, 3, 3], 0.01, ALL);
    let material: MassSpring = kit::material(&[("flexion", 0.1), ("damping-time", 0.01)]).unwrap();
    let mut body = body(&material, &block);
    perturb(&mut body, 3e-3);
    let force = forces(&material, &body);
    let magnitude: f64 = force.iter().flatten().map(|f| f.abs()).sum();
    let mut resultant = [0.0; 3];
    let mut moment = [0.0; 3];
    for (f, x) in force.iter().zip(&body.x) {
        for i in 0..3 {
            resultant[i] += f[i];
            moment[i] += x[(i + 1) % 3] * f[(i + 2) % 3] - x[(i + 2) % 3] * f[(i + 1) % 3];
        }
    }
    assert!(resultant.iter().all(|f| f.abs() < 1e-13 * magnitude));
    assert!(moment.iter().all(|m| m.abs() < 1e-14 * magnitude));
}

#[test]
fn damping_dissipates_energy() {
    let block = kit::block([3, 3, 3], 0.01, ALL);
    let damped: MassSpring = kit::material(&[("damping-time", 0.01)]).unwrap();
    let undamped: MassSpring = kit::material(&[("damping-time", 0.0)]).unwrap();
    let mut body = body(&damped, &block);
    perturb(&mut body, 3e-3);
    let (with, without) = (forces(&damped, &body), forces(&undamped, &body));
    let power: f64 = (0..body.x.len())
        .flat_map(|i| (0..3).map(move |c| (i, c)))
        .fold(0.0, |p, (i, c)| p + (with[i][c] - without[i][c]) * body.v[i][c]);
    assert!(power < -1e-3, "{power}");
}

#[test]
fn mass_is_density_times_volume_or_the_particle_mass_of_the_paper() {
    let block = kit::block([3, 2, 5], 0.02, ALL);
    let physical: MassSpring = kit::material(&[("density", 800.0)]).unwrap();
    let mass: f64 = body(&physical, &block).mass(&physical).unwrap().iter().sum();
    assert!((mass - 800.0 * 30.0 * 8e-6).abs() < 1e-12);
    let paper: MassSpring = kit::material(&[("mode", 1.0), ("particle-mass", 0.003)]).unwrap();
    assert!(body(&paper, &block).mass(&paper).unwrap().iter().all(|&m| m == 0.003));
}

/// The moduli of a material, measured on a cube.
#[derive(Clone, Copy, Debug)]
struct Moduli {
    /// Young's modulus, Pa.
    young: f64,
    poisson: f64,
}

/// Measures the moduli in a tensile test on the stiffness matrix of a cube of `cells` cells per axis: two opposite faces are moved apart,
/// the others are free.
fn tensile_test(material: &MassSpring, cells: u32) -> Moduli {
    let h = 0.01;
    let block = kit::block([cells; 3], h, ALL);
    let body = body(material, &block);
    let width = 3 * body.x.len();
    let k = body.tangent(material, TangentScale { stiffness: 1.0, damping: 0.0 }).unwrap();
    let strain = 1.0;
    let (edge, tolerance) = (f64::from(cells) * h, 1e-9);
    let fixed: Vec<Option<f64>> = (0..width)
        .map(|d| {
            let (p, c) = (block.rest[d / 3], d % 3);
            match c {
                2 if p[2] > edge - tolerance => Some(strain * edge),
                2 if p[2] < tolerance => Some(0.0),
                // Symmetry planes, against rigid motion.
                0 | 1 if p[c] < tolerance => Some(0.0),
                _ => None,
            }
        })
        .collect();
    let u = solve(&k, &fixed);
    let reaction = |d: usize| (0..width).map(|j| k[d * width + j] * u[j]).sum::<f64>();
    let is_on_far_face = |d: usize, axis: usize| d % 3 == axis && block.rest[d / 3][axis] > edge - tolerance;
    let force: f64 = (0..width).filter(|&d| is_on_far_face(d, 2)).map(reaction).sum();
    let contraction: Vec<f64> = (0..width).filter(|&d| is_on_far_face(d, 0)).map(|d| -u[d] / (edge * strain)).collect();
    Moduli {
        young: force / (edge * edge) / strain,
        poisson: contraction.iter().sum::<f64>() / contraction.len() as f64,
    }
}

/// Solves `K u = 0` with prescribed values of some u, by conjugate gradients to round-off.
fn solve(k: &[f64], fixed: &[Option<f64>]) -> Vec<f64> {
    let width = fixed.len();
    let mut u: Vec<f64> = fixed.iter().map(|f| f.unwrap_or(0.0)).collect();
    let free = |d: usize| fixed[d].is_none();
    let product = |p: &[f64]| -> Vec<f64> {
        (0..width).map(|i| if free(i) { (0..width).map(|j| k[i * width + j] * p[j]).sum() } else { 0.0 }).collect()
    };
    let mut r: Vec<f64> = product(&u).iter().map(|v| -v).collect();
    let mut p = r.clone();
    let mut rr: f64 = r.iter().map(|v| v * v).sum();
    let initial_rr = rr;
    while rr > 1e-28 * initial_rr {
        let s = product(&p);
        let step = rr / p.iter().zip(&s).map(|(a, b)| a * b).sum::<f64>();
        for d in 0..width {
            u[d] += step * p[d];
            r[d] -= step * s[d];
        }
        let next: f64 = r.iter().map(|v| v * v).sum();
        for d in 0..width {
            p[d] = r[d] + next / rr * p[d];
        }
        rr = next;
    }
    u
}

#[test]
fn a_block_has_the_moduli_of_the_closed_form() {
    let young = 1e4;
    for cells in [2, 4] {
        for flexion in [0.0, 0.125] {
            let material: MassSpring = kit::material(&[("young", young), ("flexion", flexion)]).unwrap();
            let measured = tensile_test(&material, cells);
            let ratio = measured.young / young;
            if flexion == 0.0 {
                let exact = (ratio - 1.0).abs() < 1e-9 && (measured.poisson - 0.25).abs() < 1e-9;
                assert!(exact, "{cells} cells: {measured:?}");
            } else {
                // Flexion springs do not reach the faces, so the block is softer.
                assert!((0.7..1.0).contains(&ratio), "{cells} cells: {measured:?}");
            }
        }
        let (h, stiffness) = (0.01, 7.0);
        let paper = |weights: f64| -> MassSpring {
            kit::material(&[("mode", 1.0), ("spring", stiffness), ("boundary-weights", weights)]).unwrap()
        };
        let measured = [0.0, 1.0].map(|weights| tensile_test(&paper(weights), cells));
        // With and without boundary weights: `young` relative to stiffness / h, from an independent computation.
        let expected = match cells {
            2 => [(4.66666667, 0.166666667), (9.3215706, 0.132781309)],
            _ => [(5.44852249, 0.151654671), (7.97914135, 0.130678725)],
        }
        .map(|(young, poisson)| Moduli { young: young * stiffness / h, poisson });
        for (measured, expected) in measured.iter().zip(&expected) {
            let young_error = (measured.young - expected.young).abs() * h / stiffness;
            let poisson_error = (measured.poisson - expected.poisson).abs();
            assert!(young_error < 1e-7 && poisson_error < 1e-8, "{measured:?} {expected:?}");
        }
    }
}

#[test]
fn springs_without_length_are_refused() {
    let opened = Body::new(&kit::material::<MassSpring>(&[]).unwrap(), vec![[0.0; 3], [0.0; 3]], |r| {
        if r.kind == abi::LINK {
            kit::ElementList { nodes: vec![0, 1], ..Default::default() }
        } else {
            kit::ElementList::default()
        }
    });
    assert!(opened.unwrap_err().reason.contains("rest length"));
}
