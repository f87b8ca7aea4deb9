//! Implicit midpoint: `M (v - v_0) = dt/2 f(x + dt/2 v)` for the velocity v at the midpoint; the step ends at `x + dt v` with `2 v - v_0`.

use super::{History, ImplicitCoefficients, Linearisation, Method, SchemeProperties, unlimited};
use crate::system_scales::HessianApproximation;

pub(super) const PROPERTIES: SchemeProperties =
    SchemeProperties { name: "implicit-midpoint", method: Method::Implicit(coefficients), step_limit: unlimited };

/// Coefficients of a step dt (s). The matrix needs the whole stiffness: the scheme has no numerical damping to compensate for less.
fn coefficients(dt: f64, _: History) -> ImplicitCoefficients {
    ImplicitCoefficients {
        effective_dt: 0.5 * dt,
        history: 0.0,
        stage: 0.5,
        first: Linearisation::Predicted,
        hessian: HessianApproximation::UpperBound,
    }
}
