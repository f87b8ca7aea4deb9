//! Depth to which a tool displaces the surface.

use super::{Measure, Quantity, Reading, Subject};

/// Depth to which the surface is pushed in, or pulled out, at the contact of a tool, m.
pub(super) static DEPTH: Quantity = Quantity {
    name: "depth",
    summary: "How far the surface is pushed in, or pulled out, at the contact, m.",
    unit: "m",
    subject: Subject::Tool,
    measure: Measure::Scalar(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.frame.tools.get(reading.of).map_or(0.0, |tool| tool.depth)
}
