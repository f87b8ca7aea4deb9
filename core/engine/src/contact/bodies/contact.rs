//! Contacts of two features: their relative velocities as sums over nodes, their constraints, and their impulses.

use super::features::{Gap, Kind};
use super::nodes::CollisionNodes;
use pliant_solver::Vec3;

/// Coefficients of a node in the relative velocity at a contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    /// Number of the node among those of all members.
    pub node: u32,
    /// Weight of the node's velocity in the relative velocity, 1.
    weight: f64,
    /// Weights of the node's normal velocity in the two tangential relative velocities, 1.
    turn: [f64; 2],
}

/// Identity of a contact that persists between steps. A vertex is a body and the number of the vertex in the surface of this body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FeatureKey {
    /// A vertex and a triangle.
    VertexTriangle([(u32, u32); 4]),
    /// Two edges that cross, by the bodies and vertices of their ends.
    EdgeEdge([(u32, u32); 4]),
    /// A tie, by its number, which persists between steps.
    Tie(u32),
}

/// The key of a contact of this kind between these vertices, each with its body.
pub(super) fn feature_key(kind: Kind, vertices: [(u32, u32); 4]) -> FeatureKey {
    match kind {
        Kind::VertexTriangle => FeatureKey::VertexTriangle(vertices),
        Kind::EdgeEdge => FeatureKey::EdgeEdge(vertices),
    }
}

/// Which impulses a contact may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ImpulseLaw {
    /// The normal impulse is at least 0, with Coulomb friction.
    Unilateral,
    /// Two points are tied: the impulse may have any direction.
    Tie {
        /// Largest magnitude of the impulse, N s; infinite for a tie that never yields.
        max_impulse: f64,
    },
}

/// Properties of a contact that do not follow from the positions of its vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactData {
    /// Lower bound of the separating velocity at the end of the step, m/s; negative while a gap is left.
    pub bound: f64,
    /// Static and kinetic coefficient of friction.
    pub friction: [f64; 2],
    /// Gap that the two surfaces keep, m.
    pub thickness: f64,
    /// Numbers of the bodies of the two sides.
    pub bodies: [u32; 2],
    /// Identity of its features between steps.
    pub key: FeatureKey,
}

/// A contact of two features.
pub(super) struct Contact {
    /// First and end index of its shares in those of the [`ContactSet`].
    shares: [u32; 2],
    /// Unit contact normal: from the triangle to the vertex, or from the first edge to the second; the x axis for a tie.
    pub normal: Vec3,
    /// Two unit tangents, normal to each other and to `normal`.
    pub tangents: [Vec3; 2],
    /// Bound, friction, thickness and bodies.
    pub data: ContactData,
    /// Which impulses it may have.
    pub law: ImpulseLaw,
    /// Target velocities along the normal and the two tangents, m/s. For a unilateral contact the normal one is a lower bound and the tangential ones are 0;
    /// a tie meets all three.
    pub bounds: [f64; 3],
    /// Normal velocity per normal impulse of the lumped masses alone, 1/kg.
    pub compliance: f64,
    /// Tangential velocities per tangential impulse of the lumped masses alone, 1/kg: entries 11, 12 and 22 of a symmetric matrix.
    pub tangential: [f64; 3],
    /// Normal velocity per normal impulse by the diagonal of the matrices of both bodies, 1/kg: scales the variables of the solver.
    pub scale: f64,
    /// Present normal impulse and the two tangential ones, N s.
    pub impulse: [f64; 3],
    /// Whether it has begun to slide in this step.
    pub slides: bool,
}

/// Contacts that are solved together.
#[derive(Default)]
pub(super) struct ContactSet {
    /// The contacts, in the order in which they were added.
    pub contacts: Vec<Contact>,
    /// The shares of all contacts, one contact after the other.
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

    /// Adds a contact of four vertices, unless none of its nodes can move. `carriers` gives the nodes that carry a vertex: the number of the first node of its
    /// body, and numbers in that body with weights. A contact has no friction if its closest points are on the border of a feature.
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
            law: ImpulseLaw::Unilateral,
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
    /// point negated. `bounds` are the target velocities
    /// (m/s) of the first point relative to the second, `max_impulse` the largest impulse (N s). Adds nothing if none of its nodes can move.
    pub fn add_tie(
        &mut self,
        carriers: &[(u32, f64)],
        nodes: &CollisionNodes,
        data: ContactData,
        max_impulse: f64,
        bounds: Vec3,
    ) {
        let first = self.shares.len();
        self.shares.extend(carriers.iter().map(|&(node, weight)| Share { node, weight, turn: [0.0; 2] }));
        let contact = Contact {
            shares: [first as u32, self.shares.len() as u32],
            normal: Vec3::x(),
            tangents: [Vec3::y(), Vec3::z()],
            data,
            law: ImpulseLaw::Tie { max_impulse },
            bounds: bounds.into(),
            compliance: 0.0,
            tangential: [0.0; 3],
            scale: 0.0,
            impulse: [0.0; 3],
            slides: false,
        };
        self.push(contact, nodes);
    }

    /// Adds a contact whose shares are the last ones; removes these if none of its nodes can move.
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
        let is_tie = contact.law != ImpulseLaw::Unilateral;
        if contact.compliance > 0.0 || (is_tie && along_surface > 0.0) {
            self.contacts.push(contact);
        } else {
            self.shares.truncate(first);
        }
    }

    /// Separating velocity of a contact and its two tangential relative velocities, m/s, for velocities `v` of the nodes, m/s (n x 3).
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

    /// Memory of the contacts and their shares, bytes.
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

    /// Separating velocity and the two tangential relative velocities, m/s, for velocities `v` of the nodes, m/s (n x 3).
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

    /// Projects an impulse (N s) onto those that the law admits: a tie limits the magnitude; a unilateral contact has a normal impulse of at least 0, and
    /// friction within the disc of that.
    pub fn project(&self, impulse: [f64; 3]) -> [f64; 3] {
        match self.law {
            ImpulseLaw::Tie { max_impulse } => {
                let size = Vec3::from(impulse).norm();
                let shrink = if size > max_impulse { max_impulse / size } else { 1.0 };
                impulse.map(|component| shrink * component)
            }
            ImpulseLaw::Unilateral => {
                let normal = impulse[0].max(0.0);
                let radius = self.data.friction[usize::from(self.slides)] * normal;
                let size = (impulse[1] * impulse[1] + impulse[2] * impulse[2]).sqrt();
                let shrink = if size > radius { radius / size } else { 1.0 };
                [normal, shrink * impulse[1], shrink * impulse[2]]
            }
        }
    }

    /// Impulse on its first side, N s.
    pub fn total(&self) -> Vec3 {
        let [n, s, t] = self.impulse;
        n * self.normal + s * self.tangents[0] + t * self.tangents[1]
    }
}
