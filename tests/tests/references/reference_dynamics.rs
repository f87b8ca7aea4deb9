//! R08, R12, R14, R18 and R31: how sheets move, against closed forms, on four patterns of triangles.

#![allow(clippy::print_stdout, reason = "the table of errors")]

use pliant_mesh::Surface;
use pliant_mesh::generate::Pattern;
use pliant_mesh::testing::Random;
use pliant_solver::{Scheme, Vec3};
use pliant_tests::cloth::{G, PATTERNS, Piece, order, sheet};
use std::f64::consts::PI;

/// Steps of a period.
const STEPS: f64 = 30.0;

/// Hz, of a small motion of shape `mode` about where the piece is, near `guess`: from 40 zero crossings of the mode's share, by
/// implicit midpoint, whose known error in time is taken off.
fn frequency(piece: &mut Piece, guess: f64, mode: impl Fn(Vec3) -> Vec3) -> f64 {
    let dt = 1.0 / (STEPS * guess);
    let nodes = &mut piece.system().nodes;
    let shape: Vec<Vec3> = nodes.rest.iter().map(|p| mode(*p)).collect();
    let middle = nodes.x.clone();
    for i in 0..shape.len() {
        if nodes.constraint[i].is_free() {
            nodes.x[i] += 1e-6 * shape[i];
        }
    }
    let mut crossings = Vec::new();
    let mut before = 1.0;
    for i in 0..(25.0 * STEPS) as usize {
        piece.step(dt);
        let nodes = &piece.system().nodes;
        let part = |i: usize| nodes.mass[i] * shape[i].dot(&(nodes.x[i] - middle[i]));
        let now: f64 = (0..shape.len()).filter(|i| nodes.constraint[*i].is_free()).map(part).sum();
        if i > 0 && before * now < 0.0 {
            crossings.push((i as f64 + before / (before - now)) * dt);
        }
        before = now;
        if crossings.len() > 40 {
            break;
        }
    }
    assert!(crossings.len() > 40, "{} crossings", crossings.len());
    let found = 20.0 / (crossings[40] - crossings[0]);
    (PI * found * dt).tan() / (PI * dt)
}

fn strip(pattern: Pattern, n: u32, length: f64) -> Surface {
    let cell = length / f64::from(n);
    let height = if pattern == Pattern::Equilateral { cell * 0.75_f64.sqrt() } else { cell };
    sheet(pattern, [n, 2], [length, 2.0 * height])
}

fn cloth(young: f64, rho: f64) -> String {
    format!("density = {rho:e}, young-warp = {young}, poisson = 0, damping-time = 0, bending = \"none\"")
}

/// Errors of a frequency at 8, 16 and 32 cells: the last within 1 %, of second order.
fn judge(what: &str, pattern: Pattern, errors: &[f64]) {
    let last = errors.len() - 1;
    let slope = order(errors[last - 1], errors[last]);
    println!("R08 {what} {pattern:?}: {errors:.6?}, order {slope:.2}");
    assert!(errors[last].abs() < 0.01, "{what} {pattern:?}: {errors:?}");
    // A mesh that is another one at every size has no clean slope, and what is exact to 1e-4 none to be seen.
    let free = if pattern == Pattern::Irregular { 0.7 } else { 0.3 };
    assert!((slope - 2.0).abs() < free || errors[last].abs() < 1e-4, "{what} {pattern:?}: {errors:?} {slope}");
}

#[test]
fn r08_taut_string() {
    let (a, tension, rho, young) = (0.2, 10.0, 0.2, 1000.0);
    let e = tension / young;
    for pattern in PATTERNS {
        for (mode, exact) in [(1.0, 17.6776695), (2.0, 35.3553391)] {
            let errors = [8, 16, 32].map(|n| {
                let l = a / (1.0 + e);
                let surface = strip(pattern, n, l);
                let ends = |p: Vec3| p[0] < 1e-9 || p[0] > l - 1e-9;
                let mut piece = Piece::new(&surface, &cloth(young, rho * (1.0 + e)), ends, false);
                piece = piece.moved_by(Scheme::ImplicitMidpoint);
                piece.put(|p| Vec3::new((1.0 + e) * p[0], p[1], 0.0));
                frequency(&mut piece, exact, |p| Vec3::new(0.0, 0.0, (mode * PI * p[0] / l).sin())) / exact - 1.0
            });
            judge(&format!("string {mode}"), pattern, &errors);
        }
    }
}

#[test]
fn r08_taut_membrane() {
    let (a, tension, rho, young) = (0.2, 10.0, 0.2, 1000.0);
    // Tension is over the stretched width.
    let e = tension / (young - tension);
    for pattern in PATTERNS {
        for ([p, q], exact) in [([1.0, 1.0], 25.0), ([1.0, 2.0], 39.5284708), ([2.0, 2.0], 50.0)] {
            let errors = [8, 16].map(|n| {
                let l = a / (1.0 + e);
                let surface = sheet(pattern, [n, n], [l, l]);
                let border = |p: Vec3| (0..2).any(|i| p[i] < 1e-9 || p[i] > l - 1e-9);
                let mut piece = Piece::new(&surface, &cloth(young, rho * (1.0 + e).powi(2)), border, false);
                piece = piece.moved_by(Scheme::ImplicitMidpoint);
                piece.put(|p| p.map(|c| (1.0 + e) * c));
                let mode = |x: Vec3| Vec3::new(0.0, 0.0, (p * PI * x[0] / l).sin() * (q * PI * x[1] / l).sin());
                frequency(&mut piece, exact, mode) / exact - 1.0
            });
            judge(&format!("membrane {p} {q}"), pattern, &errors);
        }
    }
}

#[test]
fn r08_along_a_bar_and_of_a_hanging_chain() {
    let (l, rho, young) = (0.2, 0.2, 1000.0);
    for pattern in PATTERNS {
        let errors = [8, 16, 32].map(|n| {
            let mut piece = Piece::new(&strip(pattern, n, l), &cloth(young, rho), |p| p[0] < 1e-9, false);
            piece = piece.moved_by(Scheme::ImplicitMidpoint);
            frequency(&mut piece, 88.3883476, |p| Vec3::new((0.5 * PI * p[0] / l).sin(), 0.0, 0.0)) / 88.3883476 - 1.0
        });
        judge("bar", pattern, &errors);
        for (root, exact) in [(2.404825557695773, 1.34027285), (5.520078110286311, 3.07648545)] {
            let errors = [8, 16, 32].map(|n| {
                let mut piece = Piece::new(&strip(pattern, n, l), &cloth(20.0 * young, rho), |p| p[0] < 1e-9, false);
                piece = piece.moved_by(Scheme::ImplicitMidpoint);
                piece.gravity = Vec3::new(G, 0.0, 0.0);
                piece.settle(1e-7);
                let mode = |p: Vec3| Vec3::new(0.0, 0.0, bessel(root * ((l - p[0]).max(0.0) / l).sqrt()));
                frequency(&mut piece, exact, mode) / exact - 1.0
            });
            judge(&format!("chain {exact}"), pattern, &errors);
        }
    }
}

/// J0, by its series.
fn bessel(x: f64) -> f64 {
    let (mut sum, mut term) = (0.0, 1.0);
    for k in 1..40 {
        sum += term;
        term *= -0.25 * x * x / f64::from(k * k);
    }
    sum
}

/// s, of the swing from the first to the third time it passes below its support.
fn period(piece: &mut Piece, dt: f64) -> f64 {
    let mut crossings = Vec::new();
    let lowest = |piece: &mut Piece| piece.mean(|p| p[0] > 0.19)[2];
    let mut before = lowest(piece);
    while crossings.len() < 3 {
        let at = piece.time;
        piece.step(dt);
        let now = lowest(piece);
        if before * now < 0.0 {
            crossings.push(at + dt * before / (before - now));
        }
        before = now;
        assert!(piece.time < 10.0);
    }
    crossings[2] - crossings[0]
}

fn turned(angle: f64) -> impl Fn(Vec3) -> Vec3 {
    let (s, c) = angle.to_radians().sin_cos();
    move |p| Vec3::new(c * p[0], p[1], s * p[0])
}

#[test]
fn r12_pendulum() {
    // A bar of two triangles with its mass at the lower end.
    let table = [(5.0, 0.897567487), (30.0, 0.912758427), (60.0, 0.96279482), (90.0, 1.05893111), (150.0, 1.58094397)];
    for (scheme, expected, longest, young) in [
        (Scheme::SymplecticEuler, 2.0, 1.5e-3, 1e4),
        (Scheme::BackwardEuler, 1.0, 5e-4, 1e5),
        (Scheme::Bdf2, 2.0, 8e-3, 1e5),
        (Scheme::ImplicitMidpoint, 2.0, 8e-3, 1e5),
    ] {
        for (angle, exact) in table {
            let errors = [1.0, 0.5, 0.25].map(|share| {
                let surface = sheet(Pattern::Regular, [1, 1], [0.2, 0.05]);
                let mut piece = Piece::new(&surface, &cloth(young, 0.2), |p| p[0] < 1e-9, false).moved_by(scheme);
                piece.system().nodes.mass.fill(0.05);
                piece.gravity = Vec3::new(G, 0.0, 0.0);
                piece.put(turned(angle));
                period(&mut piece, share * longest) / exact - 1.0
            });
            // The bar is a little longer under its load: the order is that of the differences.
            let slope = order(errors[0] - errors[1], errors[1] - errors[2]);
            println!("R12 {} {angle} from {longest} s: {errors:.6?}, order {slope:.2}", scheme.name());
            let near_the_top = angle > 100.0 && scheme == Scheme::BackwardEuler;
            assert!(errors[2].abs() < if near_the_top { 0.08 } else { 0.01 }, "{} {angle}: {errors:?}", scheme.name());
            let seen = (errors[1] - errors[2]).abs() > 2e-6;
            assert!(!seen || slope > expected - 0.5, "{} {angle}: {errors:?} {slope}", scheme.name());
        }
    }
}

#[test]
fn r12_rigid_strip() {
    // Stiff to bend: the matrix that stands for coupled hinges must not be softer than they are, or this grows.
    for (scheme, dt) in [(Scheme::ImplicitMidpoint, 2e-3), (Scheme::Bdf2, 2e-3), (Scheme::BackwardEuler, 2e-3)] {
        for pattern in PATTERNS {
            let params = "density = 0.2, young-warp = 5000, poisson = 0, damping-time = 0, bending-warp = 10";
            let mut piece = Piece::new(&strip(pattern, 8, 0.2), params, |p| p[0] < 1e-9, false).moved_by(scheme);
            piece.gravity = Vec3::new(G, 0.0, 0.0);
            piece.put(turned(5.0));
            let exact = 0.732511982 * (0.897567487 / 0.897140293);
            let error = period(&mut piece, dt) / exact - 1.0;
            println!("R12 rigid strip {} {pattern:?}: {error:.5}", scheme.name());
            assert!(error.abs() < 0.01, "{} {pattern:?}: {error}", scheme.name());
        }
    }
}

#[test]
fn r14_backward_euler_takes_from_a_mode_of_25_hz_what_it_should() {
    let (a, young) = (0.2, 1000.0);
    let e = 10.0 / (young - 10.0);
    let l = a / (1.0 + e);
    let border = |p: Vec3| (0..2).any(|i| p[i] < 1e-9 || p[i] > l - 1e-9);
    let mut piece =
        Piece::new(&sheet(Pattern::Regular, [16, 16], [l, l]), &cloth(young, 0.2 * (1.0 + e).powi(2)), border, false);
    let shape = |p: Vec3| (PI * p[0] / l).sin() * (PI * p[1] / l).sin();
    piece.put(|p| Vec3::new((1.0 + e) * p[0], (1.0 + e) * p[1], 1e-6 * shape(p)));
    let share = |piece: &mut Piece| {
        let nodes = &piece.system().nodes;
        (0..nodes.len()).map(|i| nodes.mass[i] * shape(nodes.rest[i]) * nodes.x[i][2]).sum::<f64>()
    };
    let states: Vec<f64> = (0..154)
        .map(|_| {
            piece.step(1e-3);
            share(&mut piece)
        })
        .collect();
    // Of a damped wave x_n+1 - p x_n + q x_n-1 = 0, with q the square of what a step leaves.
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| states[150 + i]);
    let per_step = ((c * c - b * d) / (b * b - a * c)).sqrt();
    let turn = (per_step.powi(-2) - 1.0).sqrt().atan();
    let per_period = per_step.powf(2.0 * PI / turn);
    println!("R14: {per_period}");
    assert!((per_period / 0.61172412 - 1.0).abs() < 1e-3, "{per_period}");
}

#[test]
fn r18_kelvin_voigt_creep() {
    let (tau, young, load, l) = (0.01, 1000.0, 2.0, 0.1);
    for pattern in PATTERNS {
        for (scheme, expected) in [(Scheme::BackwardEuler, 1.0), (Scheme::Bdf2, 2.0)] {
            let errors = [1e-3, 5e-4, 2.5e-4, 1.25e-4].map(|dt| {
                let surface = strip(pattern, 8, l);
                let params = format!(
                    "density = 1e-4, young-warp = {young}, poisson = 0, damping-time = {tau}, bending = \"none\""
                );
                let mut piece = Piece::new(&surface, &params, |p| p[0] < 1e-9, false).moved_by(scheme);
                let mut end: Vec<usize> =
                    (0..surface.points.len()).filter(|v| surface.points[*v][0] > l - 1e-9).collect();
                end.sort_by(|a, b| surface.points[*a][1].total_cmp(&surface.points[*b][1]));
                piece.forces = vec![Vec3::zeros(); surface.points.len()];
                for pair in end.windows(2) {
                    let share = 0.5 * load * (surface.points[pair[1]][1] - surface.points[pair[0]][1]);
                    pair.iter().for_each(|v| piece.forces[*v][0] += share);
                }
                let mut worst = 0.0_f64;
                let mut at = 0.0;
                for t in [0.005, 0.01, 0.02, 0.05] {
                    while at < t - 1e-9 {
                        piece.step(dt);
                        at += dt;
                    }
                    let strain = piece.mean(|p| p[0] > l - 1e-9)[0] / l - 1.0;
                    worst = worst.max((strain / (load / young * (1.0 - (-t / tau).exp())) - 1.0).abs());
                }
                worst
            });
            let slope = order(errors[2], errors[3]);
            println!("R18 {} {pattern:?}: {errors:.5?}, order {slope:.2}", scheme.name());
            assert!(errors[3] < 0.01, "{} {pattern:?}: {errors:?}", scheme.name());
            assert!((slope - expected).abs() < 0.3, "{} {pattern:?}: {errors:?}", scheme.name());
        }
    }
}

#[test]
fn r31_taut_sheet_is_stable_at_steps_its_waves_do_not_bear() {
    // Without the stiffness of tension against turning the limit is h sqrt(rho / T) = 1.265 ms.
    for pattern in PATTERNS {
        for dt in [1e-3, 2e-3, 5e-3, 1e-2] {
            let surface = sheet(pattern, [10, 10], [0.2, 0.2]);
            let ends = |p: Vec3| p[0] < 1e-9 || p[0] > 0.2 - 1e-9;
            let params =
                "density = 0.2, young-warp = 1000, poisson = 0, shear = 100, damping-time = 0, bending = \"none\"";
            let mut piece = Piece::new(&surface, params, ends, false);
            let mut random = Random(1);
            piece.put(|p| Vec3::new(1.05 * p[0], p[1], 0.0));
            let nodes = &mut piece.system().nodes;
            (0..nodes.len()).filter(|i| !ends(nodes.rest[*i])).for_each(|i| nodes.x[i][2] = 1e-5 * random.signed());
            (0..200).for_each(|_| _ = piece.step(dt));
            let most = piece.system().nodes.x.iter().fold(0.0, |m: f64, x| m.max(x[2].abs()));
            println!("R31 {pattern:?} {dt}: {most:.2e} m");
            assert!(most < if dt > 1e-3 { 1e-14 } else { 1e-6 }, "{pattern:?} {dt}: {most}");
        }
    }
}
