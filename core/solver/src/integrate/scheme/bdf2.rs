//! BDF2, the second-order backward differentiation formula (Gear 1971): `x_1 = 4/3 x - 1/3 x_before + 2/3 dt v_1`, and v_1 likewise.

use super::{History, ImplicitCoefficients, Linearisation, Method, SchemeProperties, backward_euler, unlimited};
use crate::system_scales::HessianApproximation;

pub(super) const PROPERTIES: SchemeProperties =
    SchemeProperties { name: "bdf2", method: Method::Implicit(coefficients), step_limit: unlimited };

/// Coefficients of a step dt (s); those of backward Euler without a usable previous state. The matrix needs the whole stiffness: with less, one
/// Newton iteration amplifies errors.
fn coefficients(dt: f64, history: History) -> ImplicitCoefficients {
    match history {
        History::Interrupted => backward_euler::coefficients(dt, history),
        History::Continuous => ImplicitCoefficients {
            effective_dt: 2.0 / 3.0 * dt,
            history: 1.0 / 3.0,
            stage: 1.0,
            first: Linearisation::Predicted,
            hessian: HessianApproximation::UpperBound,
        },
    }
}
