//! Force of bodies on an obstacle.

use super::{Quantity, Reading, Subject};

/// Norm of the force of all bodies on an obstacle, N.
pub(super) static OBSTACLE_FORCE: Quantity = Quantity {
    name: "obstacle-force",
    summary: "Force of all bodies on an obstacle, N.",
    unit: "N",
    subject: Subject::Obstacle,
    read,
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> f64 {
    reading.session.obstacles().get(reading.of).map_or(0.0, |obstacle| obstacle.force.norm())
}
