//! A soft region coupled to a hand by a spring in its mean position and mean rotation.
//!
//! Force and torque act on the region as a body force with a smooth density, so the displacement is that of a regularised point load (de Goes
//! and James 2017) in the actual body: it has no plateau and no spike at the hand, at any grid level. The region does not become rigid: only
//! its mean position and its mean rotation follow the hand.
//!
//! Let s_i be load fractions (sum 1), `d_i = x_i - c` the positions relative to the mean c, and `Q (X_i - C)` the relative positions at the time of
//! the grip, rotated with the hand. The error of the mean rotation is `phi = I^-1 sum s_i d_i x Q (X_i - C)` with
//! `I = sum s_i (d_i^2 - d_i d_i^T)`, which needs no polar decomposition. The force on a node is `f_i = K s_i (e + phi x d_i)`, where e is the
//! error of the mean position. This is the projection of springs with stiffness K s_i at all nodes onto rigid motions, and so never stiffer than
//! those springs. It does not depend on the rest shape, so another hand may change or keep that without a jump of the force.

use super::BodyPoint;
use super::brush::{Brush, BrushShape};
use crate::body::{Body, LatticeError, NodeKey};
use crate::tool::{Hand, Tool, diagonal};
use nalgebra::{Matrix3, UnitQuaternion};
use pliant_solver::{Nodes, Vec3};

/// A soft region that follows a hand.
pub(super) struct CoupledRegion {
    shape: BrushShape,
    /// Whether it follows the orientation of the hand too.
    turns: bool,
    brush: Brush,
    attachment: Option<Attachment>,
}

/// The nodes that a hand holds.
struct Attachment {
    /// Rotation from axes of the hand to those of the scene at the time of the grip.
    initial_rotation: UnitQuaternion<f64>,
    /// What is held of each node of the brush (k).
    nodes: Vec<HeldNode>,
    /// Number of nodes of the body.
    count: usize,
    /// Version of the body's node numbering for which the brush is valid.
    numbering: u64,
}

/// A node that a hand holds.
#[derive(Clone, Copy)]
struct HeldNode {
    /// Its name, which stays when nodes are renumbered.
    key: NodeKey,
    /// Its falloff at the time of the grip, 0 to 1.
    weight: f64,
    /// Its position relative to the hand at zero force, in axes of the hand, m.
    anchor: Vec3,
}

impl CoupledRegion {
    /// A region of this shape; [`CoupledRegion::follow`] attaches it to the hand.
    pub fn new(shape: BrushShape, turns: bool) -> Self {
        Self { shape, turns, brush: Brush::default(), attachment: None }
    }

    /// Its radius on a body with this cell edge, both in m.
    pub fn radius(&self, edge: f64) -> f64 {
        self.shape.radius_at(edge)
    }

    /// Lets go of the region.
    pub fn release(&mut self) {
        self.attachment = None;
        self.brush.clear();
    }

    /// Pulls the region around a point of `body` to the hand. Returns the sum of the magnitudes of the forces on its nodes, N.
    ///
    /// # Errors
    /// Returns the error of the grid plugin.
    pub fn follow(&mut self, tool: &mut Tool, hand: &Hand, body: &Body, at: BodyPoint) -> Result<f64, LatticeError> {
        self.attach(tool, hand, body, at)?;
        let Some(attachment) = &self.attachment else { return Ok(0.0) };
        let nodes = &body.system.nodes;
        let now = self.brush.mean(&nodes.x);
        let position_error = hand.position + hand.rotation * self.mean_anchor(attachment) - now;
        let rotation_error = match self.turns {
            true => self.rotation_error(nodes, attachment, hand.rotation),
            false => Vec3::zeros(),
        };
        tool.proxy.position = hand.position - position_error;
        tool.depth = (now - self.brush.mean(&nodes.rest)).norm();
        let (k, damping) = (tool.coupling.stiffness, tool.coupling.damping);
        let pulled = |n: u32| k * (position_error + rotation_error.cross(&(nodes.x[n as usize] - now)));
        let fractions = || self.brush.nodes.iter().copied().zip(self.brush.fraction.iter().copied());
        let magnitude: f64 = fractions().map(|(n, fraction)| fraction * pulled(n).norm()).sum();
        let springs = tool.springs_mut(at.body as usize);
        for (n, fraction) in fractions() {
            let (stiffness, damping) = (diagonal(fraction * k), diagonal(fraction * damping));
            springs.push(n, fraction * pulled(n), stiffness, damping, nodes.x[n as usize]);
        }
        tool.limit_springs(body, at.body, at.rest, magnitude)?;
        Ok(tool.coupling_factor * magnitude)
    }

    /// Attaches the nodes around a point to the hand, again if their numbering has changed. Nothing is attached if there is no free node.
    fn attach(&mut self, tool: &Tool, hand: &Hand, body: &Body, at: BodyPoint) -> Result<(), LatticeError> {
        let (numbering, nodes) = (tool.numbering(at.body), &body.system.nodes);
        let key = |n: u32| body.discretization.node_key(n);
        if let Some(attachment) = &mut self.attachment {
            let stays = |(&n, held): (&u32, &HeldNode)| nodes.constraint[n as usize].is_free() && key(n) == held.key;
            // The rest shape alone may have changed, as when another hand keeps the present one.
            let is_renumbered = attachment.numbering != numbering
                && !(attachment.count == nodes.len() && self.brush.nodes.iter().zip(&attachment.nodes).all(stays));
            if !is_renumbered {
                attachment.numbering = numbering;
                return Ok(());
            }
        }
        let mut before = self.attachment.take();
        self.brush.cover(body, at.rest, self.shape)?;
        if self.brush.is_empty() {
            return Ok(());
        }
        if let Some(before) = &mut before {
            before.nodes.sort_unstable_by_key(|held| held.key);
        }
        let known: Vec<Option<HeldNode>> =
            self.brush.nodes.iter().map(|&n| before.as_ref().and_then(|before| before.find(key(n)))).collect();
        // A region without any node of the one before is another one.
        let initial_rotation = match before {
            Some(before) if known.iter().any(Option::is_some) => before.initial_rotation,
            _ => hand.rotation,
        };
        let from_hand = |n: u32| hand.rotation.inverse() * (nodes.x[n as usize] - hand.position);
        let rest = |n: u32| nodes.rest[n as usize];
        // A node that a cut has made, or one that was freed, is held as the nearest one that was held before.
        let beside = |n: u32| {
            let held = self.brush.nodes.iter().zip(&known).filter_map(|(&m, known)| known.map(|known| (m, known)));
            let nearest = held.min_by(|(a, _), (b, _)| {
                (rest(*a) - rest(n)).norm_squared().total_cmp(&(rest(*b) - rest(n)).norm_squared())
            });
            nearest.map(|(m, known)| known.anchor + initial_rotation.inverse() * (rest(n) - rest(m)))
        };
        let each = self.brush.nodes.iter().zip(&self.brush.weight).zip(&known);
        let held = each.map(|((&n, &weight), known)| {
            known.unwrap_or_else(|| HeldNode { key: key(n), weight, anchor: beside(n).unwrap_or_else(|| from_hand(n)) })
        });
        let held: Vec<HeldNode> = held.collect();
        self.brush.set_weights(held.iter().map(|held| held.weight), nodes);
        self.attachment = Some(Attachment { initial_rotation, nodes: held, count: nodes.len(), numbering });
        Ok(())
    }

    /// Mean position of the region relative to the hand at zero force, in axes of the hand, m.
    fn mean_anchor(&self, attachment: &Attachment) -> Vec3 {
        self.brush.fraction.iter().zip(&attachment.nodes).map(|(fraction, held)| *fraction * held.anchor).sum()
    }

    /// Mean rotation vector from the region to where the hand, with this rotation, holds it, rad.
    fn rotation_error(&self, nodes: &Nodes, attachment: &Attachment, rotation: UnitQuaternion<f64>) -> Vec3 {
        let (now, centre) = (self.brush.mean(&nodes.x), self.mean_anchor(attachment));
        let (mut inertia, mut moment) = (Matrix3::zeros(), Vec3::zeros());
        for ((&n, fraction), held) in self.brush.nodes.iter().zip(&self.brush.fraction).zip(&attachment.nodes) {
            let (d, wanted) = (nodes.x[n as usize] - now, rotation * (held.anchor - centre));
            inertia += *fraction * (d.norm_squared() * Matrix3::identity() - d * d.transpose());
            moment += *fraction * d.cross(&wanted);
        }
        // Collinear nodes have no rotation about their line, and the inertia is singular.
        inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * moment)
    }
}

impl Attachment {
    /// The held node with this key; its nodes must be sorted by key.
    fn find(&self, key: NodeKey) -> Option<HeldNode> {
        self.nodes.binary_search_by_key(&key, |held| held.key).ok().map(|at| self.nodes[at])
    }
}
