//! Cloth at the ends of what is allowed: finite, its energy bounded, or refused with file and line.

#![allow(clippy::print_stdout, reason = "the table of errors")]

use pliant_mesh::generate::Pattern;
use pliant_mesh::testing::Random;
use pliant_solver::{Integrator, Scheme, Vec3};
use pliant_tests::Bench;
use pliant_tests::cloth::{G, PATTERNS, Piece, sheet};

/// A cloth of 12 cells that hangs from its upper edge, stiffness by `factor`, with a tolerance a hand would have.
fn hung(pattern: Pattern, factor: f64, scheme: Scheme) -> Piece {
    let numbers = [500.0, 10e-6].map(|k| k * factor);
    let params =
        format!("density = 0.15, young-warp = {:e}, poisson = 0.3, bending-warp = {:e}", numbers[0], numbers[1]);
    let surface = sheet(pattern, [12, 12], [0.2, 0.2]);
    let top = surface.points.iter().fold(0.0, |m: f64, p| m.max(p[1]));
    let mut piece = Piece::new(&surface, &params, move |p| p[1] > top - 1e-9, false);
    piece.integrator = Integrator::new(scheme, 1e-4, 300);
    let n = piece.system().nodes.len();
    piece.integrator.resize(n);
    piece.gravity = Vec3::new(0.0, -G, 0.0);
    piece
}

/// Steps and looks: the most that kinetic, elastic and potential energy rise over what they are at the start, J, and the number of
/// solves that did not converge.
fn rise(piece: &mut Piece, dt: f64, steps: usize, what: &str) -> (f64, usize) {
    let start: f64 = piece.energies().iter().sum();
    let (mut most, mut flagged) = (0.0_f64, 0);
    for _ in 0..steps {
        flagged += usize::from(!piece.step(dt).converged);
        let energies = piece.energies();
        assert!(energies.iter().all(|e| e.is_finite()), "{what}: {energies:?}");
        most = most.max(energies.iter().sum::<f64>() - start);
    }
    let nodes = &piece.system().nodes;
    assert!(nodes.x.iter().chain(&nodes.v).flatten().all(|c| c.is_finite()), "{what}");
    (most, flagged)
}

#[test]
fn from_the_softest_to_the_stiffest_at_every_step_energy_stays_bounded() {
    // J, what falls can gain: the weight over the cloth's height.
    let scale = 0.15 * 0.04 * G * 0.2;
    let mut table = String::new();
    for k in -6..=6 {
        for dt in [1e-4, 1e-3, 5e-3, 2e-2] {
            let what = format!("1e{k} {dt}");
            let mut piece = hung(Pattern::Alternating, 10_f64.powi(k), Scheme::BackwardEuler);
            let mut random = Random(1);
            piece.put(|p| Vec3::new(p[0], p[1], if p[1] < 0.2 - 1e-9 { 1e-3 * random.signed() } else { 0.0 }));
            let start: f64 = piece.energies()[1];
            let (most, flagged) = rise(&mut piece, dt, 60, &what);
            table += &format!(
                "{what}: rise {:.1e} of {scale:.1e} + {start:.1e} J, {flagged} of 60 solves stopped early\n",
                most
            );
            assert!(most <= 0.01 * (scale + start), "{what}: {most} J over {scale} + {start} J\n{table}");
        }
    }
    println!("{table}");
}

#[test]
fn other_schemes_stay_finite_where_they_are_allowed() {
    for (scheme, steps) in [(Scheme::Bdf2, 100), (Scheme::ImplicitMidpoint, 100)] {
        for factor in [1e-3, 1.0, 1e3] {
            for pattern in PATTERNS {
                let what = format!("{} {factor} {pattern:?}", scheme.name());
                let mut piece = hung(pattern, factor, scheme);
                let (most, _) = rise(&mut piece, 1e-3, steps, &what);
                println!("{what}: rise {most:.1e} J");
                assert!(most < 0.05 * 0.15 * 0.04 * G * 0.2, "{what}: {most}");
            }
        }
    }
}

#[test]
fn neighbours_of_a_million_times_the_mass_are_borne() {
    for pattern in PATTERNS {
        let mut piece = hung(pattern, 1.0, Scheme::BackwardEuler);
        let nodes = &mut piece.system().nodes;
        for i in (0..nodes.len()).step_by(7) {
            nodes.mass[i] *= 1e6;
        }
        piece.integrator.max_iterations = 5000;
        let all: f64 = piece.system().nodes.mass.iter().sum();
        let (most, flagged) = rise(&mut piece, 1e-3, 60, "mass ratio");
        println!("mass ratio {pattern:?}: rise {most:.1e} J of {:.1e}, {flagged} stopped early", all * G * 0.2);
        assert!(flagged == 0 && most < 0.01 * all * G * 0.2, "{pattern:?}: {most} {flagged}");
    }
}

#[test]
fn gravity_a_hundredfold_or_upside_down() {
    for gravity in [[0.0, -100.0 * G, 0.0], [0.0, G, 0.0], [G, 0.0, 0.0], [0.0, 0.0, -100.0 * G]] {
        let mut piece = hung(Pattern::Irregular, 1.0, Scheme::BackwardEuler);
        piece.gravity = gravity.into();
        let (most, _) = rise(&mut piece, 1e-3, 200, "gravity");
        let scale = 0.15 * 0.04 * 0.2 * gravity.iter().map(|g| g.abs()).sum::<f64>();
        assert!(most < 0.01 * scale, "{gravity:?}: {most} of {scale}");
    }
}

/// Where a free vertex in the middle of the sheet is.
fn middle(piece: &mut Piece) -> usize {
    let nodes = &piece.system().nodes;
    let off = |i: usize| (nodes.rest[i][0] - 0.1).hypot(nodes.rest[i][1] - 0.1);
    (0..nodes.len()).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap()
}

#[test]
fn collapsed_and_turned_over_triangles_recover_when_they_are_let_go() {
    for bending in ["coupled", "hinge", "none"] {
        for frame in ["polar", "edge", "green"] {
            for kind in ["collapsed", "turned over", "a point", "a line"] {
                let params = format!(
                    "density = 0.15, young-warp = 500, poisson = 0.3, bending-warp = 10e-6, damping-time = 2e-3, \
                     bending = \"{bending}\", frame = \"{frame}\""
                );
                let border = |p: Vec3| (0..2).any(|i| p[i] < 1e-9 || p[i] > 0.2 - 1e-9);
                let mut piece = Piece::new(&sheet(Pattern::Alternating, [8, 8], [0.2, 0.2]), &params, border, false);
                let at = middle(&mut piece);
                let nodes = &mut piece.system().nodes;
                let x = nodes.rest[at];
                for i in 0..nodes.len() {
                    let p = nodes.rest[i];
                    match kind {
                        // Onto a neighbour; over and beyond it; all that is free to one point, or to a line.
                        "collapsed" if i == at => nodes.x[i] = Vec3::new(x[0] + 0.025, x[1], 0.0),
                        "turned over" if i == at => nodes.x[i] = Vec3::new(x[0] + 0.06, x[1], 0.0),
                        "a point" if !border(p) => nodes.x[i] = x,
                        "a line" if !border(p) => nodes.x[i] = Vec3::new(x[0], p[1], 0.0),
                        _ => {}
                    }
                }
                let what = format!("{bending} {frame} {kind}");
                let start = piece.energies()[1];
                let (most, _) = rise(&mut piece, 1e-3, 600, &what);
                let left = piece.energies()[1];
                println!("{what}: from {start:.2e} to {left:.2e} J");
                assert!(most < 0.01 * start, "{what}: {most} over {start}");
                // Without stiffness out of its plane a sheet may keep a fold.
                assert!(bending == "none" || left < 1e-3 * start, "{what}: {left} of {start}");
            }
        }
    }
}

const SCENE: &str = r#"format = 1
gravity = [0, 0, -9.81]
[time]
duration = 0.005
integrator = "backward-euler"
[[body]]
name = "napkin"
mesh = "model.obj"
sheet = { warp = [1, 0, 0] }
material = { plugin = "cloth" }
"#;

#[test]
fn triangles_without_area_and_their_like_are_refused_by_line() {
    let square = "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 0 0.1 0\nf 1 2 3\nf 1 3 4\n";
    for (what, model, said) in [
        ("a line", format!("{square}v 0.05 0 0\nf 1 5 2\n"), &["model.obj", "8", "area"][..]),
        ("a corner twice", format!("{square}f 1 2 2\n"), &["model.obj", "7"]),
        ("two corners in one place", format!("{square}v 0 0 0\nf 1 7 2\n").replace("7", "5"), &["model.obj", "8"]),
        ("thinner than 1e-9", format!("{square}v 0.05 1e-12 0\nf 1 2 5\n"), &["model.obj", "8"]),
        ("the same triangle twice", format!("{square}f 1 2 3\n"), &["model.obj", "7"]),
    ] {
        let bench = Bench::new();
        bench.write("scene.toml", SCENE);
        bench.write("model.obj", model);
        let ran = bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]);
        println!("{what}: {}", ran.err);
        ran.expect(2).says(said);
        assert!(bench.names("out").is_empty(), "{what}: {:?}", bench.names("out"));
    }
    for (_, params, said) in [
        ("no weight", "density = -1", "density"),
        ("no stiffness", "young-warp = -5", "young-warp"),
        ("not definite", "young-warp = 100, young-weft = 500, poisson = 0.5", "positive definite"),
    ] {
        let bench = Bench::new();
        bench.write("scene.toml", SCENE.replace("\"cloth\"", &format!("\"cloth\", params = {{ {params} }}")));
        bench.write("model.obj", square);
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(2).says(&["scene.toml:10:", said]);
    }
    // One triangle alone, and one whose corners nobody else has, are cloth too.
    let bench = Bench::new();
    bench.write("scene.toml", SCENE);
    bench.write("model.obj", "v 0 0 0\nv 0.1 0 0\nv 0.1 0.1 0\nv 7 7 7\nf 1 2 3\n");
    bench.pliant(&["run", "scene.toml", "-q", "--out", "out"]).expect(0);
    bench.is_finite("out", "one triangle");
}
