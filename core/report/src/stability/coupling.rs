//! How stiff a spring between hand and surface may be: a device of mass `m` and damping `b`, a hand that holds it, a wall, and a
//! force that is sampled and held for a period `T`.
//!
//! Colgate and Schenkel (1997): with any passive hand it is stable if and only if `b > K T / 2 + |B|`; a delay `d` of the force
//! takes `K (T / 2 + d)`. The observed limit is exact: the device moves continuously between samples, so a period is a matrix,
//! and its largest eigenvalue says whether motion dies.

use super::Task;
use crate::{Row, Setup};
use nalgebra::{DMatrix, Matrix2, Vector2};

/// kg, and N s/m: a small desktop device (see docs/reports.md for what is assumed).
const MASS: f64 = 0.045;
/// Rates, Hz.
const RATES: [f64; 5] = [250.0, 500.0, 1000.0, 2000.0, 4000.0];
/// Dampings of the device, N s/m.
const DAMPINGS: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];

/// A hand: mass (kg), damping (N s/m), stiffness (N/m).
type Grip = (f64, f64, f64);

/// A relaxed grip (order of magnitude of Hajian and Howe 1997).
const RELAXED: Grip = (0.1, 4.0, 300.0);

pub(super) fn tasks<'a>(setup: &Setup<'_>, out: &mut Vec<Task<'a>>) {
    let every = if setup.quick { 2 } else { 1 };
    let hands = ["no hand", "relaxed hand", "worst passive hand", "no hand, force one sample late"];
    for hand in hands {
        for rate in RATES.iter().step_by(every) {
            for damping in DAMPINGS.iter().step_by(every) {
                let (case, method) = ("coupling".to_owned(), hand.to_owned());
                let mut row = Row { case, method, dt: 1.0 / rate, threads: 1, ..Row::default() };
                row.at.extend([("rate (Hz)".into(), *rate), ("device damping (N s/m)".into(), *damping)]);
                let damping = *damping;
                out.push((row, Box::new(move |row, setup| fill(damping, row, setup))));
            }
        }
    }
}

fn fill(damping: f64, mut row: Row, setup: &mut Setup<'_>) -> Row {
    let began = (setup.clock.wall)();
    let (period, late) = (row.dt, row.method.contains("late"));
    let bound = damping / (period * if late { 1.5 } else { 0.5 });
    let observed = match row.method.as_str() {
        "relaxed hand" => limit(damping, RELAXED, period, late),
        // Masses and springs take no energy: a hand made of them is the hardest to be passive against.
        "worst passive hand" => worst(damping, period),
        _ => limit(damping, (0.0, 0.0, 0.0), period, late),
    };
    row.found.extend([("predicted".into(), bound), ("observed".into(), observed), ("ratio".into(), observed / bound)]);
    row.wall_seconds = (setup.clock.wall)() - began;
    // The bound is for any passive hand: none may do worse.
    row.passed = Some(observed >= 0.999 * bound);
    row
}

fn worst(damping: f64, period: f64) -> f64 {
    let masses = [0.0, 0.05, 0.2, 1.0, 5.0];
    let springs = (0..12).map(|i| 10.0_f64.powf(1.0 + 0.5 * f64::from(i)));
    let all = springs.flat_map(|k| masses.map(|m| (m, 0.0, k))).chain(masses.map(|m| (m, 0.0, 0.0)));
    all.map(|hand| limit(damping, hand, period, false)).fold(f64::INFINITY, f64::min)
}

/// N/m, the largest stiffness up to which all motion dies.
fn limit(damping: f64, hand: Grip, period: f64, late: bool) -> f64 {
    let (mut stable, mut growing) = (1e-3, 1e8);
    for _ in 0..80 {
        let middle = f64::sqrt(stable * growing);
        // A free mass drifts on a circle of radius one: what is over it is growth.
        if radius(middle, damping, hand, period, late) <= 1.0 + 1e-9 { stable = middle } else { growing = middle }
    }
    stable
}

/// Largest eigenvalue of a period.
fn radius(stiffness: f64, damping: f64, hand: Grip, period: f64, late: bool) -> f64 {
    let (mass, rub, spring) = (MASS + hand.0, damping + hand.1, hand.2);
    let (free, push) = motion(mass, rub, spring, period);
    // State: place, speed, and the place a sample before.
    let mut a = DMatrix::zeros(3, 3);
    for i in 0..2 {
        for j in 0..2 {
            a[(i, j)] = free[(i, j)];
        }
        a[(i, if late { 2 } else { 0 })] -= push[i] * stiffness;
    }
    a[(2, 0)] = 1.0;
    a.complex_eigenvalues().iter().map(|e| e.norm()).fold(0.0, f64::max)
}

/// What a period does to place and speed without force, and with a force of 1 N all the while: `exp` of the motion's matrix, by
/// its series on a part of the period, squared.
fn motion(mass: f64, rub: f64, spring: f64, period: f64) -> (Matrix2<f64>, Vector2<f64>) {
    let mut whole = DMatrix::<f64>::zeros(3, 3);
    whole[(0, 1)] = 1.0;
    whole[(1, 0)] = -spring / mass;
    whole[(1, 1)] = -rub / mass;
    whole[(1, 2)] = 1.0 / mass;
    let whole = (whole * period).exp();
    (whole.fixed_view::<2, 2>(0, 0).into(), whole.fixed_view::<2, 1>(0, 2).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_is_safe_and_a_hand_of_springs_comes_near_it() {
        for (damping, period) in [(0.2, 1e-3), (0.5, 2e-3)] {
            let bound = 2.0 * damping / period;
            let (free, worst) = (limit(damping, (0.0, 0.0, 0.0), period, false), worst(damping, period));
            assert!(free >= bound && worst >= 0.999 * bound && worst < 1.2 * bound, "{bound} {free} {worst}");
            // A force that comes late is a wrong clock: the limit falls, and below the bound of one that does not.
            assert!(limit(damping, (0.0, 0.0, 0.0), period, true) < bound);
        }
    }

    #[test]
    fn a_free_mass_moves_as_it_should() {
        let (free, push) = motion(2.0, 0.0, 0.0, 0.5);
        assert!((free - Matrix2::new(1.0, 0.5, 0.0, 1.0)).norm() < 1e-14);
        assert!((push - Vector2::new(0.0625, 0.25)).norm() < 1e-14);
    }
}
