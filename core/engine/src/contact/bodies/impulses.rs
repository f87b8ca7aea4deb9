//! Inelastic impulses at contacts by the masses of nodes alone, with Coulomb friction: what takes away the collisions that the implicit solve of
//! contact ([`super::dual`]) leaves.
//!
//! The impulses minimise kinetic energy under the condition that no contact closes faster than its gap allows, by projected Gauss-Seidel iteration in
//! the order of the contacts (Moreau 1988; Bridson, Fedkiw and Anderson 2002). Each update is the minimum along its own impulse, so
//! kinetic energy never grows; each impulse acts on both sides, so linear and angular momentum stay. Elastic energy may grow.

use super::contact::{Contact, ContactSet, Share};
use super::nodes::CollisionNodes;
use pliant_solver::Vec3;

/// Most sweeps over the contacts.
const MAX_SWEEPS: usize = 60;
/// Change of a velocity in a sweep below which the iteration ends, relative to the fastest approach.
const TOLERANCE: f64 = 1e-4;
/// Growth of energy that is rounding, relative to it.
const ROUNDING: f64 = 1e-13;

/// The solver of impulses.
#[derive(Default)]
pub(super) struct Impulses {
    /// The contacts that are solved together, with their impulses so far.
    pub set: ContactSet,
    before: Vec<Vec3>,
}

impl Impulses {
    /// Finds the impulses and applies them: velocities change by them, and positions by what velocities change in `remaining` (s).
    pub fn apply(&mut self, nodes: &mut CollisionNodes, remaining: f64) {
        self.before.clone_from(&nodes.v);
        let energy = nodes.kinetic_energy();
        let (contacts, shares) = self.set.parts();
        let is_driven = contacts.iter().flat_map(|contact| contact.shares(shares)).any(|share| {
            let i = share.node as usize;
            !nodes.is_free(i) && nodes.v[i] != Vec3::zeros()
        });
        iterate(contacts, shares, nodes);
        // A cone that shrinks in the iteration gives back some of what friction has taken; without friction nothing can.
        if !is_driven && nodes.kinetic_energy() > (1.0 + ROUNDING) * energy {
            nodes.v.clone_from(&self.before);
            for contact in &mut *contacts {
                (contact.data.friction, contact.impulse) = ([0.0; 2], [0.0; 3]);
            }
            iterate(contacts, shares, nodes);
        }
        for ((x, v), before) in nodes.x.iter_mut().zip(&nodes.v).zip(&self.before) {
            *x += remaining * (v - before);
        }
    }
}

fn iterate(contacts: &mut [Contact], shares: &[Share], nodes: &mut CollisionNodes) {
    let approach = |contact: &Contact| (contact.bounds[0] - contact.velocities(shares, &nodes.v)[0]).max(0.0);
    let tolerance = TOLERANCE * contacts.iter().map(approach).fold(0.0, f64::max);
    for _ in 0..MAX_SWEEPS {
        let mut change = 0.0_f64;
        for contact in contacts.iter_mut() {
            change = change.max(update(contact, shares, nodes));
        }
        if change <= tolerance {
            break;
        }
    }
}

fn push(contact: &Contact, shares: &[Share], nodes: &mut CollisionNodes, impulse: [f64; 3]) {
    for share in contact.shares(shares) {
        let rows = contact.rows(share);
        let total = impulse[0] * rows[0] + impulse[1] * rows[1] + impulse[2] * rows[2];
        let change = nodes.response(share.node as usize, total);
        nodes.v[share.node as usize] += change;
    }
}

/// Updates the impulses of a contact. Returns the change of a relative velocity, m/s.
fn update(contact: &mut Contact, shares: &[Share], nodes: &mut CollisionNodes) -> f64 {
    let [normal, ..] = contact.velocities(shares, &nodes.v);
    let next = (contact.impulse[0] + (contact.bounds[0] - normal) / contact.compliance).max(0.0);
    let by = next - contact.impulse[0];
    contact.impulse[0] = next;
    let mut change = (by * contact.compliance).abs();
    if by != 0.0 {
        push(contact, shares, nodes, [by, 0.0, 0.0]);
    }
    let [kept, sliding] = contact.data.friction.map(|f| f * contact.impulse[0]);
    if kept == 0.0 && contact.impulse[1..] == [0.0; 2] {
        return change;
    }
    let [_, p, q] = contact.velocities(shares, &nodes.v);
    let [a, b, c] = contact.tangential;
    let determinant = a * c - b * b;
    if determinant <= 1e-12 * a * c {
        return change;
    }
    let [_, s, t] = contact.impulse;
    let wanted = [s - (c * p - b * q) / determinant, t - (a * q - b * p) / determinant];
    let size = (wanted[0] * wanted[0] + wanted[1] * wanted[1]).sqrt();
    let scale = if size <= kept { 1.0 } else { sliding / size };
    let next = wanted.map(|f| scale * f);
    let by = [next[0] - s, next[1] - t];
    contact.impulse[1..].copy_from_slice(&next);
    if by != [0.0; 2] {
        push(contact, shares, nodes, [0.0, by[0], by[1]]);
        change = change.max(by[0].abs().max(by[1].abs()) * a.max(c));
    }
    change
}
