//! Contacts of features: how velocities of nodes make the two sides part and slide, and what is known of the impulses.

use super::features::{Gap, Kind};
use super::nodes::CollisionNodes;
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

/// Features of a contact by what stays from step to step: bodies, and vertices by their numbers in the surfaces of these bodies; or the number of a tie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FeatureKey {
    /// A vertex and a triangle.
    VertexTriangle([(u32, u32); 4]),
    /// Two edges that cross, by the bodies and vertices of their ends.
    EdgeEdge([(u32, u32); 4]),
    /// A tie, by its number, which stays from step to step.
    Tie(u32),
}

/// The key of the features of a kind.
pub(super) fn feature_key(kind: Kind, vertices: [(u32, u32); 4]) -> FeatureKey {
    match kind {
        Kind::VertexTriangle => FeatureKey::VertexTriangle(vertices),
        Kind::EdgeEdge => FeatureKey::EdgeEdge(vertices),
    }
}

/// Which impulses a contact may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Law {
    /// It pushes, with Coulomb friction.
    Unilateral,
    /// It ties two points: any impulse up to this magnitude, N s.
    Tie {
        /// Infinite for a tie that holds whatever comes.
        most: f64,
    },
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
    /// Which impulses it may have.
    pub law: Law,
    /// Velocities along the normal and the two tangents that are sought: the least one along the normal for what pushes, all three for a tie, m/s.
    pub bounds: [f64; 3],
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
        nodes: &CollisionNodes,
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
        let contact = Contact {
            shares,
            normal,
            tangents,
            data,
            law: Law::Unilateral,
            bounds: [data.bound, 0.0, 0.0],
            compliance: 0.0,
            tangential: [0.0; 3],
            scale: 0.0,
            impulse: [0.0; 3],
            slides: false,
        };
        self.push(contact, nodes);
    }

    /// Adds a tie of two points, each carried by nodes with weights that add up to 1: node numbers among those of all members, with the weights of the second
    /// point negated. `bounds` are the velocities (m/s) of the first point relative to the second that are sought, `most` the largest impulse (N s). Ties nothing if no node of it can move.
    pub fn add_tie(
        &mut self,
        carriers: &[(u32, f64)],
        nodes: &CollisionNodes,
        data: ContactData,
        most: f64,
        bounds: Vec3,
    ) {
        let first = self.shares.len();
        self.shares.extend(carriers.iter().map(|&(node, weight)| Share { node, weight, turn: [0.0; 2] }));
        let contact = Contact {
            shares: [first as u32, self.shares.len() as u32],
            normal: Vec3::x(),
            tangents: [Vec3::y(), Vec3::z()],
            data,
            law: Law::Tie { most },
            bounds: bounds.into(),
            compliance: 0.0,
            tangential: [0.0; 3],
            scale: 0.0,
            impulse: [0.0; 3],
            slides: false,
        };
        self.push(contact, nodes);
    }

    /// Adds a contact whose shares are the last ones, unless no node of it can move.
    fn push(&mut self, mut contact: Contact, nodes: &CollisionNodes) {
        let first = contact.shares[0] as usize;
        for share in &self.shares[first..] {
            let rows = contact.rows(share);
            let moved = rows.map(|row| nodes.response(share.node as usize, row));
            contact.compliance += rows[0].dot(&moved[0]);
            contact.tangential[0] += rows[1].dot(&moved[1]);
            contact.tangential[1] += rows[1].dot(&moved[2]);
            contact.tangential[2] += rows[2].dot(&moved[2]);
            contact.scale += nodes.scale[share.node as usize] * share.weight * share.weight;
        }
        let along_surface = contact.tangential[0] + contact.tangential[2];
        let is_tie = contact.law != Law::Unilateral;
        if contact.compliance > 0.0 || (is_tie && along_surface > 0.0) {
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

    /// The impulse (N s) nearest to `wanted` that it may have: what ties is limited in size, what pushes has a normal impulse of at least 0 and friction within
    /// the disc of that.
    pub fn project(&self, wanted: [f64; 3]) -> [f64; 3] {
        match self.law {
            Law::Tie { most } => {
                let size = Vec3::from(wanted).norm();
                let shrink = if size > most { most / size } else { 1.0 };
                wanted.map(|impulse| shrink * impulse)
            }
            Law::Unilateral => {
                let normal = wanted[0].max(0.0);
                let radius = self.data.friction[usize::from(self.slides)] * normal;
                let size = (wanted[1] * wanted[1] + wanted[2] * wanted[2]).sqrt();
                let shrink = if size > radius { radius / size } else { 1.0 };
                [normal, shrink * wanted[1], shrink * wanted[2]]
            }
        }
    }

    /// Impulse on its first side, N s.
    pub fn total(&self) -> Vec3 {
        let [n, s, t] = self.impulse;
        n * self.normal + s * self.tangents[0] + t * self.tangents[1]
    }
}
