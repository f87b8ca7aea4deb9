//! Bodies that are pulled apart.

use pliant_engine::session::Session;
use pliant_solver::{Constraint, Integrator, Loads, Pool, Scheme, StepTime, Vec3};

/// Pulls the nodes of the first body with the largest x along x by `elongation` (m) in equal displacements, as many as `steps`, each to its equilibrium, until
/// elements have failed and nothing resists. Returns the work of the pull, J, and its largest force, N.
///
/// # Panics
/// If a step fails.
pub fn pull_apart(session: &mut Session, elongation: f64, steps: usize) -> (f64, f64) {
    session.step();
    let system = &mut session.bodies[0].system;
    let pool = Pool::new(1);
    let mut integrator = Integrator::new(Scheme::QuasiStatic, 1e-10, 2000);
    integrator.newton_tolerance = 1e-9;
    integrator.resize(system.nodes.len());
    let end = system.nodes.rest.iter().map(|x| x.x).fold(f64::NEG_INFINITY, f64::max);
    let pulled: Vec<usize> = (0..system.nodes.len()).filter(|i| system.nodes.rest[*i].x > end - 1e-6).collect();
    let (mut work, mut before, mut largest) = (0.0, 0.0, 0.0_f64);
    let dt = 1e-3;
    for step in 0..steps {
        let speed = elongation / steps as f64 / dt;
        pulled.iter().for_each(|i| {
            system.nodes.constraint[*i] = Constraint::Fixed;
            system.nodes.prescribed[*i] = Vec3::new(speed, 0.0, 0.0);
        });
        let time = StepTime { start: step as f64 * dt, dt };
        integrator.step(&pool, system, &Loads::default(), time, 1).unwrap_or_else(|e| panic!("step {step}: {e}"));
        let force: f64 = pulled.iter().map(|i| integrator.reaction[*i].x).sum();
        work += 0.5 * (before + force) * speed * dt;
        (before, largest) = (force, largest.max(force));
        if system.failed_count() > 0 && force.abs() < 1e-9 * largest {
            break;
        }
    }
    (work, largest)
}
