//! Where the energy and the momentum of a run go.

use super::catalogue::{Account, Balance, StabilityCatalogue};
use super::state::{Ledger, judge};
use super::{Scenes, Task, set, trial};
use crate::catalogue::settings;
use crate::{Row, Setup};
use pliant_engine::session::Session;
use pliant_solver::{V3, axpy, dot};

pub(super) fn tasks<'a>(
    catalogue: &'a StabilityCatalogue,
    scenes: Scenes<'a>,
    setup: &Setup<'_>,
    out: &mut Vec<Task<'a>>,
) {
    for balance in &catalogue.balance {
        for integrator in &balance.integrator {
            let (case, method) = (balance.name.clone(), integrator.clone());
            let row = Row { case, method, threads: setup.threads, ..Row::default() };
            out.push((row, Box::new(move |row, setup| fill(balance, scenes, row, setup))));
        }
    }
}

fn fill<'a>(balance: &'a Balance, scenes: Scenes<'a>, mut row: Row, setup: &mut Setup<'_>) -> Row {
    let mut sets = settings([&balance.set]);
    sets.push(set("time.integrator", &row.method));
    let Some(trial) = trial(scenes, &balance.scene, sets, setup) else {
        row.note = format!("no scene `{}`", balance.scene);
        row.passed = Some(false);
        return row;
    };
    row.tolerance = Some(balance.tolerance);
    let mut momenta: Vec<(V3, V3)> = Vec::new();
    let (outcome, error) = match balance.of {
        Account::Energy => {
            let (state, ledger, outcome) = judge(&trial);
            row.state = state.name().into();
            account(&ledger, &mut row);
            (outcome, ledger.excess())
        }
        _ => {
            let outcome = trial.run(&[], |session| {
                if session.time() > balance.after {
                    momenta.push(momentum(session));
                }
                true
            });
            (outcome, drift(&momenta, balance.of))
        }
    };
    match outcome {
        Ok(outcome) => {
            row.dt = outcome.dt;
            row.error = (error.is_finite() && outcome.frozen.is_none()).then_some(error);
            (row.wall_seconds, row.cpu_seconds, row.iterations) = (outcome.wall, outcome.cpu, outcome.iterations);
            row.note = outcome.frozen.clone().unwrap_or_default();
            setup.ran(&outcome);
        }
        Err(error) => row.note = error.to_string(),
    }
    row.passed = Some(row.error.is_some_and(|e| e <= balance.tolerance));
    row
}

/// J, at the end: work in, what is stored, and what is left: dissipated, or made.
fn account(ledger: &Ledger, row: &mut Row) {
    let last = |list: &[f64]| list.last().copied().unwrap_or(0.0);
    let (kinetic, elastic) = (last(&ledger.kinetic), last(&ledger.elastic));
    row.found.extend([
        ("work in (J)".into(), ledger.work),
        ("kinetic (J)".into(), kinetic),
        ("elastic (J)".into(), elastic),
        ("friction (J)".into(), ledger.rubbed),
        ("dissipated (J)".into(), ledger.work - kinetic - elastic),
        ("from nothing at most (J)".into(), ledger.injected.max(0.0)),
    ]);
}

/// kg m/s, and kg m^2/s about the origin
fn momentum(session: &Session) -> (V3, V3) {
    let (mut p, mut l) = ([0.0; 3], [0.0; 3]);
    for body in &session.bodies {
        let nodes = &body.system.nodes;
        for i in 0..nodes.len() {
            let (x, v, m) = (nodes.x[i], nodes.v[i], nodes.mass[i]);
            p = axpy(p, m, v);
            let turn = [x[1] * v[2] - x[2] * v[1], x[2] * v[0] - x[0] * v[2], x[0] * v[1] - x[1] * v[0]];
            l = axpy(l, m, turn);
        }
    }
    (p, l)
}

/// Largest change since the first, over the largest size.
fn drift(momenta: &[(V3, V3)], of: Account) -> f64 {
    let pick = |m: &(V3, V3)| if of == Account::Momentum { m.0 } else { m.1 };
    let size = |v: V3| dot(v, v).sqrt();
    let Some(first) = momenta.first().map(pick) else { return f64::NAN };
    let most = momenta.iter().map(|m| size(pick(m))).fold(0.0, f64::max);
    momenta.iter().map(|m| size(axpy(pick(m), -1.0, first))).fold(0.0, f64::max) / most
}
