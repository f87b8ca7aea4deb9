//! Which velocities a material sees in `forces`, as `pliant.h` and docs/plugins.md say.

use super::*;
use crate::elements::ElementList;
use crate::force_model::{ElementCall, ForceModel};
use crate::matrix::Matrix;
use crate::nodes::Nodes;
use pliant_plugin_api::{ElementRequest, TangentScale, abi};
use std::sync::{Arc, Mutex};

/// Damping between the two nodes, N s/m.
const DAMPING: f64 = 3.0;
/// Mass of each node, kg.
const MASS: f64 = 0.5;
/// Velocities of the nodes at the beginning, along x, m/s.
const SPEED: f64 = 2.0;

/// A damper between two nodes, which writes down the velocity of the second one along x in each call of `forces`.
struct Damper {
    requests: [ElementRequest; 1],
    seen: Arc<Mutex<Vec<f64>>>,
}

impl ForceModel for Damper {
    fn name(&self) -> &str {
        "damper"
    }

    fn requests(&self) -> &[ElementRequest] {
        &self.requests
    }

    fn rest(&self, _: &ElementCall<'_>, _: &mut [f64]) -> Result<(), ForceError> {
        Ok(())
    }

    fn mass(&self, _: &ElementCall<'_>, _: &mut [f64]) -> Result<(), ForceError> {
        Ok(())
    }

    fn energy(&self, _: &ElementCall<'_>) -> Result<f64, ForceError> {
        Ok(0.0)
    }

    fn forces(&self, call: &ElementCall<'_>, out: &mut [[f64; 3]]) -> Result<(), ForceError> {
        self.seen.lock().expect("no panic").push(call.v[1][0]);
        for i in 0..3 {
            let pull = DAMPING * (call.v[1][i] - call.v[0][i]);
            (out[0][i], out[1][i]) = (out[0][i] + pull, out[1][i] - pull);
        }
        Ok(())
    }

    fn tangent(
        &self,
        _: &ElementCall<'_>,
        tangent: TangentScale,
        slots: &[u32],
        first: usize,
        values: &mut [[f64; 9]],
    ) -> Result<(), ForceError> {
        for (slot, sign) in slots.iter().zip([1.0, -1.0, 1.0]) {
            let block = &mut values[(slot & !abi::TRANSPOSED) as usize - first];
            (0..3).for_each(|i| block[4 * i] += sign * tangent.damping * DAMPING);
        }
        Ok(())
    }
}

/// The velocities seen in one step of 0.1 s, and the velocity of the second node along x after it, m/s.
fn step(scheme: Scheme, max_newton: usize) -> (Vec<f64>, f64) {
    let flags = abi::HAS_FORCES | abi::HAS_DAMPING;
    let request = ElementRequest { kind: abi::LINK, families: 0, flags, rest_stride: 0, history_stride: 0 };
    let seen = Arc::new(Mutex::new(Vec::new()));
    let mut system = System::new(Box::new(Damper { requests: [request], seen: Arc::clone(&seen) }));
    system.nodes = Nodes::at_rest(vec![Vec3::zeros(), Vec3::new(1.0, 0.0, 0.0)]);
    *system.sets[0].list_mut() = ElementList { nodes: vec![0, 1], measure: vec![1.0], ..ElementList::default() };
    system.matrix = scheme.is_implicit().then(Matrix::default);
    system.prepare().expect("sound");
    system.nodes.mass.fill(MASS);
    system.nodes.v = vec![Vec3::new(-SPEED, 0.0, 0.0), Vec3::new(SPEED, 0.0, 0.0)];
    let mut integrator = Integrator::new(scheme, 1e-10, 100);
    integrator.max_newton = max_newton;
    integrator.newton_tolerance = 0.0;
    integrator.resize(2);
    let time = StepTime { start: 0.0, dt: 0.1 };
    integrator.step(&Pool::new(1), &mut system, &Loads::default(), time, 1).expect("sound");
    let seen = seen.lock().expect("no panic").clone();
    (seen, system.nodes.v[1][0])
}

#[test]
fn the_first_iteration_of_backward_euler_takes_damping_from_the_matrix_alone() {
    // Both ends move, so the relative velocity decays with twice the damping.
    let expected = SPEED / (1.0 + 0.1 * 2.0 * DAMPING / MASS);
    for scheme in [Scheme::BackwardEuler, Scheme::Bdf2] {
        let (seen, after) = step(scheme, 1);
        assert_eq!(seen, [0.0], "{}", scheme.name());
        assert!((after - expected).abs() < 1e-9, "{}: {after} m/s instead of {expected}", scheme.name());
    }
    let (seen, after) = step(Scheme::BackwardEuler, 2);
    assert_eq!((seen.len(), seen[0]), (2, 0.0), "{seen:?}");
    assert!((seen[1] - expected).abs() < 1e-9 && (after - expected).abs() < 1e-9, "{seen:?}, {after} m/s");
}

#[test]
fn other_schemes_show_the_velocities_of_the_state() {
    for scheme in [Scheme::SymplecticEuler, Scheme::ExplicitEuler, Scheme::ImplicitMidpoint, Scheme::DampedMidpoint] {
        let (seen, _) = step(scheme, 1);
        assert!(!seen.is_empty() && seen.iter().all(|v| *v == SPEED), "{}: {seen:?}", scheme.name());
    }
}
