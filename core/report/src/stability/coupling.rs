//! The largest stable stiffness of the spring between hand and surface, for a device of mass `m` and damping `b`, a hand that holds it, a
//! wall, and a force that is sampled and held for a period `T`.
//!
//! Colgate and Schenkel (1997): with any passive hand the coupling is stable if and only if `b > K T / 2 + |B|`; a delay `d` of the
//! force changes this to `K (T / 2 + d)`. The observed limit is exact: the device moves continuously between samples, so a period is a linear map, whose spectral
//! radius decides about stability.

use super::task::Task;
use crate::context::ReportContext;
use crate::row::Row;
use nalgebra::{DMatrix, Matrix2, Vector2};

/// Mass of a small desktop device, kg; docs/reports.md says what is assumed.
const DEVICE_MASS: f64 = 0.045;
/// Rates of the force, Hz.
const RATES: [f64; 5] = [250.0, 500.0, 1000.0, 2000.0, 4000.0];
/// Dampings of the device, N s/m.
const DAMPINGS: [f64; 5] = [0.05, 0.1, 0.2, 0.5, 1.0];

/// A hand that holds the device, as a mass on a spring and a damper.
#[derive(Clone, Copy)]
struct Hand {
    /// Mass of the hand, kg.
    mass: f64,
    /// Damping of the hand, N s/m.
    damping: f64,
    /// Stiffness of the hand, N/m.
    stiffness: f64,
}

/// No hand at all.
const NO_HAND: Hand = Hand { mass: 0.0, damping: 0.0, stiffness: 0.0 };
/// A relaxed hand, of the order of magnitude of Hajian and Howe (1997).
const RELAXED_HAND: Hand = Hand { mass: 0.1, damping: 4.0, stiffness: 300.0 };

/// Combinations of hand and delay.
#[derive(Clone, Copy)]
enum Situation {
    /// The tool is free: no hand holds it.
    Free,
    /// A relaxed hand.
    Relaxed,
    /// The passive hand with the lowest limit.
    WorstPassive,
    /// No hand, and a force that comes one sample late.
    Delayed,
}

impl Situation {
    /// All of them, in the order of the rows.
    const ALL: [Self; 4] = [Self::Free, Self::Relaxed, Self::WorstPassive, Self::Delayed];

    /// The name in rows.
    fn name(self) -> &'static str {
        match self {
            Self::Free => "no hand",
            Self::Relaxed => "relaxed hand",
            Self::WorstPassive => "worst passive hand",
            Self::Delayed => "no hand, force one sample late",
        }
    }
}

/// A task for each situation, rate and damping. A quick report has every second rate and damping.
pub(super) fn coupling_tasks<'a>(context: &ReportContext<'_>) -> Vec<Task<'a>> {
    let stride = if context.options.quick { 2 } else { 1 };
    let mut tasks = Vec::new();
    for situation in Situation::ALL {
        for rate in RATES.iter().step_by(stride) {
            for damping in DAMPINGS.iter().copied().step_by(stride) {
                let (case, method) = ("coupling".to_owned(), situation.name().to_owned());
                let mut row = Row { case, method, dt: 1.0 / rate, threads: 1, ..Row::default() };
                row.parameters.extend([("rate (Hz)".into(), *rate), ("device damping (N s/m)".into(), damping)]);
                tasks.push(Task::new(row, move |row, context| measure(situation, damping, row, context)));
            }
        }
    }
    tasks
}

/// Fills in the observed limit beside the bound, which is that of any passive hand: no hand may have a lower limit.
fn measure(situation: Situation, damping: f64, mut row: Row, context: &mut ReportContext<'_>) -> Row {
    let began = (context.options.clock.wall)();
    let period = row.dt;
    let coupling = |hand, delayed| SampledCoupling { damping, hand, period, delayed };
    let (observed, held_periods) = match situation {
        Situation::Free => (coupling(NO_HAND, false).stiffness_limit(), 0.5),
        Situation::Relaxed => (coupling(RELAXED_HAND, false).stiffness_limit(), 0.5),
        Situation::WorstPassive => (worst_passive_limit(damping, period), 0.5),
        Situation::Delayed => (coupling(NO_HAND, true).stiffness_limit(), 1.5),
    };
    let bound = damping / (period * held_periods);
    let results = [("predicted".into(), bound), ("observed".into(), observed), ("ratio".into(), observed / bound)];
    row.results.extend(results);
    row.wall_seconds = (context.options.clock.wall)() - began;
    row.passed = Some(observed >= 0.999 * bound);
    row
}

/// Lowest limit among passive hands, N/m. Masses and springs dissipate nothing, so the worst hand is made of them.
fn worst_passive_limit(damping: f64, period: f64) -> f64 {
    let masses = [0.0, 0.05, 0.2, 1.0, 5.0];
    let springs = (0..12).map(|i| 10.0_f64.powf(1.0 + 0.5 * f64::from(i))).chain([0.0]);
    let hands = springs.flat_map(|stiffness| masses.map(|mass| Hand { mass, damping: 0.0, stiffness }));
    let limit = |hand| SampledCoupling { damping, hand, period, delayed: false }.stiffness_limit();
    hands.map(limit).fold(f64::INFINITY, f64::min)
}

/// A device in a hand, pressed against a wall through a sampled spring.
#[derive(Clone, Copy)]
struct SampledCoupling {
    /// N s/m, of the device
    damping: f64,
    hand: Hand,
    /// Time between two samples, s.
    period: f64,
    /// Whether the force comes one sample late.
    delayed: bool,
}

impl SampledCoupling {
    /// Largest stable stiffness, by bisection, N/m.
    fn stiffness_limit(&self) -> f64 {
        let (mut stable, mut growing) = (1e-3, 1e8);
        for _ in 0..80 {
            let middle = f64::sqrt(stable * growing);
            // A free mass drifts, which is an eigenvalue of one; only eigenvalues above one are growth.
            if self.spectral_radius(middle) <= 1.0 + 1e-9 { stable = middle } else { growing = middle }
        }
        stable
    }

    /// Spectral radius of the matrix of a period, with a spring of this stiffness (N/m). The state is position, velocity, and the
    /// position one sample before.
    fn spectral_radius(&self, stiffness: f64) -> f64 {
        let device = Oscillator {
            mass: DEVICE_MASS + self.hand.mass,
            damping: self.damping + self.hand.damping,
            stiffness: self.hand.stiffness,
        };
        let (transition, response) = device.propagate(self.period);
        let mut a = DMatrix::zeros(3, 3);
        for i in 0..2 {
            for j in 0..2 {
                a[(i, j)] = transition[(i, j)];
            }
            a[(i, if self.delayed { 2 } else { 0 })] -= response[i] * stiffness;
        }
        a[(2, 0)] = 1.0;
        a.complex_eigenvalues().iter().map(|e| e.norm()).fold(0.0, f64::max)
    }
}

/// A mass (kg) on a damper (N s/m) and a spring (N/m).
struct Oscillator {
    mass: f64,
    damping: f64,
    stiffness: f64,
}

impl Oscillator {
    /// Change of position and velocity in a period (s) without force, and by a constant force of 1 N: the matrix exponential.
    fn propagate(&self, period: f64) -> (Matrix2<f64>, Vector2<f64>) {
        let mut generator = DMatrix::<f64>::zeros(3, 3);
        generator[(0, 1)] = 1.0;
        generator[(1, 0)] = -self.stiffness / self.mass;
        generator[(1, 1)] = -self.damping / self.mass;
        generator[(1, 2)] = 1.0 / self.mass;
        let propagator = (generator * period).exp();
        (propagator.fixed_view::<2, 2>(0, 0).into(), propagator.fixed_view::<2, 1>(0, 2).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bound_is_safe_and_a_hand_of_springs_comes_near_it() {
        for (damping, period) in [(0.2, 1e-3), (0.5, 2e-3)] {
            let bound = 2.0 * damping / period;
            let free = |delayed| SampledCoupling { damping, hand: NO_HAND, period, delayed }.stiffness_limit();
            let worst = worst_passive_limit(damping, period);
            assert!(free(false) >= bound && worst >= 0.999 * bound && worst < 1.2 * bound, "{bound} {worst}");
            // A delayed force lowers the limit below the bound without delay.
            assert!(free(true) < bound);
        }
    }

    #[test]
    fn a_free_mass_moves_as_it_should() {
        let (transition, response) = Oscillator { mass: 2.0, damping: 0.0, stiffness: 0.0 }.propagate(0.5);
        assert!((transition - Matrix2::new(1.0, 0.5, 0.0, 1.0)).norm() < 1e-14);
        assert!((response - Vector2::new(0.0625, 0.25)).norm() < 1e-14);
    }
}
