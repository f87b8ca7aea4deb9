//! Stability limits of the time step.

use super::scheme::Scheme;
use crate::algebra::Vec3;
use crate::coupled::CoupledHinges;
use crate::force_model::{ForceError, StepTime};
use crate::matrix::Matrix;
use crate::nodes::Nodes;
use crate::system::System;
use crate::system_scales::{HessianApproximation, SystemScales};
use crate::threads::Pool;

/// Upper bounds of a body's angular frequencies and decay rates, linearised about its present state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frequencies {
    /// Highest angular frequency, the square root of the largest eigenvalue of `M^-1 K`, rad/s: power iteration with a margin of 5 %, at most
    /// Gershgorin's bound.
    pub stiffness: f64,
    /// Gershgorin's bound of the same frequency, rad/s: rigorous, and 16 to 33 % higher.
    pub bound: f64,
    /// Largest eigenvalue of `M^-1 C`, 1/s, likewise.
    pub damping: f64,
}

/// The largest stable step of a scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepLimit {
    /// Stable up to this step, s; zero means unstable at any step.
    At(f64),
    /// Stable at any step for convex energies.
    None,
}

/// Stiffness and damping of a spring on a node, divided by the mass of the node.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SpringRates {
    /// Stiffness over mass, 1/s^2.
    pub stiffness: f64,
    /// Damping over mass, 1/s.
    pub damping: f64,
}

/// Number of power iterations.
const ITERATIONS: usize = 40;
/// Safety factor on the result of the power iteration, which converges from below.
const MARGIN: f64 = 1.05;

impl Frequencies {
    /// Computes the bounds of a body in its present state. Builds its matrix if it has none, and drops it again.
    ///
    /// # Errors
    /// Returns the error of the material.
    pub fn of(system: &mut System, pool: &Pool) -> Result<Self, ForceError> {
        let had = system.matrix.is_some();
        if !had {
            system.enable_matrix();
        }
        let mut matrix = system.matrix.take().unwrap_or_default();
        let mut coupled = system.coupled.take();
        let found = Self::measure(system, pool, &mut matrix, coupled.as_mut());
        system.coupled = coupled;
        if had {
            system.matrix = Some(matrix);
        }
        found
    }

    /// Computes the bounds with this matrix.
    fn measure(
        system: &System,
        pool: &Pool,
        matrix: &mut Matrix,
        mut coupled: Option<&mut CoupledHinges>,
    ) -> Result<Self, ForceError> {
        if system.nodes.is_empty() {
            return Ok(Self::default());
        }
        let nodes = &system.nodes;
        let mut highest = |stiffness: f64, damping: f64| -> Result<(f64, f64), ForceError> {
            let scales = SystemScales {
                mass: 0.0,
                stiffness,
                damping,
                hessian: HessianApproximation::UpperBound,
                strains_are_current: false,
                allow_f32: false,
            };
            matrix.assemble(pool, system.state(StepTime::default()), coupled.as_deref_mut(), scales)?;
            if let Some(normals) = &system.normals {
                matrix.add_normals(pool, normals, &system.sets, nodes, scales);
            }
            let bound = matrix.gershgorin(&nodes.mass, &nodes.constraint);
            Ok((bound.min(MARGIN * power_iteration(matrix, pool, nodes)), bound))
        };
        let (stiffness, bound) = highest(1.0, 0.0)?;
        let damping = if system.is_damped() { highest(0.0, 1.0)?.0 } else { 0.0 };
        Ok(Self { stiffness: stiffness.sqrt(), bound: bound.sqrt(), damping })
    }

    /// Bounds of the same body with a spring on one of its nodes: the largest eigenvalue of a sum is at most the sum of the largest eigenvalues.
    pub fn with_spring(self, spring: SpringRates) -> Self {
        let add = |w: f64| (w * w + spring.stiffness).sqrt();
        Self { stiffness: add(self.stiffness), bound: add(self.bound), damping: self.damping + spring.damping }
    }

    /// The largest stable step of `scheme`, s.
    pub fn limit(&self, scheme: Scheme) -> StepLimit {
        if self.stiffness == 0.0 && self.damping == 0.0 {
            StepLimit::None
        } else {
            (scheme.properties().step_limit)(self)
        }
    }
}

/// Lower bound of the largest eigenvalue of `M^-1 A` on the free directions, by power iteration.
fn power_iteration(matrix: &Matrix, pool: &Pool, nodes: &Nodes) -> f64 {
    let (mass, filter) = (&nodes.mass, &nodes.constraint);
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut u: Vec<Vec3> = filter.iter().map(|c| c.filter(Vec3::new(random(), random(), random()))).collect();
    let mut a = vec![Vec3::zeros(); mass.len()];
    let mut highest = 0.0;
    for _ in 0..ITERATIONS {
        matrix.product(pool, &u, &mut a);
        let top: f64 = u.iter().zip(&a).map(|(u, a)| u.dot(a)).sum();
        let bottom: f64 = u.iter().zip(mass).map(|(u, m)| m * u.norm_squared()).sum();
        if !(bottom > 0.0 && top > 0.0) {
            return highest;
        }
        highest = top / bottom;
        let scale = 1.0 / bottom.sqrt();
        for i in 0..mass.len() {
            u[i] = filter[i].filter(scale * a[i] / mass[i]);
        }
    }
    highest
}
