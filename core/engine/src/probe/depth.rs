//! How far a tool pushes the surface in or pulls it out.

use super::{Quantity, Reading, Subject};

/// How far a tool pushes the surface in or pulls it out.
pub(super) static DEPTH: Quantity = Quantity {
    name: "depth",
    summary: "How far the surface is pushed in, or pulled out, at the contact, m.",
    unit: "m",
    subject: Subject::Tool,
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.frame.tools.get(reading.of).map_or(0.0, |tool| tool.depth)
}
