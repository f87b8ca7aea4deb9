//! A soft region coupled to a hand by a spring in its mean position and mean rotation.
//!
//! Force and torque act on the region as a body force with a smooth density, so the displacement is that of a regularised point load (de Goes
//! and James 2017) in the actual body: it has no plateau and no spike at the hand, at any grid level. The region does not become rigid: only
//! its mean position and its mean rotation follow the hand.
//!
//! Let s_i be load fractions (sum 1), `d_i = x_i - c` the positions relative to the mean c, and `Q (X_i - C)` the relative rest positions rotated
//! with the hand. The error of the mean rotation is `phi = I^-1 sum s_i d_i x Q (X_i - C)` with `I = sum s_i (d_i^2 - d_i d_i^T)`, which needs
//! no polar decomposition. The force on a node is `f_i = K s_i (e + phi x d_i)`, where e is the error of the mean position. This is the
//! projection of springs with stiffness K s_i at all nodes onto rigid motions, and so never stiffer than those springs.

use super::BodyPoint;
use super::brush::{Brush, BrushShape};
use crate::body::{Body, LatticeError};
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

/// The pose of a region relative to the hand at zero force.
#[derive(Clone, Copy)]
struct Attachment {
    /// From the hand to the mean position of the region, in axes of the hand, m.
    offset: Vec3,
    /// Rotation from axes of the hand to those of the scene at the time of the grip.
    initial_rotation: UnitQuaternion<f64>,
    /// Mean rotation vector of the region relative to its rest shape at the time of the grip, rad.
    initial_rotation_error: Vec3,
    /// Mean rest position of the region, m.
    rest: Vec3,
    /// Version of the body's node numbering for which the brush is valid.
    numbering: u64,
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
        let Some(attachment) = self.attach(tool, hand, body, at)? else { return Ok(0.0) };
        let nodes = &body.system.nodes;
        let now = self.brush.mean(&nodes.x);
        let position_error = hand.position + hand.rotation * attachment.offset - now;
        let rotation_error = match self.turns {
            true => {
                self.rotation_error(nodes, hand.rotation * attachment.initial_rotation.inverse())
                    + attachment.initial_rotation_error
            }
            false => Vec3::zeros(),
        };
        tool.proxy.position = hand.position - position_error;
        tool.depth = (now - attachment.rest).norm();
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

    /// Attaches the nodes around a point to the hand, again if their numbering has changed. `None` if there is no free node.
    fn attach(
        &mut self,
        tool: &Tool,
        hand: &Hand,
        body: &Body,
        at: BodyPoint,
    ) -> Result<Option<Attachment>, LatticeError> {
        let numbering = tool.numbering(at.body);
        if self.attachment.is_some_and(|attachment| attachment.numbering == numbering) {
            return Ok(self.attachment);
        }
        self.brush.cover(body, at.rest, self.shape)?;
        if self.brush.is_empty() {
            self.attachment = None;
            return Ok(None);
        }
        let nodes = &body.system.nodes;
        let rest = self.brush.mean(&nodes.rest);
        self.attachment = Some(match self.attachment {
            // Different nodes of the same region: the offset to the hand follows the mean rest position.
            Some(attachment) => Attachment {
                offset: attachment.offset + attachment.initial_rotation.inverse() * (rest - attachment.rest),
                rest,
                numbering,
                ..attachment
            },
            None => Attachment {
                offset: hand.rotation.inverse() * (self.brush.mean(&nodes.x) - hand.position),
                initial_rotation: hand.rotation,
                initial_rotation_error: -self.rotation_error(nodes, UnitQuaternion::identity()),
                rest,
                numbering,
            },
        });
        Ok(self.attachment)
    }

    /// Mean rotation vector from the region to its rest shape rotated by `turn`, rad.
    fn rotation_error(&self, nodes: &Nodes, turn: UnitQuaternion<f64>) -> Vec3 {
        let [now, rest] = [&nodes.x, &nodes.rest].map(|field| self.brush.mean(field));
        let (mut inertia, mut moment) = (Matrix3::zeros(), Vec3::zeros());
        for (&n, fraction) in self.brush.nodes.iter().zip(&self.brush.fraction) {
            let (d, wanted) = (nodes.x[n as usize] - now, turn * (nodes.rest[n as usize] - rest));
            inertia += *fraction * (d.norm_squared() * Matrix3::identity() - d * d.transpose());
            moment += *fraction * d.cross(&wanted);
        }
        // Collinear nodes have no rotation about their line, and the inertia is singular.
        inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * moment)
    }
}
