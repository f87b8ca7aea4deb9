//! Nodes and their state.

use super::algebra::Vec3;
use super::constraint::Constraint;

/// Nodes and their state.
#[derive(Clone, Debug, Default)]
pub struct Nodes {
    /// m (n x 3)
    pub rest: Vec<Vec3>,
    /// m (n x 3)
    pub x: Vec<Vec3>,
    /// m/s (n x 3)
    pub v: Vec<Vec3>,
    /// kg (n)
    pub mass: Vec<f64>,
    /// (n)
    pub constraint: Vec<Constraint>,
    /// m/s, what the constrained part of each node does (n x 3)
    pub prescribed: Vec<Vec3>,
}

impl Nodes {
    /// Nodes there are.
    pub fn len(&self) -> usize {
        self.x.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.x.is_empty()
    }

    /// At rest, free and without mass.
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

    /// One more, at rest, free and without mass. Gives its number.
    pub fn add(&mut self, rest: Vec3) -> u32 {
        self.rest.push(rest);
        self.x.push(rest);
        self.v.push(Vec3::zeros());
        self.mass.push(0.0);
        self.constraint.push(Constraint::Free);
        self.prescribed.push(Vec3::zeros());
        self.len() as u32 - 1
    }

    /// One more between others, given with weights: held if they all are. Gives its number.
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

    /// Takes off all from `at` on.
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

    /// J
    pub fn kinetic_energy(&self) -> f64 {
        self.v.iter().zip(&self.mass).map(|(v, m)| 0.5 * m * v.norm_squared()).sum()
    }
}
