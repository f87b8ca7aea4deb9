//! A cantilever under its own weight with the projected Laplacian, against the exact heavy elastica (R06): at rest, and let fall and
//! swing out in steps of backward Euler.

#![allow(clippy::print_stdout, reason = "the table of errors")]

use pliant_mesh::generate::Pattern;
use pliant_mesh::geometry::Vec3;
use pliant_tests::cloth::{G, PATTERNS, Piece, sheet};

/// Density, kg/m^2, and length, m.
const STRIP: [f64; 2] = [0.2, 0.2];

/// A strip clamped at x = 0, `n` cells long, of dimensionless load `gamma`.
fn strip(pattern: Pattern, n: u32, gamma: f64) -> Piece {
    held(pattern, n, 0, gamma)
}

/// The same with `more` cells before that are held altogether, in the place of the clamp.
fn held(pattern: Pattern, n: u32, more: u32, gamma: f64) -> Piece {
    let [rho, l] = STRIP;
    let (rigidity, cell) = (rho * G * l.powi(3) / gamma, l / f64::from(n));
    let high = 4.0 * cell * if pattern == Pattern::Equilateral { 0.75_f64.sqrt() } else { 1.0 };
    let params = format!(
        "density = {rho}, young-warp = 2000, poisson = 0, bending = \"projected-laplacian\", bending-warp = {rigidity}"
    );
    let before = f64::from(more) * cell;
    let surface = sheet(pattern, [n + more, 4], [l + before, high]);
    let mut piece = Piece::new(&surface, &params, |p| p[0] < before + 1e-9, more == 0);
    piece.gravity = Vec3::new(0.0, 0.0, -G);
    piece
}

/// How far the tip is from where it should be, in lengths.
fn error(piece: &mut Piece, [h, w]: [f64; 2]) -> f64 {
    let l = STRIP[1];
    let tip = piece.mean(|p| p[0] > l - 1e-9);
    (-tip[2] / l - h).hypot(tip[0] / l - w)
}

/// What is seen, in lengths, of 16 cells and no less of 32: it does not converge but on equilateral triangles, and along the
/// diagonals of a grid bending goes with twist, so that a regular strip is up to a quarter too soft.
#[test]
fn at_rest_it_is_off_by_what_the_mesh_makes_of_it() {
    let seen = [
        (Pattern::Regular, [0.03, 0.065, 0.02]),
        (Pattern::Alternating, [0.01, 0.03, 0.02]),
        (Pattern::Equilateral, [1.5e-3, 4e-3, 2e-3]),
        (Pattern::Irregular, [0.025, 0.05, 0.02]),
    ];
    let tips = [(1.0, [0.1234714, 0.9912464]), (10.0, [0.7001997, 0.6563538]), (100.0, [0.9375239, 0.1592234])];
    for (pattern, most) in seen {
        for ((gamma, tip), most) in tips.into_iter().zip(most) {
            let found = [16, 32].map(|n| {
                let mut piece = strip(pattern, n, gamma);
                piece.settle(1e-8);
                error(&mut piece, tip)
            });
            println!("{pattern:?} {gamma}: {found:.5?}");
            assert!(found.iter().all(|e| *e < most), "{pattern:?} {gamma}: {found:?}");
        }
    }
}

#[test]
fn it_swings_out_to_the_same_rest() {
    for pattern in PATTERNS {
        let mut still = strip(pattern, 16, 10.0);
        still.settle(1e-8);
        let mut moving = strip(pattern, 16, 10.0);
        let mut fastest = 0.0;
        for _ in 0..1000 {
            fastest = moving.step(1e-2).max_speed;
        }
        let off = error(&mut moving, [0.0, 0.0]) - error(&mut still, [0.0, 0.0]);
        println!("{pattern:?}: {off:.1e} lengths from rest, {fastest:.1e} m/s");
        assert!(off.abs() < 1e-4 && fastest < 2e-3, "{pattern:?}: {off} {fastest}");
    }
}

#[test]
fn what_is_held_altogether_clamps_where_it_ends() {
    let tip = |mut piece: Piece| {
        piece.settle(1e-8);
        let far = piece.system().nodes.rest.iter().fold(0.0, |m: f64, x| m.max(x[0]));
        piece.mean(|p| p[0] > far - 1e-9)[2] / STRIP[1]
    };
    for pattern in [Pattern::Regular, Pattern::Alternating] {
        let [clamped, walled] = [0, 2].map(|more| tip(held(pattern, 16, more, 1.0)));
        println!("{pattern:?}: {clamped:.6} clamped, {walled:.6} held over two cells");
        assert!((clamped / walled - 1.0).abs() < 1e-4, "{pattern:?}: {clamped} {walled}");
    }
}
