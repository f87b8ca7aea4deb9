//! Bending to and fro with friction between the yarns: the loop of moment against curvature, and what is kept of it.

use pliant_mesh::generate::Pattern;
use pliant_solver::{Pool, Vec3};
use pliant_tests::NOW;
use pliant_tests::cloth::{Piece, sheet};

/// N m, N and 1/m
const D: f64 = 15e-6;
const LOOP: f64 = 1.4e-3;
const SLIPS: f64 = 10.0;

/// A cylinder of curvature `k` (1/m) along x.
fn bent(rest: Vec3, k: f64) -> Vec3 {
    if k == 0.0 {
        return rest;
    }
    let (sine, cosine) = (k * rest[0]).sin_cos();
    Vec3::new(sine / k, rest[1], (1.0 - cosine) / k)
}

/// N, the moment by width of a sheet that is bent to each of `curvatures` in turn.
fn moments(bending: &str, pattern: Pattern, hysteresis: f64, curvatures: &[f64]) -> Vec<f64> {
    let params = format!(
        "density = 0.2, young-warp = 1e-3, poisson = 0, damping-time = 0, bending = \"{bending}\", \
         bending-warp = {D:e}, bending-hysteresis = {hysteresis:e}, slip-curvature = {SLIPS}"
    );
    let surface = sheet(pattern, [16, 4], [0.1, 0.025]);
    let mut piece = Piece::new(&surface, &params, |_| false, false);
    let area = surface.points.iter().fold(0.0, |m: f64, p| m.max(p[1])) * 0.1;
    let mut found = Vec::new();
    for &k in curvatures {
        let turn = |p: Vec3| (bent(p, k + 1e-4) - bent(p, k - 1e-4)).map(|c| c / 2e-4);
        piece.put(|p| bent(p, k));
        let system = piece.system();
        let mut force = vec![Vec3::zeros(); system.nodes.len()];
        system.forces(&Pool::new(1), None, NOW, &mut force).unwrap();
        let work: f64 = force.iter().zip(&system.nodes.rest).map(|(f, rest)| f.dot(&turn(*rest))).sum();
        found.push(-work / area);
        system.advance(&Pool::new(1), NOW).unwrap();
    }
    found
}

/// Up to 40, down to -40 and up again, twice, in steps of 1/m.
fn to_and_fro() -> Vec<f64> {
    let up = |from: i32, to: i32| (from..to).map(f64::from).collect::<Vec<_>>();
    let down: Vec<f64> = up(-40, 40).into_iter().map(|k| -k).collect();
    [up(0, 40), down.clone(), up(-40, 40), down, up(-40, 41)].concat()
}

#[test]
fn the_loop_closes_and_is_as_wide_as_2hb() {
    let path = to_and_fro();
    for (bending, pattern) in
        [("hinge", Pattern::Alternating), ("coupled", Pattern::Alternating), ("hinge", Pattern::Regular)]
    {
        let found = moments(bending, pattern, LOOP, &path);
        let plain = moments(bending, pattern, 0.0, &path);
        let at = |k: f64, from: usize| from + path[from..].iter().position(|p| *p == k).unwrap();
        // Down through zero, and up through zero.
        let (falls, rises) = (at(0.0, 41), at(0.0, 121));
        assert!(plain[falls].abs() < 1e-9 * D && plain[rises].abs() < 1e-9 * D, "without friction there is no loop");
        // A free border bears nothing: half a row of hinges is missing at either end, as it is of the rigidity.
        let share = plain[at(10.0, 0)] / (10.0 * D);
        let width = found[rises] - found[falls];
        println!("{bending} {pattern:?}: loop of {width} N, of {}", LOOP * share);
        assert!((width / (LOOP * share) - 1.0).abs() < 0.03, "{bending} {pattern:?}: {width} N");
        // Before it slides it is stiffer by what friction bears over the curvature it slides at.
        let steep = (found[5] - plain[5]) / (5.0 * 0.5 * LOOP / SLIPS * share);
        assert!((steep - 1.0).abs() < 0.03, "{bending} {pattern:?}: {steep}");
        // The second round is the first.
        let (first, second) = (&found[40..200], &found[200..360]);
        let most = found.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
        assert!(first.iter().zip(second).all(|(a, b)| (a - b).abs() < 1e-9 * most), "{bending} {pattern:?}");
        // What it takes from who bends it: 4 M (k - k_s) of a round.
        let lost: f64 = (40..200).map(|i| 0.5 * (found[i] + found[i + 1]) * (path[i + 1] - path[i])).sum();
        let expected = 4.0 * 0.5 * LOOP * share * (40.0 - SLIPS);
        assert!((lost / expected - 1.0).abs() < 0.05, "{bending} {pattern:?}: {lost} N/m, of {expected}");
    }
}

#[test]
fn a_fabric_gives_its_loop_where_it_was_measured() {
    let open = |params: &str| {
        let bench = pliant_tests::Bench::new();
        bench.write("scene.toml", format!(
            "format = 1\ngravity = [0, 0, -9.81]\n[time]\nduration = 0.002\nintegrator = \"backward-euler\"\n[[body]]\nshape = {{ kind = \"sheet\", cells = 4, size = [0.1, 0.1, 0] }}\n\
             sheet = {{}}\nmaterial = {{ plugin = \"cloth\", params = {{ {params} }} }}\n"
        ));
        bench.pliant(&["run", "scene.toml", "-q", "--out", "out"])
    };
    open("fabric = \"kes-denim-e\", density = 0.3, bending-hysteresis = -1").expect(0);
    open("fabric = \"denim\", bending-hysteresis = -1")
        .expect(2)
        .says(&["the hysteresis of fabric `denim` is not known"]);
}
