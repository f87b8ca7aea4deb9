//! Backward Euler: `M (v - v_0) = dt f(x + dt v)`, with one Newton iteration linearised at the present state (Baraff and Witkin 1998).

use super::{History, ImplicitCoefficients, Linearisation, Method, SchemeProperties, unlimited};
use crate::system_scales::HessianApproximation;

pub(super) const PROPERTIES: SchemeProperties =
    SchemeProperties { name: "backward-euler", method: Method::Implicit(coefficients), step_limit: unlimited };

/// Coefficients of a step dt (s). One Newton iteration is stable with at least half of the exact stiffness in the matrix.
pub(in crate::integrate) fn coefficients(dt: f64, _: History) -> ImplicitCoefficients {
    ImplicitCoefficients {
        effective_dt: dt,
        history: 0.0,
        stage: 1.0,
        first: Linearisation::Current,
        hessian: HessianApproximation::AtLeastHalf,
    }
}
