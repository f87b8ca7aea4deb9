//! Force on the hand.

use super::{Measure, Quantity, Reading, Subject};
use pliant_solver::Vec3;

/// Force on the hand before force safety, N.
pub(super) static FORCE: Quantity = Quantity {
    name: "force",
    summary: "Force on the hand before force safety, N.",
    unit: "N",
    subject: Subject::Tool,
    measure: Measure::Vector(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> Vec3 {
    reading.frame.tools.get(reading.of).map_or(Vec3::zeros(), |tool| tool.force)
}
