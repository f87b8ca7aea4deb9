//! Contact of a tip with the vertices of a sheet by a law of a plugin.

use super::fingertip::Tip;
use super::law::{LAW_MARGIN, LawContacts, LawForce, NearPoint};
use pliant_host::{ContactLaw, HostError};
use pliant_solver::{Nodes, StepTime, Vec3};
use std::sync::Arc;

/// Contacts of a tip with a sheet by a law.
pub(super) struct SheetLaw {
    contacts: LawContacts,
    /// Area of the undeformed sheet around each node, m^2 (n); empty if it is outdated.
    areas: Vec<f64>,
    /// Vertices at which the law acts in this step, by ascending node (buffer).
    near: Vec<NearPoint>,
}

/// Displacement of a node in a step, relative to the largest one in the last step, for which contacts are looked for ahead.
const AHEAD: f64 = 2.0;

impl SheetLaw {
    /// No contacts yet.
    pub fn new(law: Arc<ContactLaw>) -> Self {
        Self { contacts: LawContacts::new(law), areas: Vec::new(), near: Vec::new() }
    }

    /// The law, for contacts with another sheet by the same one.
    pub fn law(&self) -> Arc<ContactLaw> {
        self.contacts.shared_law()
    }

    /// Forgets what depends on the nodes of the sheet.
    pub fn invalidate(&mut self) {
        self.areas.clear();
    }

    /// The areas around nodes, if they are outdated: empty, to be filled.
    pub fn outdated_areas(&mut self) -> Option<&mut Vec<f64>> {
        Some(&mut self.areas).filter(|areas| areas.is_empty())
    }

    /// Ends all contacts; their histories are gone.
    pub fn leave(&mut self) {
        self.near.clear();
        self.contacts.clear_contacts();
    }

    /// Largest distance from the tip at which the law may act in a step, where no node has moved further than `moved` (m) in the last one, m.
    pub fn reach(&self, moved: f64) -> f64 {
        self.contacts.law().reach() + AHEAD * moved
    }

    /// Lists those of the `vertices`, nodes ascending with their positions (m), at which the law acts in a step of `dt` (s), for a tip whose path is at
    /// `centre` (m). Areas must be up to date.
    pub fn find(
        &mut self,
        tip: &Tip,
        centre: Vec3,
        vertices: impl Iterator<Item = (u32, Vec3)>,
        nodes: &Nodes,
        dt: f64,
    ) {
        self.contacts.margin = LAW_MARGIN * tip.length_scale();
        let Self { contacts, areas, near } = self;
        let point = |(key, point): (u32, Vec3)| {
            let mut normal = tip.shape.normal(point - centre).unwrap_or_else(Vec3::z);
            if contacts.normal_of(key).is_some_and(|old| old.dot(&normal) < 0.0) {
                normal = -normal; // the sheet has passed the centre; it is still pushed to the side it came from
            }
            let (drive, velocity) = (tip.velocity_at(point), nodes.v[key as usize]);
            let node = key as usize;
            let compliance = nodes.constraint[node].filter(normal).norm_squared() / nodes.mass[node];
            let (gap, mass) = (-tip.depth(point, normal), nodes.mass[node]);
            NearPoint { key, gap, normal, velocity, drive, area: areas[node], compliance, mass }
        };
        near.clear();
        near.extend(vertices.map(point).filter(|near| contacts.is_near(near, dt)));
    }

    /// Whether the last search has found vertices.
    pub fn is_near(&self) -> bool {
        !self.near.is_empty()
    }

    /// Computes the force at each vertex that was found.
    ///
    /// # Errors
    /// Returns the error of the law.
    pub fn press(
        &mut self,
        time: StepTime,
        is_explicit: bool,
    ) -> Result<impl Iterator<Item = (&NearPoint, &LawForce)>, HostError> {
        self.contacts.is_explicit = is_explicit;
        self.contacts.begin(self.near.drain(..));
        self.contacts.press(time)?;
        Ok(self.contacts.forces())
    }

    /// Ends a step, see [`LawContacts::advance`].
    ///
    /// # Errors
    /// Returns the error of the law.
    pub fn advance(&mut self, ended: impl Fn(usize) -> (Vec3, Vec3), time: StepTime) -> Result<(), HostError> {
        self.contacts.advance(ended, time)
    }
}
