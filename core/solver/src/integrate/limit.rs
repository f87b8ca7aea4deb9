//! Stability limits of the time step.

use super::scheme::Scheme;
use crate::algebra::Vec3;
use crate::coupled::CoupledHinges;
use crate::force_model::{ForceError, StepTime};
use crate::lanczos::Tridiagonal;
use crate::matrix::Matrix;
use crate::nodes::Nodes;
use crate::system::System;
use crate::system_scales::{HessianApproximation, SystemScales};
use crate::threads::Pool;

/// Upper bounds of a body's angular frequencies and decay rates, linearised about its present state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frequencies {
    /// Highest angular frequency, the square root of the largest eigenvalue of `M^-1 K`, rad/s: Lanczos iteration with a margin of 5 % of
    /// the eigenvalue, at most Gershgorin's bound.
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

/// Most products with a matrix.
const MOST: usize = 40;
/// A Ritz value counts if an eigenvalue is within this of it, relative to it.
const ACCURACY: f64 = 0.02;
/// Safety factor on the largest Ritz value, which is below the largest eigenvalue.
const MARGIN: f64 = 1.05;
/// Relative rounding error up to which damping counts as proportional to stiffness.
const PROPORTIONAL: f64 = 1e-9;

impl Frequencies {
    /// The bounds of the same body with stiffness and damping times `factor`.
    #[must_use]
    pub fn stiffened(self, factor: f64) -> Self {
        let root = factor.sqrt();
        Self { stiffness: root * self.stiffness, bound: root * self.bound, damping: factor * self.damping }
    }

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
        let mut assemble = |matrix: &mut Matrix, stiffness: f64, damping: f64| -> Result<f64, ForceError> {
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
            Ok(matrix.gershgorin(&nodes.mass, &nodes.constraint))
        };
        let start = random_directions(nodes);
        let bound = assemble(matrix, 1.0, 0.0)?;
        let stiffness = bound.min(MARGIN * largest_eigenvalue(matrix, pool, nodes, &start));
        let mut damping = 0.0;
        if system.is_damped() {
            let of_stiffness = image(matrix, pool, nodes, &start);
            let bound = assemble(matrix, 0.0, 1.0)?;
            damping = match proportion(&image(matrix, pool, nodes, &start), &of_stiffness) {
                Some(time) => time * stiffness,
                None => bound.min(MARGIN * largest_eigenvalue(matrix, pool, nodes, &start)),
            };
        }
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

/// Pseudorandom vectors in the free directions of the nodes, the same in every call.
fn random_directions(nodes: &Nodes) -> Vec<Vec3> {
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    nodes.constraint.iter().map(|c| c.filter(Vec3::new(random(), random(), random()))).collect()
}

/// `M^-1 A x` in the free directions.
fn image(matrix: &Matrix, pool: &Pool, nodes: &Nodes, x: &[Vec3]) -> Vec<Vec3> {
    let mut image = vec![Vec3::zeros(); x.len()];
    matrix.product(pool, x, &mut image);
    for ((image, constraint), mass) in image.iter_mut().zip(&nodes.constraint).zip(&nodes.mass) {
        *image = constraint.filter(*image / *mass);
    }
    image
}

/// The factor from `b` to `a`; `None` if they do not have the same direction.
fn proportion(a: &[Vec3], b: &[Vec3]) -> Option<f64> {
    let dot = |a: &[Vec3], b: &[Vec3]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
    let factor = dot(a, b) / dot(b, b);
    let rest: f64 = a.iter().zip(b).map(|(a, b)| (a - factor * b).norm_squared()).sum();
    (factor >= 0.0 && rest <= PROPORTIONAL.powi(2) * dot(a, a)).then_some(factor)
}

/// Lower bound of the largest eigenvalue of `M^-1 A` in the free directions; 0 if none is positive.
fn largest_eigenvalue(matrix: &Matrix, pool: &Pool, nodes: &Nodes, start: &[Vec3]) -> f64 {
    let weights: Vec<f64> = nodes.mass.iter().flat_map(|m| [*m; 3]).collect();
    let mut x = start.to_vec();
    let product = |from: &[f64], to: &mut [f64]| {
        for (x, from) in x.iter_mut().zip(from.chunks_exact(3)) {
            *x = Vec3::from_column_slice(from);
        }
        for (to, image) in to.chunks_exact_mut(3).zip(image(matrix, pool, nodes, &x)) {
            to.copy_from_slice(image.as_slice());
        }
    };
    let done = |projection: &Tridiagonal| {
        let settled = || projection.largest().is_some_and(|ritz| ritz.distance <= ACCURACY * ritz.value);
        projection.products() >= MOST || projection.products().is_multiple_of(4) && settled()
    };
    let start = start.iter().flat_map(|x| [x.x, x.y, x.z]).collect();
    Tridiagonal::project(&weights, start, product, done).largest().map_or(0.0, |ritz| ritz.value.max(0.0))
}
