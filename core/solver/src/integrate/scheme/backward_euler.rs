//! Backward Euler: `M (v - v_0) = dt f(x + dt v)`. One Newton step, linearised at the present state, is what a haptic loop can afford
//! (Baraff and Witkin 1998).

use super::{Definition, History, ImplicitCoefficients, Linearisation, Method, unlimited};
use crate::system_scales::HessianApproximation;

pub(super) const DEFINITION: Definition =
    Definition { name: "backward-euler", method: Method::Implicit(coefficients), step_limit: unlimited };

/// With half of the exact stiffness in the matrix one Newton step is still stable.
pub(super) fn coefficients(dt: f64, _: History) -> ImplicitCoefficients {
    ImplicitCoefficients {
        g: dt,
        history: 0.0,
        stage: 1.0,
        first: Linearisation::Current,
        hessian: HessianApproximation::AtLeastHalf,
    }
}
