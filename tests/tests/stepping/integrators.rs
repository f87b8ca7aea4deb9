//! R09: the integrators on one oscillator, the mass-spring plugin's own spring, against the closed forms.

use pliant_host::Material;
use pliant_mesh::geometry::Vec3;
use pliant_plugin_api::abi;
use pliant_solver::{Constraint, Frequencies, Integrator, Loads, Nodes, Pool, Scheme, StepLimit, StepTime, System};
use pliant_tests::library;

/// A mass on one spring along x, held at the other end: w = 100 rad/s.
struct Oscillator {
    system: System,
    w: f64,
}

const LENGTH: f64 = 0.01;

impl Oscillator {
    fn new(zeta: f64) -> Self {
        let w = 100.0;
        let number = |value| pliant_host::ParamValue::Number(value);
        let library = library("mass-spring");
        let info = &library.plugins()[0];
        let place = |key: &str| info.params.iter().position(|p| p.key == key).unwrap();
        // damping time of a spring: c = tau k, so zeta = tau w / 2.
        let settings = vec![
            (place("young"), number(1e4)),
            (place("density"), number(1.0)),
            (place("damping-time"), number(2.0 * zeta / w)),
        ];
        let material = Material::open(library, "mass-spring", &settings, 1.0).unwrap();
        let mut system = System::new(Box::new(material));
        system.nodes = Nodes::at_rest(vec![Vec3::zeros(), Vec3::new(LENGTH, 0.0, 0.0)]);
        system.nodes.constraint[0] = Constraint::Fixed;
        let stiffness = 0.4 * 1e4 * LENGTH;
        for set in &mut system.sets {
            let kind = set.request().kind;
            let list = set.list_mut();
            if kind == abi::POINT {
                list.nodes = vec![0, 1];
                list.measure = vec![1.0, stiffness / (w * w)];
            } else {
                list.nodes = vec![0, 1];
                list.family = vec![abi::STRUCTURAL];
                list.measure = vec![1.0];
            }
        }
        system.prepare().unwrap();
        Self { system, w }
    }

    /// Where one step of `dt` takes displacement `u` and velocity `v`.
    fn step(&mut self, scheme: Scheme, dt: f64, u: f64, v: f64) -> (f64, f64) {
        let pool = Pool::new(1);
        if scheme.is_implicit() {
            self.system.enable_matrix();
        }
        let nodes = &mut self.system.nodes;
        nodes.x = vec![Vec3::zeros(), Vec3::new(LENGTH + u, 0.0, 0.0)];
        nodes.v = vec![Vec3::zeros(), Vec3::new(v, 0.0, 0.0)];
        let mut integrator = Integrator::new(scheme, 1e-15, 100);
        integrator.resize(2);
        let report =
            integrator.step(&pool, &mut self.system, &Loads::default(), StepTime { start: 0.0, dt }, 1).unwrap();
        assert!(report.converged);
        let nodes = &self.system.nodes;
        assert_eq!((nodes.x[0], nodes.v[0]), (Vec3::zeros(), Vec3::zeros()), "the held end stays");
        (nodes.x[1][0] - LENGTH, nodes.v[1][0])
    }

    /// The largest |eigenvalue| of the map of one step, from what it does to (u, 0) and (0, v). The spring is linear along
    /// its axis, so any amplitude does.
    fn amplification(&mut self, scheme: Scheme, dt: f64) -> f64 {
        let (size, speed) = (0.1 * LENGTH, 0.1 * LENGTH * self.w);
        let (a, c) = self.step(scheme, dt, size, 0.0);
        let (b, d) = self.step(scheme, dt, 0.0, speed);
        let [a, b, c, d] = [a / size, b / size, c / speed, d / speed];
        let (half_trace, determinant) = (0.5 * (a + d), a * d - b * c);
        let inner = half_trace * half_trace - determinant;
        if inner <= 0.0 { determinant.sqrt() } else { half_trace.abs() + inner.sqrt() }
    }
}

#[test]
fn r09_amplification_per_step() {
    let mut oscillator = Oscillator::new(0.0);
    let w = oscillator.w;
    for wdt in [0.1, 0.5, 1.0, 1.9, 2.1, 10.0_f64] {
        let symplectic = if wdt <= 2.0 {
            1.0
        } else {
            let h = 0.5 * (wdt * wdt - 2.0);
            h + (h * h - 1.0).sqrt()
        };
        for (scheme, expected) in [
            (Scheme::ExplicitEuler, (1.0 + wdt * wdt).sqrt()),
            (Scheme::SymplecticEuler, symplectic),
            (Scheme::BackwardEuler, 1.0 / (1.0 + wdt * wdt).sqrt()),
        ] {
            let found = oscillator.amplification(scheme, wdt / w);
            let off = (found - expected).abs() / expected.max(1.0);
            assert!(off < 1e-10, "{} at w dt = {wdt}: {found}, expected {expected}", scheme.name());
        }
    }
}

/// s, the step at which the amplification passes 1, by bisection.
fn observed_limit(oscillator: &mut Oscillator, scheme: Scheme) -> f64 {
    let (mut stable, mut growing) = (1e-6 / oscillator.w, 10.0 / oscillator.w);
    for _ in 0..60 {
        let middle = 0.5 * (stable + growing);
        if oscillator.amplification(scheme, middle) <= 1.0 + 1e-12 { stable = middle } else { growing = middle }
    }
    stable
}

#[test]
fn r09_predicted_step_limits_are_the_observed_ones() {
    let pool = Pool::new(1);
    for zeta in [0.01, 0.1, 0.5, 0.9] {
        let mut oscillator = Oscillator::new(zeta);
        let w = oscillator.w;
        let found = Frequencies::of(&mut oscillator.system, &pool).unwrap();
        assert!((found.stiffness / w - 1.0).abs() < 1e-9 && (found.damping / (2.0 * zeta * w) - 1.0).abs() < 1e-9);
        for (scheme, formula) in
            [(Scheme::ExplicitEuler, 2.0 * zeta), (Scheme::SymplecticEuler, 2.0 * ((1.0 + zeta * zeta).sqrt() - zeta))]
        {
            let StepLimit::At(predicted) = found.limit(scheme) else { panic!("{} has a limit", scheme.name()) };
            let observed = observed_limit(&mut oscillator, scheme);
            assert!((predicted * w / formula - 1.0).abs() < 1e-9, "{}: {predicted}", scheme.name());
            assert!((observed / predicted - 1.0).abs() < 1e-6, "{}: {observed} {predicted}", scheme.name());
        }
    }
    let mut undamped = Oscillator::new(0.0);
    let found = Frequencies::of(&mut undamped.system, &pool).unwrap();
    assert_eq!(found.limit(Scheme::ExplicitEuler), StepLimit::At(0.0), "the printed scheme always grows");
    assert_eq!(found.limit(Scheme::BackwardEuler), StepLimit::None);
}

#[test]
fn r14_backward_euler_decays_as_its_formula_says() {
    let mut oscillator = Oscillator::new(0.0);
    // A 25 Hz mode at 1 ms: w dt = 0.15708; the same w dt here.
    let wdt = 2.0 * std::f64::consts::PI * 25.0 * 1e-3;
    let per_step = oscillator.amplification(Scheme::BackwardEuler, wdt / oscillator.w);
    let steps_per_period = 2.0 * std::f64::consts::PI / wdt.atan();
    let per_period = per_step.powf(steps_per_period);
    assert!((per_period / 0.611724 - 1.0).abs() < 1e-3, "{per_period}");
}

#[test]
fn free_fall_is_exact_for_each_scheme() {
    for (scheme, expected) in [
        (Scheme::ExplicitEuler, |t: f64, dt: f64| 0.5 * t * (t - dt)),
        (Scheme::SymplecticEuler, |t: f64, dt: f64| 0.5 * t * (t + dt)),
        (Scheme::BackwardEuler, |t: f64, dt: f64| 0.5 * t * (t + dt)),
    ] as [(Scheme, fn(f64, f64) -> f64); 3]
    {
        let pool = Pool::new(1);
        let mut oscillator = Oscillator::new(0.0);
        oscillator.system.nodes.constraint[0] = Constraint::Free;
        if scheme.is_implicit() {
            oscillator.system.enable_matrix();
        }
        let mut integrator = Integrator::new(scheme, 1e-14, 100);
        integrator.resize(2);
        let (dt, g) = (1e-3, -9.81);
        let loads = Loads { gravity: Vec3::new(0.0, 0.0, g), ..Loads::default() };
        for i in 0..100 {
            integrator
                .step(&pool, &mut oscillator.system, &loads, StepTime { start: f64::from(i) * dt, dt }, 1)
                .unwrap();
        }
        for x in &oscillator.system.nodes.x {
            let fall = g * expected(0.1, dt);
            assert!((x[2] / fall - 1.0).abs() < 1e-9, "{}: {} {fall}", scheme.name(), x[2]);
        }
    }
}
