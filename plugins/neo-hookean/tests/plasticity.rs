//! Plastic flow against the one-dimensional law, simple shear, and what flow must keep.

use pliant_neo_hookean::NeoHookean;
use pliant_plugin_api::kit::{self, Body, Candidate, Random, Verdict, cases};
use pliant_plugin_api::{AsMaterial, abi};

/// A clay, and what a test compares with its law.
#[derive(Clone, Copy, Debug)]
struct Clay {
    poisson: f64,
    yield_strain: f64,
    hardening: f64,
}

const CLAYS: [Clay; 4] = [
    Clay { poisson: 0.0, yield_strain: 1e-4, hardening: 0.0 },
    Clay { poisson: 0.3, yield_strain: 2e-4, hardening: 0.1 },
    Clay { poisson: 0.45, yield_strain: 5e-5, hardening: 1.0 },
    Clay { poisson: 0.49, yield_strain: 1e-4, hardening: 0.01 },
];

impl Clay {
    fn material(&self, more: &[(&str, f64)]) -> NeoHookean {
        let own = [("poisson", self.poisson), ("yield-strain", self.yield_strain), ("hardening", self.hardening)];
        kit::material(&[&own[..], more].concat()).expect("valid parameters")
    }
}

/// A block of one cell at rest: every element of it deforms alike.
fn one_cell(material: &NeoHookean) -> Body {
    let block = kit::block([1, 1, 1], 1.0, abi::STRUCTURAL);
    Body::new(material, block.rest.clone(), |r| block.elements(r.kind)).expect("a sound block")
}

fn deform(body: &mut Body, f: [[f64; 3]; 3]) {
    body.x = body.rest.iter().map(|x| f.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])).collect();
}

/// Force on the face x = 1, and on y = 1, along their normals and along x, N.
struct FaceForces {
    xx: f64,
    yy: f64,
    xy: f64,
}

fn faces(body: &Body, material: &NeoHookean) -> FaceForces {
    let force = body.forces(material).expect("finite forces");
    let on = |axis: usize, along: usize| -> f64 {
        let at = body.rest.iter().zip(&force).filter(|(x, _)| x[axis] > 0.5);
        -at.map(|(_, f)| f[along]).sum::<f64>()
    };
    FaceForces { xx: on(0, 0), yy: on(1, 1), xy: on(1, 0) }
}

/// The zero of a rising function between two values.
fn zero(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (low, high);
    assert!(f(low) < 0.0 && f(high) > 0.0, "{} {}", f(low), f(high));
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Draws the body along x to a logarithmic strain with free sides, flowing until it flows no more. Gives the lateral strain.
fn draw(body: &mut Body, material: &NeoHookean, strain: f64) -> f64 {
    let mut lateral = 0.0;
    for _ in 0..200 {
        let stretched = |lateral: f64| {
            let mut trial = body.clone();
            let (l, t) = (f64::exp(strain), f64::exp(lateral));
            deform(&mut trial, [[l, 0.0, 0.0], [0.0, t, 0.0], [0.0, 0.0, t]]);
            trial
        };
        lateral = zero(-1.0, 1.0, |lateral| faces(&stretched(lateral), material).yy);
        *body = stretched(lateral);
        let next = body.next_histories(material, usize::MAX).expect("finite");
        if body.histories().eq(next.iter().map(Vec::as_slice)) {
            break;
        }
        body.advance(material).expect("finite");
    }
    lateral
}

/// The axial strain at which the drawn body is free of stress.
fn unloaded(body: &Body, material: &NeoHookean) -> f64 {
    let force = |strain: f64| {
        let sides = zero(-1.0, 1.0, |lateral| {
            let (l, t) = (f64::exp(strain), f64::exp(lateral));
            let mut at = body.clone();
            deform(&mut at, [[l, 0.0, 0.0], [0.0, t, 0.0], [0.0, 0.0, t]]);
            faces(&at, material).yy
        });
        let (l, t) = (f64::exp(strain), f64::exp(sides));
        let mut trial = body.clone();
        deform(&mut trial, [[l, 0.0, 0.0], [0.0, t, 0.0], [0.0, 0.0, t]]);
        faces(&trial, material).xx
    };
    zero(-0.9, 0.9, force)
}

/// Determinants of Fp of all elements less 1, the largest.
fn volume_change(body: &Body) -> f64 {
    let mut worst = 0.0_f64;
    for history in body.histories().filter(|h| !h.is_empty()) {
        let m = history.len() / 10;
        for e in 0..m {
            let p = |s: usize| history[s * m + e] + if s.is_multiple_of(4) { 1.0 } else { 0.0 };
            let minor = |a: usize, b: usize, c: usize, d: usize| p(a) * p(d) - p(b) * p(c);
            let det = p(0) * minor(4, 5, 7, 8) - p(1) * minor(3, 5, 6, 8) + p(2) * minor(3, 4, 6, 7);
            worst = worst.max((1.0 / det - 1.0).abs());
        }
    }
    worst
}

/// At small strains the plastic strain of a bar that was drawn to e is (e - yield) / (1 + hardening), and that is what is left of e.
#[test]
fn a_drawn_bar_keeps_what_the_one_dimensional_law_says() {
    for clay in CLAYS {
        let material = clay.material(&[]);
        for strain in [5e-4, 1e-3, -1e-3] {
            let mut body = one_cell(&material);
            draw(&mut body, &material, strain);
            let set = unloaded(&body, &material);
            let law = (strain.abs() - clay.yield_strain) / (1.0 + clay.hardening) * strain.signum();
            // The law is one of small strains: what it leaves out is of the order of the strain.
            let tolerance = 5.0 * strain.abs();
            assert!((set / law - 1.0).abs() < tolerance, "{clay:?} {strain}: {set:.6e} by the law {law:.6e}");
            assert!(volume_change(&body) < 1e-12);
        }
    }
}

/// Below yield nothing is left, and loading to the same strain again changes nothing.
#[test]
fn a_bar_below_yield_is_elastic_and_a_second_loading_adds_nothing() {
    for clay in CLAYS {
        let material = clay.material(&[]);
        let mut body = one_cell(&material);
        draw(&mut body, &material, 0.9 * clay.yield_strain);
        assert!(body.histories().flatten().all(|h| *h == 0.0), "{clay:?}");
        draw(&mut body, &material, 10.0 * clay.yield_strain);
        let once = unloaded(&body, &material);
        let mut again = body.clone();
        draw(&mut again, &material, 0.5 * (once + 10.0 * clay.yield_strain));
        draw(&mut again, &material, 10.0 * clay.yield_strain);
        let twice = unloaded(&again, &material);
        assert!((twice - once).abs() < 1e-6 * once, "{clay:?}: {once:.9e} {twice:.9e}");
    }
}

/// In simple shear by g the plastic shear is (g - 2 (1 + nu) yield / sqrt 3) / (1 + 2 (1 + nu) hardening / 3) at small strains.
#[test]
fn sheared_clay_keeps_what_the_law_of_simple_shear_says() {
    for clay in CLAYS {
        let material = clay.material(&[]);
        for shear in [1e-3, 2e-3] {
            let mut body = one_cell(&material);
            for step in 1..=20 {
                let g = shear * f64::from(step) / 20.0;
                deform(&mut body, [[1.0, g, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
                body.advance(&material).expect("finite");
            }
            let stress = |g: f64| {
                let mut at = body.clone();
                deform(&mut at, [[1.0, g, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
                faces(&at, &material).xy
            };
            let set = zero(-0.1, 0.1, stress);
            let compliance = 2.0 * (1.0 + clay.poisson);
            let law =
                (shear - compliance * clay.yield_strain / 3.0_f64.sqrt()) / (1.0 + compliance * clay.hardening / 3.0);
            assert!((set / law - 1.0).abs() < 5.0 * shear, "{clay:?} {shear}: {set:.6e} by the law {law:.6e}");
        }
    }
}

/// With a flow time, strain beyond yield decays by dt / (dt + flow time) in a step, whatever the law is otherwise.
#[test]
fn a_flow_time_delays_the_flow() {
    let clay = CLAYS[1];
    let (slow, fast) = (clay.material(&[("flow-time", 9e-3)]), clay.material(&[]));
    let shear = [[1.0, 1e-3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let flowed = |material: &NeoHookean| {
        let mut body = one_cell(material);
        deform(&mut body, shear);
        body.advance(material).expect("finite");
        body.histories().last().map(|h| h[h.len() - 1]).expect("a history")
    };
    let ratio = flowed(&slow) / flowed(&fast);
    assert!((ratio - 0.1).abs() < 1e-12, "{ratio}");
}

/// Random loading far beyond yield: the volume is kept to 1e-12, and energy is only ever taken away.
#[test]
fn any_loading_keeps_volume_and_dissipates() {
    let mut random = Random(7);
    for clay in CLAYS {
        let clay = Clay { yield_strain: 100.0 * clay.yield_strain, ..clay };
        let material = clay.material(&[]);
        let block = kit::block([2, 2, 2], 0.5, abi::STRUCTURAL);
        let mut body = Body::new(&material, block.rest.clone(), |r| block.elements(r.kind)).expect("a sound block");
        let (mut dissipated, mut stored) = (0.0, 0.0);
        for _ in 0..2000 {
            for (x, rest) in body.x.iter_mut().zip(&block.rest) {
                // Up to a third of an edge: some elements are inverted.
                *x = [0, 1, 2].map(|i| rest[i] + 0.17 * random.signed());
            }
            let before = body.energy(&material).expect("finite");
            body.advance(&material).expect("finite");
            let after = body.energy(&material).expect("finite");
            assert!(after <= before * (1.0 + 1e-12), "{clay:?}: {before:e} {after:e}");
            dissipated += before - after;
            stored += after;
        }
        // Of the clay that hardens most, nearly nothing flows any more in the end.
        assert!(dissipated > 1e-4 * stored, "{clay:?}: {dissipated:e} of {stored:e}");
        assert!(volume_change(&body) < 1e-12, "{clay:?}: {:e}", volume_change(&body));
    }
}

#[test]
fn the_suite_tests_the_flow_and_an_elastic_solid_has_no_history() {
    let candidate = Candidate::of::<AsMaterial<NeoHookean>>();
    for name in ["advance-dissipates", "advance-is-objective"] {
        let all = cases(kit::Kind::Material);
        let case = all.iter().find(|case| case.name == name).expect("a case");
        assert_eq!(case.run(&candidate), Verdict::Passed, "{name}");
    }
    let elastic: NeoHookean = kit::material(&[]).expect("defaults");
    assert!(one_cell(&elastic).histories().all(<[f64]>::is_empty));
    assert!(!one_cell(&elastic).has(abi::HAS_HISTORY));
}
