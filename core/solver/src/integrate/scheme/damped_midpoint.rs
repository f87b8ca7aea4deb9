//! Damped midpoint: the one-leg theta method (Dahlquist 1978) with theta = 0.55. `M (v - v_0) = theta dt f(x + theta dt v)` for the velocity v of the
//! stage; the step ends at `x + dt v` with `v_0 + (v - v_0) / theta`.
//!
//! A step multiplies a slow mode by `1 - (theta - 1/2) (w dt)^2 + ...`, so numerical damping is a tenth of backward Euler's; it multiplies the fastest
//! ones by `(1 - theta) / theta` = 0.82, where the midpoint rule lets them ring.

use super::{History, ImplicitCoefficients, Linearisation, Method, SchemeProperties, unlimited};
use crate::system_scales::HessianApproximation;

pub(super) const PROPERTIES: SchemeProperties =
    SchemeProperties { name: "damped-midpoint", method: Method::Implicit(coefficients), step_limit: unlimited };

/// Time of the stage as a fraction of the step: 1/2 damps nothing, 1 is backward Euler.
const THETA: f64 = 0.55;

/// Coefficients of a step dt (s). The matrix needs the whole stiffness, as that of the midpoint rule.
fn coefficients(dt: f64, _: History) -> ImplicitCoefficients {
    ImplicitCoefficients {
        effective_dt: THETA * dt,
        history: 0.0,
        stage: THETA,
        first: Linearisation::Predicted,
        hessian: HessianApproximation::UpperBound,
    }
}
