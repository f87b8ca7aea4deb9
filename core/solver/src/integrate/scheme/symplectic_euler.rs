//! Symplectic (semi-implicit) Euler: velocities from the old forces, then positions from the new velocities.

use super::{ExplicitOrder, Method, SchemeProperties};
use crate::integrate::limit::{Frequencies, StepLimit};

pub(super) const PROPERTIES: SchemeProperties =
    SchemeProperties { name: "symplectic-euler", method: Method::Explicit(ExplicitOrder::VelocityFirst), step_limit };

/// Stability limit `(w dt)^2 + 2 d dt < 4`, with the frequency w and the damping rate d.
fn step_limit(found: &Frequencies) -> StepLimit {
    let (w, d) = (found.stiffness, found.damping);
    if w == 0.0 { StepLimit::At(2.0 / d) } else { StepLimit::At(((d * d + 4.0 * w * w).sqrt() - d) / (w * w)) }
}
