//! Time integration schemes: what each one states about itself, one file a scheme.
//!
//! A scheme is data: which kind of step it takes, with which coefficients, and up to which step it is stable. The steps themselves are in
//! [`super::explicit`], [`super::implicit`] and [`super::quasi_static`]. A new scheme is a file here, a variant of [`Scheme`] and its line
//! in `Scheme::definition`.

mod backward_euler;
mod bdf2;
mod explicit_euler;
mod implicit_midpoint;
mod quasi_static;
mod symplectic_euler;

use super::limit::{Frequencies, StepLimit};
use crate::system_scales::HessianApproximation;

/// How positions and velocities are advanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scheme {
    /// Positions with the old velocities, as Qi, Zhu and Fan (2019) print it: gains energy in every undamped mode.
    ExplicitEuler,
    /// Velocities first, then positions with the new ones: keeps energy up to a bounded error, stable up to a step limit.
    SymplecticEuler,
    /// First order, stable at any step, damps high frequencies.
    BackwardEuler,
    /// Second order (Gear 1971), stable at any step, damps less. A step of backward Euler follows whatever breaks the history: contact, a
    /// cut, a new region.
    Bdf2,
    /// Second order, stable at any step for linear forces, no numerical damping.
    ImplicitMidpoint,
    /// No inertia: static equilibrium at every step.
    QuasiStatic,
}

/// The state a step is linearised at first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Linearisation {
    /// Positions before the step; also those at which forces are evaluated.
    Current,
    /// Positions that the present velocities lead to.
    Predicted,
}

/// Coefficients of one implicit step. The unknown is the velocity v of the stage, from
///
/// `M (v - V) = g f(X + g v, v)`, `X = x + history (x - x_before)`, `V = v_0 + history (v_0 - v_before)`,
///
/// where x, v_0 are the state before the step and x_before, v_before the state one step earlier.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ImplicitCoefficients {
    /// g: how far a velocity moves positions at the stage, s.
    pub g: f64,
    /// Share of the previous step's change that goes on; 0 for one-step schemes.
    pub history: f64,
    /// Where in the step the stage is, in (0, 1]: 1 at its end, 0.5 halfway.
    pub stage: f64,
    /// Where the first Newton iteration is linearised.
    pub first: Linearisation,
    /// How much stiffness the matrix must have for the step to be stable after one Newton iteration.
    pub hessian: HessianApproximation,
}

/// What is known of the previous step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum History {
    /// The previous state leads smoothly to the present one.
    Smooth,
    /// The first step, or something broke the history: contact, a cut, a new region.
    Broken,
}

/// Which of position and velocity an explicit step updates first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ExplicitOrder {
    /// Positions with the old velocities.
    PositionFirst,
    /// Velocities, then positions with the new ones.
    VelocityFirst,
}

/// The kind of step a scheme takes.
#[derive(Clone, Copy)]
pub(super) enum Method {
    /// New velocities from the forces of the present state.
    Explicit(ExplicitOrder),
    /// A system of equations for the stage velocity; the coefficients for a step dt (s).
    Implicit(fn(dt: f64, history: History) -> ImplicitCoefficients),
    /// Static equilibrium.
    Equilibrium,
}

/// What a scheme states about itself.
pub(super) struct Definition {
    /// Name in scene files.
    pub name: &'static str,
    /// The kind of step.
    pub method: Method,
    /// The largest stable step for a body whose fastest motions are given.
    pub step_limit: fn(&Frequencies) -> StepLimit,
}

/// Step limit of a scheme that is stable at any step.
fn unlimited(_: &Frequencies) -> StepLimit {
    StepLimit::None
}

impl Scheme {
    /// All schemes, explicit ones first.
    pub const ALL: [Self; 6] = [
        Self::ExplicitEuler,
        Self::SymplecticEuler,
        Self::BackwardEuler,
        Self::Bdf2,
        Self::ImplicitMidpoint,
        Self::QuasiStatic,
    ];

    pub(super) fn definition(self) -> &'static Definition {
        match self {
            Self::ExplicitEuler => &explicit_euler::DEFINITION,
            Self::SymplecticEuler => &symplectic_euler::DEFINITION,
            Self::BackwardEuler => &backward_euler::DEFINITION,
            Self::Bdf2 => &bdf2::DEFINITION,
            Self::ImplicitMidpoint => &implicit_midpoint::DEFINITION,
            Self::QuasiStatic => &quasi_static::DEFINITION,
        }
    }

    /// Name in scene files, such as `backward-euler`.
    pub fn name(self) -> &'static str {
        self.definition().name
    }

    /// Whether a step solves a system of equations.
    pub fn is_implicit(self) -> bool {
        match self.definition().method {
            Method::Explicit(_) => false,
            Method::Implicit(_) | Method::Equilibrium => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amplification of `x'' = -w^2 x` by a scheme's coefficients, from the recurrence they state, in exact complex arithmetic of
    /// one mode: the order is that of the error per step, and a stable scheme never amplifies.
    fn advance(c: ImplicitCoefficients, w: f64, dt: f64, (x, v): (f64, f64), (xb, vb): (f64, f64)) -> (f64, f64) {
        let (big_x, big_v) = (x + c.history * (x - xb), v + c.history * (v - vb));
        let stage = (big_v - c.g * w * w * big_x) / (1.0 + (c.g * w).powi(2));
        match c.stage < 1.0 {
            true => (x + dt * stage, v + (stage - v) / c.stage),
            false => (big_x + c.g * stage, stage),
        }
    }

    /// Error of a unit oscillation after time 1.
    fn error(scheme: Scheme, steps: u32) -> f64 {
        let Method::Implicit(coefficients) = scheme.definition().method else {
            panic!("{} is not implicit", scheme.name())
        };
        let dt = 1.0 / f64::from(steps);
        let (mut before, mut state) = (((-dt).cos(), dt.sin()), (1.0, 0.0));
        for _ in 0..steps {
            let next = advance(coefficients(dt, History::Smooth), 1.0, dt, state, before);
            (before, state) = (state, next);
        }
        (state.0 - 1.0_f64.cos()).hypot(state.1 + 1.0_f64.sin())
    }

    #[test]
    fn stated_coefficients_have_the_order_of_the_scheme() {
        for (scheme, order) in [(Scheme::BackwardEuler, 1), (Scheme::Bdf2, 2), (Scheme::ImplicitMidpoint, 2)] {
            let rate = (error(scheme, 200) / error(scheme, 400)).log2();
            assert!((rate - f64::from(order)).abs() < 0.05, "{}: order {rate}", scheme.name());
        }
    }

    #[test]
    fn implicit_schemes_never_amplify_and_names_are_distinct() {
        for scheme in Scheme::ALL {
            let Method::Implicit(coefficients) = scheme.definition().method else { continue };
            for wdt in [0.01, 1.0, 100.0] {
                let (mut before, mut state) = ((1.0, 0.0), (1.0, 0.0));
                for _ in 0..200 {
                    let next = advance(coefficients(wdt, History::Smooth), 1.0, wdt, state, before);
                    (before, state) = (state, next);
                }
                assert!(state.0.hypot(state.1) < 1.5, "{}: {state:?} at w dt = {wdt}", scheme.name());
            }
        }
        let mut names = Scheme::ALL.map(Scheme::name);
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]));
    }
}
