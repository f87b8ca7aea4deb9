//! The nodes of all bodies that may meet in a step, one body after the other.

use pliant_solver::{Constraint, Vec3};

/// State of the nodes between the start and the end of a step.
#[derive(Default)]
pub(super) struct CollisionNodes {
    /// Positions at the start, m (n x 3).
    pub start: Vec<Vec3>,
    /// Positions at the end, m (n x 3).
    pub x: Vec<Vec3>,
    /// Velocities at the end, m/s (n x 3).
    pub v: Vec<Vec3>,
    /// Inverse masses, 1/kg (n); 0 of a node that nothing moves.
    pub inverse_mass: Vec<f64>,
    /// About the velocity change of each node for an impulse of 1 N s in a step, 1/kg (n): by its mass and the stiffness around it.
    pub scale: Vec<f64>,
    /// Impulses that each node has had in its body's own step for the contact of the step before, N s (n x 3).
    pub predicted: Vec<Vec3>,
    /// Directions that are free (n).
    pub constraint: Vec<Constraint>,
}

impl CollisionNodes {
    /// Removes all nodes.
    pub fn clear(&mut self) {
        self.start.clear();
        self.x.clear();
        self.v.clear();
        self.inverse_mass.clear();
        self.scale.clear();
        self.predicted.clear();
        self.constraint.clear();
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether contact can move a node in every direction.
    pub fn is_free(&self, node: usize) -> bool {
        self.inverse_mass[node] > 0.0 && self.constraint[node].is_free()
    }

    /// Velocity change of a node by an impulse (N s), m/s.
    pub fn response(&self, node: usize, impulse: Vec3) -> Vec3 {
        self.inverse_mass[node] * self.constraint[node].filter(impulse)
    }

    /// Kinetic energy of the nodes with a mass, J.
    pub fn kinetic_energy(&self) -> f64 {
        let massive = self.v.iter().zip(&self.inverse_mass).filter(|(_, w)| **w > 0.0);
        massive.map(|(v, w)| 0.5 / w * v.norm_squared()).sum()
    }
}
