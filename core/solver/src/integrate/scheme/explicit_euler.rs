//! Explicit Euler as printed by Qi, Zhu and Fan (2019): positions from the old velocities, then velocities from the old forces.

use super::{ExplicitOrder, Method, SchemeProperties};
use crate::integrate::limit::{Frequencies, StepLimit};

pub(super) const PROPERTIES: SchemeProperties =
    SchemeProperties { name: "explicit-euler", method: Method::Explicit(ExplicitOrder::PositionFirst), step_limit };

/// Every mode needs `w^2 dt < d_mode`: with damping proportional to stiffness that is `dt < d / w^2` below critical damping, and
/// `dt < 2 / d` for the fastest overdamped mode. Without damping no step is stable.
fn step_limit(found: &Frequencies) -> StepLimit {
    let (w, d) = (found.stiffness, found.damping);
    if d == 0.0 {
        StepLimit::At(0.0)
    } else if d >= 2.0 * w {
        StepLimit::At(2.0 / (0.5 * d + (0.25 * d * d - w * w).max(0.0).sqrt()))
    } else {
        StepLimit::At(d / (w * w))
    }
}
