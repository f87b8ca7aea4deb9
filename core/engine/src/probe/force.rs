//! Force on the hand.

use super::{Quantity, Reading, Subject};

/// Norm of the force on the hand before force safety, N.
pub(super) static FORCE: Quantity = Quantity {
    name: "force",
    summary: "Force on the hand before force safety, N.",
    unit: "N",
    subject: Subject::Tool,
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.frame.tools.get(reading.of).map_or(0.0, |tool| tool.force.norm())
}
