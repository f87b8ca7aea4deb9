//! Probes: what a run can measure of itself.
//!
//! A quantity is one file: a [`Quantity`] with its name in scenes, what it is measured of, what it needs and how it is read. A new
//! one is added by its file and its line in [`QUANTITIES`].

mod cut_area;
mod cut_length;
mod depth;
mod displacement;
mod elastic_energy;
mod force;
mod kinetic_energy;
mod parts;
mod torque;
mod volume;

use crate::body::Body;
use crate::session::{Frame, Session};
use std::fmt;

/// Every quantity, in the order help lists them.
pub static QUANTITIES: &[&Quantity] = &[
    &force::FORCE,
    &depth::DEPTH,
    &displacement::DISPLACEMENT,
    &torque::TORQUE,
    &kinetic_energy::KINETIC_ENERGY,
    &elastic_energy::ELASTIC_ENERGY,
    &parts::PARTS,
    &volume::VOLUME,
    &cut_area::CUT_AREA,
    &cut_length::CUT_LENGTH,
];

/// Something a probe can measure.
pub struct Quantity {
    /// As scenes write it.
    pub name: &'static str,
    /// One sentence with the unit, for help and the schema.
    pub summary: &'static str,
    /// SI unit of its value, `1` for a count.
    pub unit: &'static str,
    /// What it is measured of.
    pub subject: Subject,
    /// Whether energies must be computed for it.
    pub needs_energy: bool,
    /// Whether the surface must be up to date when it is read.
    pub needs_surface: bool,
    /// Whether a probe must say at which place (`at`).
    pub needs_place: bool,
    /// Whether reading takes so long that it is done only when the probe is due; a probe of the `greatest` value is due in every step.
    pub is_costly: bool,
    /// Its value, SI.
    pub read: fn(&Reading<'_>) -> f64,
}

/// What a quantity is measured of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// A tool in use.
    Tool,
    /// A body of the scene.
    Body,
}

/// What a quantity is read from.
pub struct Reading<'a> {
    /// The session, after a step.
    pub session: &'a Session,
    /// The end of that step.
    pub frame: &'a Frame,
    /// Place of the tool among the tools in use, or of the body in the scene.
    pub of: usize,
    /// The vertex nearest to the probe's place; 0 where it has none.
    pub vertex: usize,
}

impl Reading<'_> {
    /// The body it is read of, if that moves.
    fn body(&self) -> Option<&Body> {
        self.session.body_of_scene(self.of)
    }
}

impl Quantity {
    /// The quantity of a name, if there is one.
    pub fn find(name: &str) -> Option<&'static Self> {
        QUANTITIES.iter().copied().find(|quantity| quantity.name == name)
    }

    /// What most quantities are: of a body, and cheap.
    const OF_BODY: Self = Self {
        name: "",
        summary: "",
        unit: "1",
        subject: Subject::Body,
        needs_energy: false,
        needs_surface: false,
        needs_place: false,
        is_costly: false,
        read: |_| 0.0,
    };
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
