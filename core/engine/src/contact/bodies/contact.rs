//! Contacts of features: how velocities of nodes make the two sides part and slide, and what is known of the impulses.

use super::features::{Gap, Kind};
use super::nodes::MeetingNodes;
use pliant_solver::Vec3;

/// Coefficients of a node in the relative velocity at a contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    /// Number of the node among those of all members.
    pub node: u32,
    /// Of its velocity in the relative velocity.
    weight: f64,
    /// Of its velocity along the normal in the two tangential relative velocities.
    turn: [f64; 2],
}

/// Features of a contact by what stays from step to step: bodies, and vertices by their numbers in the surfaces of these bodies.
pub(super) type FeatureKey = (bool, [(u32, u32); 4]);

/// The key of the features of a kind.
pub(super) fn feature_key(kind: Kind, vertices: [(u32, u32); 4]) -> FeatureKey {
    (kind == Kind::EdgeEdge, vertices)
}

/// What a contact is made of, beside its geometry.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactData {
    /// Least velocity with which the two sides part at the end of the step, m/s: negative as far as a gap is left.
    pub bound: f64,
    /// Static and kinetic coefficient of friction.
    pub friction: [f64; 2],
    /// Gap that the two surfaces keep, m.
    pub thickness: f64,
    /// Bodies of the two sides.
    pub bodies: [u32; 2],
    /// Its features.
    pub key: FeatureKey,
}

/// A contact of two features.
pub(super) struct Contact {
    /// Its shares, as a range.
    shares: [u32; 2],
    pub normal: Vec3,
    pub tangents: [Vec3; 2],
    pub data: ContactData,
    /// Normal velocity for each N s of normal impulse by masses alone, 1/kg.
    pub compliance: f64,
    /// Tangential velocities for tangential impulses by masses alone, 1/kg: entries 11, 12 and 22.
    pub tangential: [f64; 3],
    /// The same for a normal impulse by the diagonal of the matrices, 1/kg: a scale.
    pub scale: f64,
    /// Normal impulse and the two tangential ones so far, N s.
    pub impulse: [f64; 3],
    /// Whether it has begun to slide in this step.
    pub slides: bool,
}

/// Contacts that are solved together.
#[derive(Default)]
pub(super) struct ContactSet {
    /// The contacts, in the order in which they were added.
    pub contacts: Vec<Contact>,
    shares: Vec<Share>,
}

impl ContactSet {
    /// Removes all contacts.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.shares.clear();
    }

    /// Whether there are no contacts.
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// Adds a contact of four vertices, each with the nodes that carry it (number of the first node of their body, numbers and weights), unless
    /// no node of it can move. Without inner closest points nothing acts along the surface.
    pub fn add<'a>(
        &mut self,
        gap: &Gap,
        carriers: impl Fn(usize) -> (u32, &'a [(u32, f64)]),
        nodes: &MeetingNodes,
        mut data: ContactData,
    ) {
        let first = self.shares.len();
        let normal = gap.normal;
        let along = Vec3::ith(normal.iamin(), 1.0).cross(&normal).normalize();
        let tangents = [along, normal.cross(&along)];
        for vertex in 0..4 {
            let turn = tangents.map(|t| gap.distance * t.dot(&gap.turn[vertex]));
            let (base, list) = carriers(vertex);
            for &(node, weight) in list {
                let node = base + node;
                let own = Share { node, weight: weight * gap.weights[vertex], turn: turn.map(|t| weight * t) };
                match self.shares[first..].iter_mut().find(|share| share.node == node) {
                    Some(share) => {
                        share.weight += own.weight;
                        share.turn[0] += own.turn[0];
                        share.turn[1] += own.turn[1];
                    }
                    None => self.shares.push(own),
                }
            }
        }
        if !gap.is_inside {
            data.friction = [0.0; 2];
        }
        let shares = [first as u32, self.shares.len() as u32];
        let mut contact = Contact {
            shares,
            normal,
            tangents,
            data,
            compliance: 0.0,
            tangential: [0.0; 3],
            scale: 0.0,
            impulse: [0.0; 3],
            slides: false,
        };
        for share in &self.shares[first..] {
            let rows = contact.rows(share);
            let moved = rows.map(|row| nodes.response(share.node as usize, row));
            contact.compliance += rows[0].dot(&moved[0]);
            contact.tangential[0] += rows[1].dot(&moved[1]);
            contact.tangential[1] += rows[1].dot(&moved[2]);
            contact.tangential[2] += rows[2].dot(&moved[2]);
            contact.scale += nodes.scale[share.node as usize] * share.weight * share.weight;
        }
        if contact.compliance > 0.0 {
            self.contacts.push(contact);
        } else {
            self.shares.truncate(first);
        }
    }

    /// Velocities with which the two sides of a contact part and slide for velocities `v` of the nodes, m/s.
    pub fn velocities(&self, contact: &Contact, v: &[Vec3]) -> [f64; 3] {
        contact.velocities(&self.shares, v)
    }

    /// Adds the impulses of all contacts on the nodes to `to` (N s, n x 3).
    pub fn add_impulses(&self, to: &mut [Vec3]) {
        for contact in self.contacts.iter().filter(|contact| contact.impulse != [0.0; 3]) {
            for share in contact.shares(&self.shares) {
                let rows = contact.rows(share);
                let [n, s, t] = contact.impulse;
                to[share.node as usize] += n * rows[0] + s * rows[1] + t * rows[2];
            }
        }
    }

    /// Calls `visit` with the bodies of each contact and the impulse on the first of them, N s.
    pub fn visit(&self, mut visit: impl FnMut([u32; 2], Vec3)) {
        for contact in &self.contacts {
            visit(contact.data.bodies, contact.total());
        }
    }

    /// The contacts, and the shares of all of them.
    pub fn parts(&mut self) -> (&mut [Contact], &[Share]) {
        (&mut self.contacts, &self.shares)
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        self.contacts.capacity() * size_of::<Contact>() + self.shares.capacity() * size_of::<Share>()
    }
}

impl Contact {
    /// Impulses on a node for a unit normal impulse and two unit tangential ones.
    pub fn rows(&self, share: &Share) -> [Vec3; 3] {
        let tangential = |k: usize| share.weight * self.tangents[k] + share.turn[k] * self.normal;
        [share.weight * self.normal, tangential(0), tangential(1)]
    }

    /// Its shares among those of all contacts.
    pub fn shares<'a>(&self, shares: &'a [Share]) -> &'a [Share] {
        &shares[self.shares[0] as usize..self.shares[1] as usize]
    }

    /// Velocities with which the two sides part and slide, m/s.
    pub fn velocities(&self, shares: &[Share], v: &[Vec3]) -> [f64; 3] {
        let mut relative = Vec3::zeros();
        let mut turn = [0.0; 2];
        for share in self.shares(shares) {
            let v = v[share.node as usize];
            relative += share.weight * v;
            let along = self.normal.dot(&v);
            turn[0] += share.turn[0] * along;
            turn[1] += share.turn[1] * along;
        }
        let [a, b] = self.tangents;
        [self.normal.dot(&relative), a.dot(&relative) + turn[0], b.dot(&relative) + turn[1]]
    }

    /// Impulse on its first side, N s.
    pub fn total(&self) -> Vec3 {
        let [n, s, t] = self.impulse;
        n * self.normal + s * self.tangents[0] + t * self.tangents[1]
    }
}
