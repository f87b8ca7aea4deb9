//! Force of other bodies on a body.

use super::{Measure, Quantity, Reading};
use pliant_solver::Vec3;

/// Force of other bodies on a body, mean over the last step, N.
pub(super) static CONTACT_FORCE: Quantity = Quantity {
    name: "contact-force",
    summary: "Force of all other bodies on a body, mean over a step, N.",
    unit: "N",
    measure: Measure::Vector(read),
    ..Quantity::OF_BODY
};

fn read(reading: &Reading<'_>) -> Vec3 {
    let bodies = &reading.session.bodies;
    let place = reading.body().and_then(|body| bodies.iter().position(|other| std::ptr::eq(other, body)));
    place.map_or(Vec3::zeros(), |body| reading.session.contact_force(body))
}
