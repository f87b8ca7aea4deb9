//! Symplectic (semi-implicit) Euler: velocities with the old forces, then positions with the new velocities.

use super::{Definition, ExplicitOrder, Method};
use crate::integrate::limit::{Frequencies, StepLimit};

pub(super) const DEFINITION: Definition =
    Definition { name: "symplectic-euler", method: Method::Explicit(ExplicitOrder::VelocityFirst), step_limit };

/// `(w dt)^2 + 2 d dt < 4`.
fn step_limit(found: &Frequencies) -> StepLimit {
    let (w, d) = (found.stiffness, found.damping);
    if w == 0.0 { StepLimit::At(2.0 / d) } else { StepLimit::At(((d * d + 4.0 * w * w).sqrt() - d) / (w * w)) }
}
