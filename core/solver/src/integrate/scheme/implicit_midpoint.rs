//! Implicit midpoint: `M (v - v_0) = dt/2 f(x + dt/2 v)` for the velocity v halfway; the step ends at `x + dt v` with `2 v - v_0`.

use super::{Definition, History, ImplicitCoefficients, Linearisation, Method, unlimited};
use crate::system_scales::HessianApproximation;

pub(super) const DEFINITION: Definition =
    Definition { name: "implicit-midpoint", method: Method::Implicit(coefficients), step_limit: unlimited };

/// The matrix needs the whole stiffness: the scheme has no damping that would absorb less.
fn coefficients(dt: f64, _: History) -> ImplicitCoefficients {
    ImplicitCoefficients {
        g: 0.5 * dt,
        history: 0.0,
        stage: 0.5,
        first: Linearisation::Predicted,
        hessian: HessianApproximation::UpperBound,
    }
}
