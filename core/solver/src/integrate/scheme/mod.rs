//! Properties of time integration schemes, one file for each scheme.
//!
//! A scheme is data: the kind of its step, its coefficients and its stability limit. The steps themselves are in
//! [`super::explicit`], [`super::implicit`] and [`super::quasi_static`]. A new scheme is a file here, a variant of [`Scheme`] and its line
//! in `Scheme::properties`.

pub(super) mod backward_euler;
mod bdf2;
mod damped_midpoint;
mod explicit_euler;
mod implicit_midpoint;
mod quasi_static;
mod symplectic_euler;

use super::limit::{Frequencies, StepLimit};
use crate::system_scales::HessianApproximation;

/// Time integration scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scheme {
    /// Positions from the old velocities, as printed by Qi, Zhu and Fan (2019): gains energy in every undamped mode.
    ExplicitEuler,
    /// Velocities first, then positions from the new velocities: bounded energy error, stable up to a step limit.
    SymplecticEuler,
    /// First order, stable at any step, damps high frequencies.
    BackwardEuler,
    /// Second order (Gear 1971), stable at any step, damps less. It takes a step of backward Euler after a contact change, a cut or a new region.
    Bdf2,
    /// Second order, stable at any step for linear forces, no numerical damping.
    ImplicitMidpoint,
    /// First order with a tenth of backward Euler's numerical damping, stable at any step.
    DampedMidpoint,
    /// Static equilibrium at every step, without inertia.
    QuasiStatic,
}

/// State at which the first Newton iteration of a step is linearised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Linearisation {
    /// The state before the step.
    Current,
    /// The positions `X + effective_dt v` that the present velocities predict.
    Predicted,
}

/// Coefficients of one implicit step. The unknown is the velocity v of the stage, from
///
/// `M (v - V) = effective_dt f(X + effective_dt v, v)`, `X = x + history (x - x_before)`, `V = v_0 + history (v_0 - v_before)`,
///
/// where x, v_0 are the state before the step, x_before, v_before the state one step earlier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ImplicitCoefficients {
    /// Effective step size, called g in formulas elsewhere, s: dt for backward Euler, 2/3 dt for BDF2, dt/2 for the implicit midpoint rule.
    pub effective_dt: f64,
    /// Coefficient of the previous step's change in X and V: 1/3 for BDF2, 0 for one-step schemes.
    pub history: f64,
    /// Time of the stage as a fraction of the step, in (0, 1]: 1 at the end, 0.5 at the midpoint.
    pub stage: f64,
    /// State at which the first Newton iteration is linearised.
    pub first: Linearisation,
    /// Approximation of the stiffness with which one Newton iteration is stable.
    pub hessian: HessianApproximation,
}

/// Whether a multistep scheme may use the previous state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum History {
    /// The previous state may be used: no contact change, cut or new region since.
    Continuous,
    /// The previous state may not be used: the first step, or the first after a contact change, a cut or a new region.
    Interrupted,
}

/// Which of position and velocity an explicit step updates first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ExplicitOrder {
    /// Positions from the old velocities, then velocities.
    PositionFirst,
    /// Velocities, then positions from the new velocities.
    VelocityFirst,
}

/// The kind of step a scheme takes.
#[derive(Clone, Copy)]
pub(super) enum Method {
    /// The new velocities follow from the forces of the present state.
    Explicit(ExplicitOrder),
    /// The stage velocity solves a system of equations; returns the coefficients for a step dt (s).
    Implicit(fn(dt: f64, history: History) -> ImplicitCoefficients),
    /// Positions of static equilibrium, found without inertia.
    Equilibrium,
}

/// Properties of a scheme.
pub(super) struct SchemeProperties {
    /// Name in scene files.
    pub name: &'static str,
    /// The kind of step.
    pub method: Method,
    /// Returns the largest stable step for a body with these frequencies.
    pub step_limit: fn(&Frequencies) -> StepLimit,
}

/// Step limit of a scheme that is stable at any step.
fn unlimited(_: &Frequencies) -> StepLimit {
    StepLimit::None
}

impl Scheme {
    /// All schemes, explicit ones first.
    pub const ALL: [Self; 7] = [
        Self::ExplicitEuler,
        Self::SymplecticEuler,
        Self::BackwardEuler,
        Self::Bdf2,
        Self::ImplicitMidpoint,
        Self::DampedMidpoint,
        Self::QuasiStatic,
    ];

    /// The properties of the scheme.
    pub(super) fn properties(self) -> &'static SchemeProperties {
        match self {
            Self::ExplicitEuler => &explicit_euler::PROPERTIES,
            Self::SymplecticEuler => &symplectic_euler::PROPERTIES,
            Self::BackwardEuler => &backward_euler::PROPERTIES,
            Self::Bdf2 => &bdf2::PROPERTIES,
            Self::ImplicitMidpoint => &implicit_midpoint::PROPERTIES,
            Self::DampedMidpoint => &damped_midpoint::PROPERTIES,
            Self::QuasiStatic => &quasi_static::PROPERTIES,
        }
    }

    /// The scheme with this name in scene files; `None` if there is none.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scheme| scheme.name() == name)
    }

    /// Name in scene files, such as `backward-euler`.
    pub fn name(self) -> &'static str {
        self.properties().name
    }

    /// Whether a step solves a linear system.
    pub fn is_implicit(self) -> bool {
        match self.properties().method {
            Method::Explicit(_) => false,
            Method::Implicit(_) | Method::Equilibrium => true,
        }
    }

    /// Whether the masses of the nodes enter a step: not in a step to static equilibrium.
    pub fn has_inertia(self) -> bool {
        match self.properties().method {
            Method::Explicit(_) | Method::Implicit(_) => true,
            Method::Equilibrium => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Position and velocity of an oscillator of one degree of freedom.
    #[derive(Clone, Copy, Debug)]
    struct Motion {
        x: f64,
        v: f64,
    }

    /// One step of `x'' = -w^2 x` with a scheme's coefficients, from the present motion and that one step earlier.
    fn advance(c: ImplicitCoefficients, w: f64, dt: f64, now: Motion, before: Motion) -> Motion {
        let Motion { x, v } = now;
        let (big_x, big_v) = (x + c.history * (x - before.x), v + c.history * (v - before.v));
        let stage = (big_v - c.effective_dt * w * w * big_x) / (1.0 + (c.effective_dt * w).powi(2));
        match c.stage < 1.0 {
            true => Motion { x: x + dt * stage, v: v + (stage - v) / c.stage },
            false => Motion { x: big_x + c.effective_dt * stage, v: stage },
        }
    }

    /// Deflected by one and at rest.
    const DEFLECTED: Motion = Motion { x: 1.0, v: 0.0 };

    /// Error of a unit oscillation after time 1.
    fn error(scheme: Scheme, steps: u32) -> f64 {
        let Method::Implicit(coefficients) = scheme.properties().method else {
            panic!("{} is not implicit", scheme.name())
        };
        let dt = 1.0 / f64::from(steps);
        let (mut before, mut state) = (Motion { x: (-dt).cos(), v: dt.sin() }, DEFLECTED);
        for _ in 0..steps {
            let next = advance(coefficients(dt, History::Continuous), 1.0, dt, state, before);
            (before, state) = (state, next);
        }
        (state.x - 1.0_f64.cos()).hypot(state.v + 1.0_f64.sin())
    }

    #[test]
    fn coefficients_have_the_order_of_the_scheme() {
        let first = [(Scheme::BackwardEuler, 1), (Scheme::DampedMidpoint, 1)];
        for (scheme, order) in first.into_iter().chain([(Scheme::Bdf2, 2), (Scheme::ImplicitMidpoint, 2)]) {
            let rate = (error(scheme, 200) / error(scheme, 400)).log2();
            assert!((rate - f64::from(order)).abs() < 0.05, "{}: order {rate}", scheme.name());
        }
    }

    #[test]
    fn damped_midpoint_damps_slow_modes_a_tenth_as_much_as_backward_euler() {
        let after = |scheme: Scheme| {
            let Method::Implicit(coefficients) = scheme.properties().method else { panic!("{}", scheme.name()) };
            let c = coefficients(1e-2, History::Continuous);
            let last = (0..1000).fold(DEFLECTED, |state, _| advance(c, 1.0, 1e-2, state, state));
            1.0 - f64::hypot(last.x, last.v)
        };
        let ratio = after(Scheme::DampedMidpoint) / after(Scheme::BackwardEuler);
        assert!((ratio - 0.1).abs() < 0.01, "{ratio}");
        let fast = after(Scheme::ImplicitMidpoint);
        assert!(fast.abs() < 1e-9, "{fast}");
    }

    #[test]
    fn implicit_schemes_do_not_amplify_and_names_are_distinct() {
        for scheme in Scheme::ALL {
            let Method::Implicit(coefficients) = scheme.properties().method else { continue };
            for wdt in [0.01, 1.0, 100.0] {
                let (mut before, mut state) = (DEFLECTED, DEFLECTED);
                for _ in 0..200 {
                    let next = advance(coefficients(wdt, History::Continuous), 1.0, wdt, state, before);
                    (before, state) = (state, next);
                }
                assert!(state.x.hypot(state.v) < 1.5, "{}: {state:?} at w dt = {wdt}", scheme.name());
            }
        }
        let mut names = Scheme::ALL.map(Scheme::name);
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]));
        assert!(Scheme::ALL.into_iter().all(|scheme| Scheme::from_name(scheme.name()) == Some(scheme)));
    }
}
