//! A soft region joined to a hand by a spring in its degrees of freedom.
//!
//! Force and torque are spread over the region as a body force of a smooth density, so the displacement is that of a regularised
//! point load (de Goes and James 2017) in the body the model really is: no plateau and no needle at the hand, at any level of the
//! grid. The region is not made rigid: only its mean position and its mean rotation are held.
//!
//! With shares s_i (sum 1), arms `d_i = x_i - c` from the mean c, and the rest shape turned with the hand, `Q (X_i - C)`, the mean
//! rotation that is missing is `phi = I^-1 sum s_i d_i x Q (X_i - C)` with `I = sum s_i (d_i^2 - d_i d_i^T)`, so no polar decomposition
//! is needed. A node gets `f_i = K s_i (e + phi x d_i)`, where e is the mean position that is missing. This is the projection of springs
//! K s_i to all nodes onto rigid motions, and so never stiffer than those.

use super::ContactPlace;
use super::brush::{Brush, BrushShape};
use crate::body::{Body, LatticeError};
use crate::tool::{Hand, Tool, diagonal};
use nalgebra::{Matrix3, UnitQuaternion};
use pliant_solver::{Nodes, Vec3};

/// A region that follows a hand.
pub(super) struct Region {
    shape: BrushShape,
    /// Whether it turns with the hand.
    turns: bool,
    brush: Brush,
    joint: Option<Joint>,
}

/// How a region is joined to the hand.
#[derive(Clone, Copy)]
struct Joint {
    /// m, from the hand to the mean of the region when no force acts, in axes of the hand
    arm: Vec3,
    /// Turns axes of the hand into those of the scene, when it took hold.
    taken: UnitQuaternion<f64>,
    /// rad, the mean rotation of the region when it was taken, from its shape at rest
    turned: Vec3,
    /// m, the mean in the shape at rest
    rest: Vec3,
    /// Numbering of the body's nodes that the brush holds for.
    numbering: u64,
}

impl Region {
    /// Of a shape; it is joined to the hand when it first follows.
    pub fn new(shape: BrushShape, turns: bool) -> Self {
        Self { shape, turns, brush: Brush::default(), joint: None }
    }

    /// m, its radius on a body whose cells have this edge (m).
    pub fn radius(&self, edge: f64) -> f64 {
        self.shape.radius_at(edge)
    }

    /// Lets go of the region.
    pub fn release(&mut self) {
        self.joint = None;
        self.brush.clear();
    }

    /// Pulls the region around a place of `body` to the hand. Gives the force it takes, N: the sum over nodes of its size.
    ///
    /// # Errors
    /// What the grid says.
    pub fn follow(&mut self, tool: &mut Tool, hand: &Hand, body: &Body, at: ContactPlace) -> Result<f64, LatticeError> {
        let Some(joint) = self.join(tool, hand, body, at)? else { return Ok(0.0) };
        let nodes = &body.system.nodes;
        let now = self.brush.mean(&nodes.x);
        let missing = hand.position + hand.rotation * joint.arm - now;
        let lag = match self.turns {
            true => self.lag(nodes, hand.rotation * joint.taken.inverse()) + joint.turned,
            false => Vec3::zeros(),
        };
        tool.proxy.position = hand.position - missing;
        tool.depth = (now - joint.rest).norm();
        let (k, damping) = (tool.coupling.stiffness, tool.coupling.damping);
        let pulled = |n: u32| k * (missing + lag.cross(&(nodes.x[n as usize] - now)));
        let shares = || self.brush.nodes.iter().copied().zip(self.brush.share.iter().copied());
        let size: f64 = shares().map(|(n, share)| share * pulled(n).norm()).sum();
        let (scale, spring) = tool.cap(size);
        let springs = tool.springs_mut(at.body as usize);
        for (n, share) in shares() {
            let (stiffness, damping) = (diagonal(spring * share * k), diagonal(spring * share * damping));
            springs.push(n, scale * share * pulled(n), stiffness, damping, nodes.x[n as usize]);
        }
        Ok(size)
    }

    /// Covers the nodes around a place where their numbering has changed, and joins them to the hand. `None` where there is none.
    fn join(&mut self, tool: &Tool, hand: &Hand, body: &Body, at: ContactPlace) -> Result<Option<Joint>, LatticeError> {
        let numbering = tool.numbering(at.body);
        if self.joint.is_some_and(|joint| joint.numbering == numbering) {
            return Ok(self.joint);
        }
        self.brush.cover(body, at.rest, self.shape)?;
        if self.brush.is_empty() {
            self.joint = None;
            return Ok(None);
        }
        let nodes = &body.system.nodes;
        let rest = self.brush.mean(&nodes.rest);
        self.joint = Some(match self.joint {
            // Other nodes of the same rigid motion: the hand's way from the rest shape stays.
            Some(joint) => {
                Joint { arm: joint.arm + joint.taken.inverse() * (rest - joint.rest), rest, numbering, ..joint }
            }
            None => Joint {
                arm: hand.rotation.inverse() * (self.brush.mean(&nodes.x) - hand.position),
                taken: hand.rotation,
                turned: -self.lag(nodes, UnitQuaternion::identity()),
                rest,
                numbering,
            },
        });
        Ok(self.joint)
    }

    /// rad, the mean rotation missing from the shape at rest turned by `turn`.
    fn lag(&self, nodes: &Nodes, turn: UnitQuaternion<f64>) -> Vec3 {
        let [now, rest] = [&nodes.x, &nodes.rest].map(|field| self.brush.mean(field));
        let (mut inertia, mut moment) = (Matrix3::zeros(), Vec3::zeros());
        for (&n, share) in self.brush.nodes.iter().zip(&self.brush.share) {
            let (d, wanted) = (nodes.x[n as usize] - now, turn * (nodes.rest[n as usize] - rest));
            inertia += *share * (d.norm_squared() * Matrix3::identity() - d * d.transpose());
            moment += *share * d.cross(&wanted);
        }
        // Nodes on one line have no rotation about it.
        inertia.try_inverse().map_or(Vec3::zeros(), |inverse| inverse * moment)
    }
}
