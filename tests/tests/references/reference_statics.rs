//! R02 to R07 and R16: sheets at rest against closed forms and high-accuracy values, on four patterns of triangles.

#![allow(clippy::print_stdout, reason = "the table of errors")]

use pliant_mesh::Surface;
use pliant_mesh::generate::Pattern;
use pliant_mesh::geometry::Vec3;
use pliant_tests::cloth::{G, PATTERNS, Piece, order, sheet};

/// Rows that make cells of a strip as wide as they are long, for a strip of `n` cells and so many across.
fn strip(pattern: Pattern, n: u32, across: u32, length: f64) -> Surface {
    let cell = length / f64::from(n);
    let height = if pattern == Pattern::Equilateral { cell * 0.75_f64.sqrt() } else { cell };
    sheet(pattern, [n, across], [length, f64::from(across) * height])
}

fn width(surface: &Surface) -> f64 {
    surface.points.iter().fold(0.0, |m: f64, p| m.max(p[1]))
}

/// H (N/m), sag (m) and tension at the ends (N/m) of an elastic catenary of rest length `l` over `span`, by Newton's method on the
/// span `H l / E + 2 H / w asinh(V / H)` with V = w l / 2.
fn catenary(w: f64, young: f64, l: f64, span: f64) -> [f64; 3] {
    let v = 0.5 * w * l;
    let (mut low, mut high) = (1e-6 * v, 1e3 * v);
    for _ in 0..200 {
        let h = 0.5 * (low + high);
        let across = h * l / young + 2.0 * h / w * (v / h).asinh();
        (low, high) = if across < span { (h, high) } else { (low, h) };
    }
    let h = 0.5 * (low + high);
    let t = h.hypot(v);
    [h, v * v / (2.0 * w * young) + (t - h) / w, t]
}

#[test]
fn r02_elastic_catenary() {
    let (rho, l, span) = (0.2, 0.2, 0.15);
    for (young, tabled) in [
        (1000.0, [0.108854429, 0.0588883261, 0.224374078]),
        (100.0, [0.108454289, 0.0590817568, 0.224180224]),
        (20.0, [0.106734158, 0.0599293234, 0.22335313]),
    ] {
        let exact = catenary(rho * G, young, l, span);
        assert!((0..3).all(|i| (exact[i] / tabled[i] - 1.0).abs() < 1e-7), "{exact:?} {tabled:?}");
        for pattern in PATTERNS {
            let errors = [10_u32, 20, 40].map(|n| {
                let surface = strip(pattern, n, 2, l);
                let wide = width(&surface);
                let params = format!("density = {rho}, young-warp = {young}, poisson = 0, bending = \"none\"");
                let ends = |p: Vec3| p[0] < 1e-9 || p[0] > l - 1e-9;
                let mut piece = Piece::new(&surface, &params, ends, false);
                piece.gravity = Vec3::new(0.0, 0.0, -G);
                // The ends come together, and what is between hangs down in a parabola.
                piece.put(|p| Vec3::new(p[0] * span / l, p[1], -0.24 * p[0] / l * (1.0 - p[0] / l)));
                piece.settle(1e-8);
                // The mean over the width, not over vertices: those of the border have half the width of the others.
                let low = piece.mean_across(0.5 * l);
                let end = piece.reaction(|p| p[0] < 1e-9) / wide;
                [-low[2] / exact[1] - 1.0, -end[0] / exact[0] - 1.0, end[2] / (0.5 * rho * G * l) - 1.0]
            });
            let slope = 0.5 * order(errors[0][0], errors[2][0]);
            println!("R02 E {young} {pattern:?}: sag, H, V {errors:.6?}, order {slope:.2}");
            let worst = errors[2].iter().fold(0.0, |m: f64, e| m.max(e.abs()));
            assert!(worst < 2e-3, "{young} {pattern:?}: {errors:?}");
            let of_span = errors[2][0] * exact[1] / span;
            let aligned = [Pattern::Regular, Pattern::Equilateral].contains(&pattern);
            assert!(of_span.abs() < 1.5e-4, "{young} {pattern:?}: {of_span} of the span");
            assert!((slope - 2.0).abs() < if aligned { 0.1 } else { 0.4 }, "{young} {pattern:?}: {errors:?}");
        }
    }
}

#[test]
fn r03_hanging_strip() {
    let (rho, young, l) = (0.2, 1000.0, 0.2);
    let tip = rho * G * l * l / (2.0 * young);
    assert!((tip / 3.924e-5 - 1.0).abs() < 1e-9);
    for pattern in PATTERNS {
        let errors = [10_u32, 20, 40].map(|n| {
            let surface = strip(pattern, n, n / 5, l);
            let params = format!("density = {rho}, young-warp = {young}, poisson = 0, bending = \"none\"");
            let mut piece = Piece::new(&surface, &params, |p| p[0] < 1e-9, false);
            piece.gravity = Vec3::new(G, 0.0, 0.0);
            piece.settle(1e-8);
            let weight = rho * G * l * width(&surface);
            let carried = -piece.reaction(|p| p[0] < 1e-9)[0];
            assert!((carried / weight - 1.0).abs() < 1e-6, "{pattern:?}: {carried} N carry {weight} N");
            let nodes = &piece.system().nodes;
            let off = |i: usize| {
                let (x, at) = (nodes.x[i], nodes.rest[i]);
                (x[0] - at[0] - rho * G * (l * at[0] - 0.5 * at[0] * at[0]) / young).abs() / tip
            };
            let most = (0..nodes.len()).map(off).fold(0.0, f64::max);
            [(piece.mean(|p| p[0] > l - 1e-9)[0] - l) / tip - 1.0, most]
        });
        let slope = 0.5 * order(errors[0][1], errors[2][1]);
        println!("R03 {pattern:?}: tip, most {errors:.2?}, order of the most {slope:.2}");
        assert!(errors[2][0].abs() < 2e-5, "{pattern:?}: {errors:?}");
        // The corners at the lower end, which carry one or two triangles, are what is furthest off.
        assert!(errors[2][1] < 4e-3 && slope > 1.4, "{pattern:?}: {errors:?}");
    }
}

/// Shear of 1 N on the right edge of the tapered sheet (0,0)(48,44)(48,60)(0,44), E 1 N/m, ratio 1/3: deflection of the edge's
/// middle and its mean (= work over load), m.
fn cook(pattern: Pattern, n: u32, mirrored: bool) -> [f64; 2] {
    let mut surface = sheet(pattern, [n, n], [1.0, 1.0]);
    if mirrored {
        surface.points.iter_mut().for_each(|p| p[1] = 1.0 - p[1]);
        surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    for p in &mut surface.points {
        let [s, t, _] = (*p).into();
        let at = |corners: [f64; 4]| {
            (1.0 - s) * (1.0 - t) * corners[0]
                + s * (1.0 - t) * corners[1]
                + s * t * corners[2]
                + (1.0 - s) * t * corners[3]
        };
        *p = Vec3::new(at([0.0, 48.0, 48.0, 0.0]), at([0.0, 44.0, 60.0, 44.0]), 0.0);
    }
    let params = "density = 1e-6, young-warp = 1, poisson = 0.333333333333, bending = \"none\"";
    let mut piece = Piece::new(&surface, params, |p| p[0] < 1e-9, false);
    let mut right: Vec<usize> = (0..surface.points.len()).filter(|v| surface.points[*v][0] > 48.0 - 1e-9).collect();
    right.sort_by(|a, b| surface.points[*a][1].total_cmp(&surface.points[*b][1]));
    let small = 1e-4;
    let mut shares = vec![0.0; right.len()];
    for i in 1..right.len() {
        let length = surface.points[right[i]][1] - surface.points[right[i - 1]][1];
        shares[i - 1] += 0.5 * length / 16.0;
        shares[i] += 0.5 * length / 16.0;
    }
    piece.forces = vec![Vec3::zeros(); surface.points.len()];
    right.iter().zip(&shares).for_each(|(v, share)| piece.forces[*v][1] = small * share);
    piece.settle(1e-7);
    let x = &piece.system().nodes.x;
    let moved = |v: usize| (x[v][1] - surface.points[v][1]) / small;
    let mean = right.iter().zip(&shares).map(|(v, share)| share * moved(*v)).sum();
    let middle = right.iter().min_by(|a, b| {
        let off = |v: usize| (surface.points[v][1] - 52.0).abs();
        off(**a).total_cmp(&off(**b))
    });
    [moved(*middle.unwrap()), mean]
}

#[test]
fn r05_cook_like_membrane() {
    // Linear triangles on the two regular meshes, by another program: middle and mean.
    let tabled = [
        (false, 8, [17.3311629, 17.3055939]),
        (false, 16, [21.5921504, 21.581902]),
        (true, 8, [22.0224181, 22.0072078]),
        (true, 16, [23.4120002, 23.4185346]),
    ];
    for (mirrored, n, wanted) in tabled {
        let found = cook(Pattern::Regular, n, mirrored);
        assert!((0..2).all(|i| (found[i] / wanted[i] - 1.0).abs() < 2e-4), "{mirrored} {n}: {found:?} {wanted:?}");
    }
    // p-version with a geometric mesh.
    let exact = 24.041594;
    for (pattern, mirrored) in [
        (Pattern::Regular, true),
        (Pattern::Alternating, false),
        (Pattern::Equilateral, false),
        (Pattern::Irregular, true),
    ] {
        let errors = [16, 32, 64].map(|n| 1.0 - cook(pattern, n, mirrored)[1] / exact);
        let slope = order(errors[1], errors[2]);
        println!("R05 {pattern:?}: {errors:.5?}, order {slope:.2}");
        assert!(
            errors[1] < if mirrored && pattern == Pattern::Regular { 0.01 } else { 0.0125 },
            "{pattern:?}: {errors:?}"
        );
        assert!((slope - 1.75).abs() < 0.3, "{pattern:?}: {errors:?}");
    }
}

/// Height over width of a strip under its own weight, clamped at x = 0.
fn hung(pattern: Pattern, n: u32, gamma: f64) -> f64 {
    let (rho, l) = (0.2_f64, 0.2_f64);
    let surface = strip(pattern, n, 2, l);
    let rigidity = rho * G * l.powi(3) / gamma;
    let params = format!("density = {rho}, young-warp = 20000, poisson = 0, bending-warp = {rigidity:e}");
    let mut piece = Piece::new(&surface, &params, |p| p[0] < 1e-9, true);
    piece.gravity = Vec3::new(0.0, 0.0, -G);
    piece.settle(1e-6);
    let tip = piece.mean(|p| p[0] > l - 1e-9);
    -tip[2] / tip[0]
}

#[test]
fn r06_heavy_elastica() {
    for (gamma, exact) in [(0.1, 0.0124995537), (1.0, 0.124561766), (10.0, 1.06680232), (100.0, 5.88810462)] {
        for pattern in PATTERNS {
            let errors = [8, 16, 32].map(|n| hung(pattern, n, gamma) / exact - 1.0);
            let slope = order(errors[1], errors[2]);
            println!("R06 {gamma} {pattern:?}: {errors:.6?}, order {slope:.2}");
            assert!(errors[2].abs() < 0.02, "{gamma} {pattern:?}: {errors:?}");
            // Below a tenth of a percent two errors of either sign meet.
            assert!(slope > 1.7 || errors[2].abs() < 1e-3, "{gamma} {pattern:?}: {errors:?}");
        }
    }
}

#[test]
fn r07_published_master_curve() {
    // Gamma; H/W as published (Romero et al. 2021) and of the exact elastica.
    for (gamma, published, exact) in [
        (0.1, 0.012501, 0.0124995537),
        (1.0, 0.124684, 0.124561766),
        (10.0, 1.067343, 1.06680232),
        (100.0, 5.883548, 5.88810462),
    ] {
        let found = hung(Pattern::Alternating, 64, gamma);
        let errors = [published, exact].map(|h| found / h - 1.0);
        println!("R07 {gamma}: {found:.6}, off the published {:.2e}, off the exact {:.2e}", errors[0], errors[1]);
        assert!(errors.iter().all(|e| e.abs() < 0.011), "{gamma}: {found} {errors:?}");
    }
}

/// N m, of what buckles.
const D: f64 = 15e-6;
/// m
const POST: f64 = 0.1;

fn post(pattern: Pattern, n: u32, held: impl Fn(Vec3) -> bool, clamp: bool) -> Piece {
    let params = format!("density = 0.2, young-warp = 1000, poisson = 0, damping-time = 0, bending-warp = {D:e}");
    Piece::new(&strip(pattern, n, 2, POST), &params, held, clamp).moved_by(pliant_solver::Scheme::ImplicitMidpoint)
}

/// Whether a small deflection `shape` (of x / L) grows, in 20 times the inverse of `w`, 1/s.
fn grows(piece: &mut Piece, along: impl Fn(f64) -> f64, shape: impl Fn(f64) -> f64, w: f64) -> bool {
    let size = 1e-7;
    piece.put(|p| Vec3::new(along(p[0]), p[1], size * shape((p[0] / POST).clamp(0.0, 1.0))));
    let (dt, steps) = (0.05 / w, 400);
    let mut most = 0.0_f64;
    for i in 0..steps {
        piece.step(dt);
        if 4 * i > 3 * steps {
            most = piece.system().nodes.x.iter().fold(most, |m, x| m.max(x[2].abs()));
        }
    }
    most > 1.5 * size
}

/// Where `grows` begins, by bisection.
fn critical([mut low, mut high]: [f64; 2], grows: impl Fn(f64) -> bool) -> f64 {
    assert!(!grows(low), "at {low}");
    assert!(grows(high), "at {high}");
    for _ in 0..8 {
        let middle = 0.5 * (low + high);
        (low, high) = if grows(middle) { (low, middle) } else { (middle, high) };
    }
    0.5 * (low + high)
}

#[test]
fn r16_buckling_loads() {
    use std::f64::consts::PI;
    let ends = |p: Vec3| p[0] < 1e-9 || p[0] > POST - 1e-9;
    let base = (D / 0.2).sqrt() / (POST * POST);
    for pattern in PATTERNS {
        let pinned = |n: u32| {
            let load = |p: f64| {
                grows(
                    &mut post(pattern, n, ends, false),
                    |x| x * (1.0 - p / 1000.0),
                    |s| (PI * s).sin(),
                    PI * PI * base,
                )
            };
            critical([0.85 * 0.0148044066, 1.15 * 0.0148044066], load) / 0.0148044066 - 1.0
        };
        let clamped = |n: u32| {
            let wave = |s: f64| 0.5 - 0.5 * (2.0 * PI * s).cos();
            let load = |p: f64| grows(&mut post(pattern, n, ends, true), |x| x * (1.0 - p / 1000.0), wave, 22.4 * base);
            critical([0.85 * 0.0592176264, 1.15 * 0.0592176264], load) / 0.0592176264 - 1.0
        };
        let standing = |n: u32| {
            let load = |gamma: f64| {
                let mut piece = post(pattern, n, |p| p[0] < 1e-9, true);
                let g = gamma * D / (0.2 * POST.powi(3));
                piece.gravity = Vec3::new(-g, 0.0, 0.0);
                let sunk = |x: f64| x - 0.2 * g * (POST * x - 0.5 * x * x) / 1000.0;
                grows(&mut piece, sunk, |s| 1.0 - (0.5 * PI * s).cos(), 3.516 * base)
            };
            critical([0.85 * 7.83734744, 1.15 * 7.83734744], load) / 7.83734744 - 1.0
        };
        for (what, errors) in
            [("pinned", [8, 16].map(pinned)), ("clamped", [12, 24].map(clamped)), ("standing", [8, 16].map(standing))]
        {
            println!("R16 {what} {pattern:?}: {errors:.4?}");
            assert!(
                errors[1].abs() < 0.03 && errors[1].abs() < 0.5 * errors[0].abs().max(0.01),
                "{what} {pattern:?}: {errors:?}"
            );
        }
    }
}

#[test]
fn r16_beyond_buckling() {
    // Angle at the ends, load over the critical one, shortening and deflection over length: elastica.
    for (angle, load, shortening, deflection) in [
        (20, 1.01539687, 0.0302690926, 0.109706521),
        (60, 1.15171962, 0.258980394, 0.296603823),
        (100, 1.51838879, 0.6510107, 0.395769748),
    ] {
        for pattern in PATTERNS {
            let errors = [8, 16, 32].map(|n| {
                let ends = |p: Vec3| p[0] < 1e-9 || p[0] > POST - 1e-9;
                let mut piece = post(pattern, n, ends, false);
                let wave = |s: f64| (std::f64::consts::PI * s).sin();
                let wide = piece.system().nodes.rest.iter().fold(0.0, |m: f64, p| m.max(p[1]));
                piece.put(|p| Vec3::new(p[0] * (1.0 - shortening), p[1], deflection * POST * wave(p[0] / POST)));
                piece.settle(1e-8);
                let found = piece.reaction(|p| p[0] < 1e-9)[0] / wide / (0.0148044066 * load) - 1.0;
                let high = piece.mean(|p| (p[0] - 0.5 * POST).abs() < 1e-9)[2];
                [found, high / (deflection * POST) - 1.0]
            });
            let slope = order(errors[1][0], errors[2][0]);
            println!("R16 {angle} {pattern:?}: load, deflection {errors:.5?}, order {slope:.2}");
            assert!(errors[2].iter().all(|e| e.abs() < 0.03), "{angle} {pattern:?}: {errors:?}");
            assert!((slope - 2.0).abs() < 0.3, "{angle} {pattern:?}: {errors:?}");
        }
    }
}
