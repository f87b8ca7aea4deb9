//! BDF2, the backward differentiation formula of second order (Gear 1971): `x_1 = 4/3 x - 1/3 x_before + 2/3 dt v_1`, and v_1 likewise.

use super::{Definition, History, ImplicitCoefficients, Linearisation, Method, backward_euler, unlimited};
use crate::system_scales::HessianApproximation;

pub(super) const DEFINITION: Definition =
    Definition { name: "bdf2", method: Method::Implicit(coefficients), step_limit: unlimited };

/// Without a smooth history a step is one of backward Euler. The matrix needs the whole stiffness: with less, one Newton step would
/// amplify.
fn coefficients(dt: f64, history: History) -> ImplicitCoefficients {
    match history {
        History::Broken => backward_euler::coefficients(dt, history),
        History::Smooth => ImplicitCoefficients {
            g: 2.0 / 3.0 * dt,
            history: 1.0 / 3.0,
            stage: 1.0,
            first: Linearisation::Predicted,
            hessian: HessianApproximation::UpperBound,
        },
    }
}
