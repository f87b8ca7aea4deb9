//! A load that follows what it pulls at: a few nodes, weighted, on a spring.
//!
//! The linear contact model of a step: the place `g = sum w x` is pulled with `F = force - stiffness (g - anchor) -
//! damping dg/dt`. Explicit schemes evaluate it in every substep; implicit ones add its stiffness, of low rank, to the
//! matrix without filling it.

use super::{Block, V3, axpy, times};

/// Pulls at a weighted place of a body.
#[derive(Clone, Debug, Default)]
pub struct Attachment {
    /// Nodes.
    pub nodes: Vec<u32>,
    /// 1 (sum 1)
    pub weights: Vec<f64>,
    /// N, at the anchor
    pub force: V3,
    /// N/m
    pub stiffness: Block,
    /// N s/m
    pub damping: Block,
    /// m, the place at which `force` holds
    pub anchor: V3,
}

impl Attachment {
    /// `sum w u` of a field on the nodes.
    pub fn gather(&self, field: &[V3]) -> V3 {
        self.nodes.iter().zip(&self.weights).fold([0.0; 3], |sum, (&n, &w)| axpy(sum, w, field[n as usize]))
    }

    /// Adds `w f` to the nodes.
    pub fn scatter(&self, f: V3, field: &mut [V3]) {
        for (&n, &w) in self.nodes.iter().zip(&self.weights) {
            field[n as usize] = axpy(field[n as usize], w, f);
        }
    }

    /// N, on the body in a state; without `v`, its elastic part.
    pub fn load(&self, x: &[V3], v: Option<&[V3]>) -> V3 {
        let moved = axpy(self.gather(x), -1.0, self.anchor);
        let f = axpy(self.force, -1.0, times(&self.stiffness, moved));
        v.map_or(f, |v| axpy(f, -1.0, times(&self.damping, self.gather(v))))
    }

    /// `sum w^2 / m`: what a unit force at the place does to its own acceleration, 1/kg.
    pub fn compliance(&self, mass: &[f64]) -> f64 {
        self.nodes.iter().zip(&self.weights).map(|(&n, &w)| w * w / mass[n as usize]).sum()
    }

    /// Becomes the same as `other`, in its own buffers.
    pub fn copy_from(&mut self, other: &Self) {
        self.nodes.clone_from(&other.nodes);
        self.weights.clone_from(&other.weights);
        (self.force, self.anchor) = (other.force, other.anchor);
        (self.stiffness, self.damping) = (other.stiffness, other.damping);
    }

    /// No nodes, no force; keeps its buffers.
    pub fn clear(&mut self) {
        self.nodes.clear();
        self.weights.clear();
        (self.force, self.stiffness, self.damping) = ([0.0; 3], [0.0; 9], [0.0; 9]);
    }
}
