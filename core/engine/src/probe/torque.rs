//! Torque on the hand.

use super::{Quantity, Reading, Subject};

/// Norm of the torque on the hand about its position, N m; zero for edits that do not turn with the hand.
pub(super) static TORQUE: Quantity = Quantity {
    name: "torque",
    summary: "Torque on the hand about its position, of an edit that turns with it (`grab`), N m.",
    unit: "N m",
    subject: Subject::Tool,
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.frame.tools.get(reading.of).map_or(0.0, |tool| tool.torque.norm())
}
