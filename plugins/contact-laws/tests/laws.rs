//! Closed forms: the restitution of Hunt and Crossley, and steady friction and velocity steps of rate-and-state friction.

use pliant_contact_laws::{HuntCrossley, RateAndState};
use pliant_plugin_api::kit::{Candidate, Random, TestContactLaw};
use pliant_plugin_api::{AsContactLaw, ContactPoint, abi};

/// A law with numbers by parameter key.
fn law(candidate: &Candidate, numbers: &[(&str, f64)]) -> TestContactLaw {
    let params = candidate.params();
    let index = |key: &str| params.iter().position(|p: &abi::Param| Candidate::key(p) == key).unwrap();
    let numbers: Vec<(usize, f64)> = numbers.iter().map(|(key, value)| (index(key), *value)).collect();
    TestContactLaw::new(candidate.open(&numbers).unwrap()).unwrap()
}

fn hunt_crossley(numbers: &[(&str, f64)]) -> TestContactLaw {
    law(&Candidate::of::<AsContactLaw<HuntCrossley>>(), numbers)
}

fn rate_and_state(numbers: &[(&str, f64)]) -> TestContactLaw {
    law(&Candidate::of::<AsContactLaw<RateAndState>>(), numbers)
}

/// Speed at which a mass per area (kg/m^2) parts that meets the law at `speed` (m/s), by steps of the classical Runge-Kutta method.
fn rebound(law: &TestContactLaw, mass: f64, speed: f64, dt: f64) -> f64 {
    let acceleration = |gap: f64, gap_rate: f64| {
        let point = ContactPoint { gap, gap_rate, area: 1.0, dt, ..ContactPoint::default() };
        law.traction(point, &[]).unwrap().normal / mass
    };
    let (mut gap, mut v) = (-1e-300, -speed);
    while gap < 0.0 {
        let (k1, l1) = (v, acceleration(gap, v));
        let (k2, l2) = (v + 0.5 * dt * l1, acceleration(gap + 0.5 * dt * k1, v + 0.5 * dt * l1));
        let (k3, l3) = (v + 0.5 * dt * l2, acceleration(gap + 0.5 * dt * k2, v + 0.5 * dt * l2));
        let (k4, l4) = (v + dt * l3, acceleration(gap + dt * k3, v + dt * l3));
        gap += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        v += dt / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
    }
    v
}

/// Speed after an impact at `speed` with 3/2 c = `a`, exactly: energy balance over the path gives
/// `ln((1 + a v) / (1 - a v')) = a (v + v')`, whatever stiffness and exponent are.
fn exact_rebound(a: f64, speed: f64) -> f64 {
    let (mut low, mut high) = (0.0, speed.min(1.0 / a));
    let error = |out: f64| ((1.0 + a * speed) / (1.0 - a * out)).ln() - a * (speed + out);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if error(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
fn a_mass_parts_as_the_closed_form_says_and_at_1_minus_c_v_where_it_is_slow() {
    let mut random = Random(7);
    for _ in 0..40 {
        let (c, exponent) = (0.05 + 2.0 * random.unit(), 1.0 + 2.0 * random.unit());
        let speed = 0.02 + 0.5 * random.unit();
        // The stiffness is chosen for an impact of about 10 ms.
        let law = hunt_crossley(&[
            ("stiffness", 1e5 * 500_f64.powf(exponent - 1.0)),
            ("exponent", exponent),
            ("dissipation", c),
        ]);
        let found = rebound(&law, 1.0, speed, 2e-6);
        let exact = exact_rebound(1.5 * c, speed);
        // A step in which the surfaces part is cut off nowhere: the error is that of one step.
        assert!((found / exact - 1.0).abs() < 1e-3, "c {c}, n {exponent}, {speed} m/s: {found} instead of {exact}");
        let slow = 1e-3;
        let restitution = exact_rebound(1.5 * c, slow) / slow;
        assert!(
            (restitution - (1.0 - c * slow)).abs() < 2.0 * (c * slow).powi(2),
            "{restitution} at c v = {}",
            c * slow
        );
    }
}

const PRESSURE: f64 = 1e4;
const MU: f64 = 0.6;
const A: f64 = 0.012;
const B: f64 = 0.017;
const DISTANCE: f64 = 2e-5;
const V0: f64 = 1e-6;

/// Rate-and-state friction with the constants above, where a depth of 1 mm gives the pressure above.
fn friction() -> TestContactLaw {
    let stiffness = PRESSURE / 1e-3;
    let own = [("friction", MU), ("a", A), ("b", B), ("slip-distance", DISTANCE), ("reference-speed", V0)];
    let all: Vec<(&str, f64)> = own.into_iter().chain([("stiffness", stiffness), ("dissipation", 0.0)]).collect();
    rate_and_state(&all)
}

fn sliding(speed: f64, dt: f64) -> ContactPoint {
    ContactPoint { gap: -1e-3, slip_rate: [0.6 * speed, -0.8 * speed], area: 1e-6, dt, ..ContactPoint::default() }
}

/// Coefficient of friction of a state.
fn coefficient(law: &TestContactLaw, speed: f64, history: &[f64]) -> f64 {
    let t = law.traction(sliding(speed, 1e-3), history).unwrap();
    (t.tangential[0] * t.tangential[0] + t.tangential[1] * t.tangential[1]).sqrt() / t.normal
}

#[test]
fn steady_friction_is_that_of_the_closed_form_over_eight_decades() {
    let law = friction();
    for decade in -9..0 {
        let speed = 10_f64.powi(decade);
        let mut history = [0.0];
        // Slip of a hundred distances, in steps that are not small against one.
        let dt = 0.5 * DISTANCE / speed;
        for _ in 0..200 {
            law.advance(&[sliding(speed, dt)], &mut history, 1).unwrap();
        }
        let expected = MU + (A - B) * (speed / V0).ln();
        let found = coefficient(&law, speed, &history);
        assert!((found - expected).abs() < 1e-12, "{speed} m/s: {found} instead of {expected}");
    }
}

/// After a step of the speed from v1 to v2 friction jumps by a ln(v2/v1) and decays to its steady value as
/// `theta = Dc/v2 + (Dc/v1 - Dc/v2) exp(-x/Dc)` says, x the slip since the step.
#[test]
fn a_velocity_step_has_the_direct_effect_and_decays_over_the_slip_distance() {
    let law = friction();
    for (v1, v2) in [(1e-6_f64, 1e-5_f64), (1e-4, 1e-6), (2e-3, 3e-3)] {
        let mut history = [(V0 / v1).ln()];
        let before = coefficient(&law, v1, &history);
        let after = coefficient(&law, v2, &history);
        assert!((after - before - A * (v2 / v1).ln()).abs() < 1e-12, "{v1} to {v2} m/s");
        let dt = 0.07 * DISTANCE / v2;
        for step in 1..=100 {
            law.advance(&[sliding(v2, dt)], &mut history, 1).unwrap();
            let slip = v2 * dt * f64::from(step);
            let theta = DISTANCE / v2 + (DISTANCE / v1 - DISTANCE / v2) * (-slip / DISTANCE).exp();
            let expected = MU + A * (v2 / V0).ln() + B * (V0 * theta / DISTANCE).ln();
            let found = coefficient(&law, v2, &history);
            assert!((found - expected).abs() < 1e-11, "{v1} to {v2} m/s after {slip} m: {found}, not {expected}");
        }
    }
}

#[test]
fn a_contact_at_rest_ages_by_the_time() {
    let law = friction();
    let mut history = [0.0];
    let rest = ContactPoint { slip_rate: [0.0; 2], ..sliding(0.0, 0.1) };
    for _ in 0..1000 {
        law.advance(&[rest], &mut history, 1).unwrap();
    }
    let theta = DISTANCE / V0 + 100.0;
    assert!((history[0] - (V0 * theta / DISTANCE).ln()).abs() < 1e-12, "{history:?}");
    let at_rest = law.traction(rest, &history).unwrap();
    assert_eq!(at_rest.tangential, [0.0; 2]);
}
