//! Balances of energy and momentum.

use super::catalogue::{ConservationCase, ConservedQuantity};
use super::energy::EnergyBalance;
use super::state::run_and_classify;
use super::task::{Inputs, Task, scene_run};
use crate::context::ReportContext;
use crate::row::Row;
use crate::settings::{merge, setting};
use pliant_engine::session::Session;
use pliant_solver::Vec3;

/// A task for each case and integrator.
pub(super) fn conservation_tasks<'a>(inputs: Inputs<'a>, context: &ReportContext<'_>) -> Vec<Task<'a>> {
    let mut tasks = Vec::new();
    for case in &inputs.catalogue.balances {
        for integrator in &case.integrators {
            let (name, method) = (case.name.clone(), integrator.clone());
            let row = Row { case: name, method, threads: context.options.threads, ..Row::default() };
            tasks.push(Task::new(row, move |row, context| measure(case, inputs, row, context)));
        }
    }
    tasks
}

/// Runs the scene and fills in its balance.
fn measure(case: &ConservationCase, inputs: Inputs<'_>, mut row: Row, context: &mut ReportContext<'_>) -> Row {
    let mut settings = merge([&case.settings]);
    settings.push(setting("time.integrator", &row.method));
    let Some(run) = scene_run(inputs.scenes, &case.scene, settings, context) else {
        return row.with_failure(format!("no scene `{}`", case.scene));
    };
    row.tolerance = Some(case.tolerance);
    let (result, error) = match case.quantity {
        ConservedQuantity::Energy => {
            let classified = run_and_classify(&run);
            row.state = classified.state.name().into();
            fill_balance(&classified.balance, &mut row);
            (classified.result, classified.balance.excess())
        }
        ConservedQuantity::Momentum | ConservedQuantity::AngularMomentum => {
            let mut momenta: Vec<Vec3> = Vec::new();
            let result = run.run(&[], |session| {
                if session.time() > case.after {
                    let momentum = momentum(session);
                    momenta.push(if case.quantity == ConservedQuantity::Momentum {
                        momentum.linear
                    } else {
                        momentum.angular
                    });
                }
                true
            });
            (result, relative_change(&momenta))
        }
    };
    match result {
        Ok(result) => {
            row.dt = result.dt;
            row.error = (error.is_finite() && result.frozen.is_none()).then_some(error);
            (row.wall_seconds, row.cpu_seconds, row.iterations) = (result.wall, result.cpu, result.iterations);
            row.note = result.frozen.clone().unwrap_or_default();
            context.add_run(&result);
        }
        Err(error) => row.note = error.to_string(),
    }
    row.passed = Some(row.error.is_some_and(|e| e <= case.tolerance));
    row
}

/// Fills in the work done and its distribution at the end, J.
fn fill_balance(balance: &EnergyBalance, row: &mut Row) {
    let last = |list: &[f64]| list.last().copied().unwrap_or(0.0);
    let (kinetic, elastic) = (last(&balance.kinetic), last(&balance.elastic));
    row.results.extend([
        ("work in (J)".into(), balance.work),
        ("kinetic (J)".into(), kinetic),
        ("elastic (J)".into(), elastic),
        ("friction (J)".into(), balance.friction_work),
        ("dissipated (J)".into(), balance.work - kinetic - elastic),
        ("from nothing at most (J)".into(), balance.injected.max(0.0)),
    ]);
}

/// Momentum of all bodies.
struct Momentum {
    /// Linear momentum, kg m/s.
    linear: Vec3,
    /// Angular momentum about the origin, kg m^2/s.
    angular: Vec3,
}

/// Momentum of all bodies of a session.
fn momentum(session: &Session) -> Momentum {
    let (mut p, mut l) = (Vec3::zeros(), Vec3::zeros());
    for body in &session.bodies {
        let nodes = &body.system.nodes;
        for i in 0..nodes.len() {
            let (x, v, m) = (nodes.x[i], nodes.v[i], nodes.mass[i]);
            p += m * v;
            l += m * x.cross(&v);
        }
    }
    Momentum { linear: p, angular: l }
}

/// Largest change since the first, over the largest magnitude; NaN of none.
fn relative_change(momenta: &[Vec3]) -> f64 {
    let Some(first) = momenta.first() else { return f64::NAN };
    let largest = momenta.iter().map(|m| m.norm()).fold(0.0, f64::max);
    momenta.iter().map(|m| (m - first).norm()).fold(0.0, f64::max) / largest
}
