//! The nodes of a body and their state.

use super::algebra::Vec3;
use super::constraint::Constraint;

/// The nodes of a body and their state, an array for each quantity.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    /// Rest positions, m (n x 3).
    pub rest: Vec<Vec3>,
    /// Positions, m (n x 3).
    pub x: Vec<Vec3>,
    /// Velocities, m/s (n x 3).
    pub v: Vec<Vec3>,
    /// Lumped masses, kg (n).
    pub mass: Vec<f64>,
    /// Kinematic constraints (n).
    pub constraint: Vec<Constraint>,
    /// Prescribed velocity of each node in its constrained directions, m/s (n x 3).
    pub prescribed: Vec<Vec3>,
}

impl Nodes {
    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// Nodes at rest positions `rest`, m (n x 3): not moving, free and without mass.
    pub fn at_rest(rest: Vec<Vec3>) -> Self {
        let n = rest.len();
        Self {
            x: rest.clone(),
            rest,
            v: vec![Vec3::zeros(); n],
            mass: vec![0.0; n],
            constraint: vec![Constraint::Free; n],
            prescribed: vec![Vec3::zeros(); n],
        }
    }

    /// Adds a node at rest, free and without mass. Returns its index.
    pub fn add(&mut self, rest: Vec3) -> u32 {
        self.rest.push(rest);
        self.x.push(rest);
        self.v.push(Vec3::zeros());
        self.mass.push(0.0);
        self.constraint.push(Constraint::Free);
        self.prescribed.push(Vec3::zeros());
        self.len() as u32 - 1
    }

    /// Adds a node interpolated from others with weights that add up to 1; it is fixed if all of them are. Returns its index.
    pub fn add_between(&mut self, of: &[(u32, f64)]) -> u32 {
        let mean = |field: &[Vec3]| of.iter().map(|(n, w)| *w * field[*n as usize]).sum::<Vec3>();
        let (rest, x, v, prescribed) = (mean(&self.rest), mean(&self.x), mean(&self.v), mean(&self.prescribed));
        let held = of.iter().all(|(n, _)| self.constraint[*n as usize] == Constraint::Fixed);
        let node = self.add(rest);
        let i = node as usize;
        (self.x[i], self.v[i], self.prescribed[i]) = (x, v, prescribed);
        self.constraint[i] = if held { Constraint::Fixed } else { Constraint::Free };
        node
    }

    /// The nodes with these indices, in this order.
    ///
    /// # Panics
    /// If an index is not below the number of nodes.
    #[must_use]
    pub fn select(&self, indices: &[u32]) -> Self {
        let of = |field: &[Vec3]| indices.iter().map(|i| field[*i as usize]).collect();
        Self {
            rest: of(&self.rest),
            x: of(&self.x),
            v: of(&self.v),
            mass: indices.iter().map(|i| self.mass[*i as usize]).collect(),
            constraint: indices.iter().map(|i| self.constraint[*i as usize]).collect(),
            prescribed: of(&self.prescribed),
        }
    }

    /// Removes and returns the nodes from index `at` on.
    pub fn split_off(&mut self, at: usize) -> Self {
        Self {
            rest: self.rest.split_off(at),
            x: self.x.split_off(at),
            v: self.v.split_off(at),
            mass: self.mass.split_off(at),
            constraint: self.constraint.split_off(at),
            prescribed: self.prescribed.split_off(at),
        }
    }

    /// Frees a node that a contact constrained.
    pub fn release(&mut self, node: u32) {
        (self.constraint[node as usize], self.prescribed[node as usize]) = (Constraint::Free, Vec3::zeros());
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self) -> f64 {
        self.v.iter().zip(&self.mass).map(|(v, m)| 0.5 * m * v.norm_squared()).sum()
    }
}
