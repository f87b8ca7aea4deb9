//! Probes: quantities that a run can measure.
//!
//! Each quantity is one file with a [`Quantity`]: its name in scenes, its subject, its requirements and a function that reads it. A new one is
//! added by its file and its line in [`QUANTITIES`].

mod area;
mod contact_force;
mod cut_area;
mod cut_length;
mod depth;
mod displacement;
mod elastic_energy;
mod force;
mod kinetic_energy;
mod obstacle_force;
mod parts;
mod torque;
mod volume;

use crate::body::Body;
use crate::session::{Frame, Session};
use pliant_solver::Vec3;
use std::fmt;

/// Every quantity, in the order of the help text.
pub static QUANTITIES: &[&Quantity] = &[
    &force::FORCE,
    &depth::DEPTH,
    &displacement::DISPLACEMENT,
    &torque::TORQUE,
    &kinetic_energy::KINETIC_ENERGY,
    &elastic_energy::ELASTIC_ENERGY,
    &parts::PARTS,
    &volume::VOLUME,
    &area::AREA,
    &cut_area::CUT_AREA,
    &cut_length::CUT_LENGTH,
    &obstacle_force::OBSTACLE_FORCE,
    &contact_force::CONTACT_FORCE,
];

/// A quantity that a probe can measure.
pub struct Quantity {
    /// Name in scenes.
    pub name: &'static str,
    /// One sentence with the unit, for help and the schema.
    pub summary: &'static str,
    /// SI unit of its value, `1` for a count.
    pub unit: &'static str,
    /// Whether it is measured of a tool, a body or an obstacle.
    pub subject: Subject,
    /// Whether energies must be computed for it.
    pub needs_energy: bool,
    /// Whether all vertices must be up to date when it is read.
    pub needs_surface: bool,
    /// Whether a probe must have a point (`at`).
    pub needs_place: bool,
    /// Whether it can be read of a part of a body, `BODY.part1` and on in scenes.
    pub reads_parts: bool,
    /// Whether it is read only in the steps in which a probe is due, as reading is slow. A probe of the largest value is due in every step.
    pub is_costly: bool,
    /// Reads the value, SI.
    pub measure: Measure,
}

/// How a quantity is read, SI.
#[derive(Clone, Copy)]
pub enum Measure {
    /// A single number, which a probe measures as it is.
    Scalar(fn(&Reading<'_>) -> f64),
    /// A vector along the axes of the scene; a probe measures its length, or its component along the probe's `direction`.
    Vector(fn(&Reading<'_>) -> Vec3),
}

/// The subject of a quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A tool in use.
    Tool,
    /// A body of the scene.
    Body,
    /// An obstacle of the scene.
    Obstacle,
}

/// The state that a quantity is read from, after a step.
pub struct Reading<'a> {
    /// Session after the step.
    pub session: &'a Session,
    /// The frame of the step.
    pub frame: &'a Frame,
    /// Index of the tool among those in use, or of the body or obstacle in the scene.
    pub of: usize,
    /// The part of the body, counted from 0; `None` for all of it.
    pub part: Option<u32>,
    /// The vertex nearest to the probe's point; 0 for a probe without one.
    pub vertex: usize,
}

impl Reading<'_> {
    /// The body of the probe; `None` if it is not simulated.
    fn body(&self) -> Option<&Body> {
        self.session.body_of_scene(self.of)
    }

    /// Sum of a value of the present corners (m) of each triangle of the body, or of its part, without those that have failed; 0 for a body that is not simulated, NaN for a part that
    /// is not there.
    fn sum_of_triangles(&self, value: impl Fn([Vec3; 3]) -> f64) -> f64 {
        let Some(body) = self.body() else { return 0.0 };
        let triangles = &body.model.surface.triangles;
        let value = |t: &[u32; 3]| value(t.map(|v| body.skin.x[v as usize]));
        let Some(part) = self.part else {
            let left = triangles.iter().zip(0..).filter(|(_, t)| !body.failed_triangles.contains(*t));
            return left.map(|(corners, _)| value(corners)).sum();
        };
        let parts = body.parts();
        if !parts.contains(&part) {
            return f64::NAN;
        }
        triangles.iter().zip(parts).filter(|(_, of)| *of == part).map(|(t, _)| value(t)).sum()
    }
}

impl Quantity {
    /// The quantity with a name.
    pub fn find(name: &str) -> Option<&'static Self> {
        QUANTITIES.iter().copied().find(|quantity| quantity.name == name)
    }

    /// Defaults: a quantity of a body without requirements.
    const OF_BODY: Self = Self {
        name: "",
        summary: "",
        unit: "1",
        subject: Subject::Body,
        needs_energy: false,
        needs_surface: false,
        needs_place: false,
        reads_parts: false,
        is_costly: false,
        measure: Measure::Scalar(|_| 0.0),
    };

    /// Whether a probe can measure a component of it along a direction.
    pub fn is_vector(&self) -> bool {
        matches!(self.measure, Measure::Vector(_))
    }

    /// Its value, SI: of a vector the length, or the component along `direction` (a unit vector, which a number ignores).
    pub fn value(&self, reading: &Reading<'_>, direction: Option<Vec3>) -> f64 {
        match self.measure {
            Measure::Scalar(read) => read(reading),
            Measure::Vector(read) => {
                let vector = read(reading);
                direction.map_or_else(|| vector.norm(), |along| vector.dot(&along))
            }
        }
    }
}

impl fmt::Debug for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for Quantity {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_differ_and_are_found() {
        for quantity in QUANTITIES {
            assert_eq!(QUANTITIES.iter().filter(|other| other.name == quantity.name).count(), 1);
            assert!(Quantity::find(quantity.name).is_some_and(|found| std::ptr::eq(found, *quantity)));
            assert!(!quantity.name.is_empty() && quantity.summary.ends_with('.'));
        }
        assert!(Quantity::find("").is_none());
    }
}
