//! Linear springs and dampers of a tool on the nodes of a body, for one step.
//!
//! The force on a node is `F = force - stiffness (x - anchor) - damping v`. Explicit schemes evaluate it in every substep; implicit ones add
//! its blocks to the diagonal of the matrix. The stiffness of a load that is distributed over several nodes by weights is lumped: each node gets
//! its share. The lumped matrix is an upper bound of the exact one, which has rank 3, so a step that is stable with the exact one stays stable.

use super::algebra::{Block, Vec3, matrix3};
use super::integrate::limit::SpringRates;

/// Springs and dampers on some nodes, an array for each quantity.
#[derive(Debug, Default)]
pub struct NodeSprings {
    /// Indices of the nodes, ascending (k).
    pub nodes: Vec<u32>,
    /// Force at the anchor, N (k x 3).
    pub force: Vec<Vec3>,
    /// Stiffness, N/m (k blocks).
    pub stiffness: Vec<Block>,
    /// Damping, N s/m (k blocks).
    pub damping: Vec<Block>,
    /// Position at which the force is `force`, m (k x 3).
    pub anchor: Vec<Vec3>,
}

impl NodeSprings {
    /// Removes all springs; keeps the buffers.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.force.clear();
        self.stiffness.clear();
        self.damping.clear();
        self.anchor.clear();
    }

    /// Whether there are no springs.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Adds a spring on a node; nodes must be added in ascending order.
    pub fn push(&mut self, node: u32, force: Vec3, stiffness: Block, damping: Block, anchor: Vec3) {
        self.nodes.push(node);
        self.force.push(force);
        self.stiffness.push(stiffness);
        self.damping.push(damping);
        self.anchor.push(anchor);
    }

    /// Scales forces, stiffness and damping.
    pub fn scale(&mut self, factor: f64) {
        self.force.iter_mut().for_each(|f| *f *= factor);
        self.stiffness.iter_mut().chain(&mut self.damping).flatten().for_each(|b| *b *= factor);
    }

    /// The largest stiffness of a node along an axis, N/m; 0 without springs.
    pub fn max_stiffness(&self) -> f64 {
        self.stiffness.iter().map(largest).fold(0.0, f64::max)
    }

    /// Force of spring i, N; without `v` its elastic part.
    #[inline(always)]
    fn load(&self, i: usize, x: &[Vec3], v: Option<&[Vec3]>) -> Vec3 {
        let node = self.nodes[i] as usize;
        let f = self.force[i] - matrix3(&self.stiffness[i]) * (x[node] - self.anchor[i]);
        v.map_or(f, |v| f - matrix3(&self.damping[i]) * v[node])
    }

    /// Adds the forces, N, to `force` (n x 3), at positions `x`, m, and velocities `v`, m/s; without `v` the elastic part.
    pub fn add_to(&self, force: &mut [Vec3], x: &[Vec3], v: Option<&[Vec3]>) {
        for (i, &node) in self.nodes.iter().enumerate() {
            force[node as usize] += self.load(i, x, v);
        }
    }

    /// Potential energy of the springs relative to their anchors, J.
    pub fn potential(&self, x: &[Vec3]) -> f64 {
        let each = self.nodes.iter().enumerate().map(|(i, &node)| {
            let d = x[node as usize] - self.anchor[i];
            0.5 * d.dot(&(matrix3(&self.stiffness[i]) * d)) - self.force[i].dot(&d)
        });
        each.sum()
    }

    /// Work on nodes whose positions (m) and velocities (m/s) went from `before` to `after`, J: exact for the springs, by the mean velocity for the
    /// dampers.
    pub fn work(&self, before: [&[Vec3]; 2], after: [&[Vec3]; 2]) -> f64 {
        let damped = self.nodes.iter().enumerate().map(|(i, &node)| {
            let node = node as usize;
            let (moved, v) = (after[0][node] - before[0][node], 0.5 * (before[1][node] + after[1][node]));
            moved.dot(&(matrix3(&self.damping[i]) * v))
        });
        self.potential(before[0]) - self.potential(after[0]) - damped.sum::<f64>()
    }

    /// Sum of all forces, N.
    pub fn total(&self, x: &[Vec3], v: &[Vec3]) -> Vec3 {
        (0..self.nodes.len()).map(|i| self.load(i, x, Some(v))).sum()
    }

    /// Moment of all forces about `centre` (m), N m.
    pub fn moment(&self, centre: Vec3, x: &[Vec3], v: &[Vec3]) -> Vec3 {
        let each = self.nodes.iter().enumerate();
        each.map(|(i, &node)| (x[node as usize] - centre).cross(&self.load(i, x, Some(v)))).sum()
    }

    /// The largest stiffness over mass and damping over mass of a node, for masses `mass`, kg (n).
    pub fn rates(&self, mass: &[f64]) -> SpringRates {
        let mut rates = SpringRates::default();
        for (i, &node) in self.nodes.iter().enumerate() {
            let m = mass[node as usize];
            rates.stiffness = rates.stiffness.max(largest(&self.stiffness[i]) / m);
            rates.damping = rates.damping.max(largest(&self.damping[i]) / m);
        }
        rates
    }
}

/// Largest element of the diagonal.
fn largest(b: &Block) -> f64 {
    b[0].max(b[4]).max(b[8])
}
