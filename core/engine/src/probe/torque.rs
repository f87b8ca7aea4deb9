//! Torque on the hand.

use super::{Measure, Quantity, Reading, Subject};
use pliant_solver::Vec3;

/// Torque on the hand about its position, N m; zero for edits that do not turn with the hand.
pub(super) static TORQUE: Quantity = Quantity {
    name: "torque",
    summary: "Torque on the hand about its position, of an edit that turns with it (`grab`), N m.",
    unit: "N m",
    subject: Subject::Tool,
    measure: Measure::Vector(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> Vec3 {
    reading.frame.tools.get(reading.of).map_or(Vec3::zeros(), |tool| tool.torque)
}
