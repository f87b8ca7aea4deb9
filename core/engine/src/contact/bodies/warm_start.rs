//! Impulses of the last step, from which the next solve starts, by the features of their contacts.

use super::contact::{ContactSet, FeatureKey, ImpulseLaw};
use pliant_solver::Vec3;

/// Impulses of contacts, by features.
#[derive(Default)]
pub(super) struct WarmStart {
    /// Features and impulses (N s), ascending by features.
    impulses: Vec<(FeatureKey, Vec3)>,
}

impl WarmStart {
    /// Records the impulses of contacts.
    pub fn record(&mut self, set: &ContactSet) {
        self.impulses.clear();
        let pushing =
            set.contacts.iter().filter(|contact| contact.impulse[0] > 0.0 || contact.law != ImpulseLaw::Unilateral);
        self.impulses.extend(pushing.map(|contact| (contact.data.key, contact.total())));
        self.impulses.sort_by_key(|(key, _)| *key);
        // Features that met more than once in a step have one contact at rest.
        self.impulses.dedup_by_key(|(key, _)| *key);
    }

    /// Forgets all impulses.
    pub fn clear(&mut self) {
        self.impulses.clear();
    }

    /// Gives the contacts from number `first` on the impulses that their features had.
    pub fn apply(&self, set: &mut ContactSet, first: usize) {
        for contact in &mut set.contacts[first..] {
            let Ok(at) = self.impulses.binary_search_by_key(&contact.data.key, |(key, _)| *key) else { continue };
            let impulse = self.impulses[at].1;
            if let ImpulseLaw::Tie { .. } = contact.law {
                contact.impulse = contact.project(impulse.into());
                continue;
            }
            let [s, t] = contact.tangents;
            let normal = contact.normal.dot(&impulse).max(0.0);
            contact.impulse = match contact.data.friction == [0.0; 2] {
                true => [normal, 0.0, 0.0],
                false => [normal, s.dot(&impulse), t.dot(&impulse)],
            };
        }
    }
}
