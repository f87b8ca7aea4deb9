//! Force of bodies on an obstacle.

use super::{Measure, Quantity, Reading, Subject};
use pliant_solver::Vec3;

/// Force of all bodies on an obstacle, N.
pub(super) static OBSTACLE_FORCE: Quantity = Quantity {
    name: "obstacle-force",
    summary: "Force of all bodies on an obstacle, N.",
    unit: "N",
    subject: Subject::Obstacle,
    measure: Measure::Vector(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> Vec3 {
    reading.session.obstacles().get(reading.of).map_or(Vec3::zeros(), |obstacle| obstacle.force)
}
