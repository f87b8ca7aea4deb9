//! How large a step may be, before it is taken.

use super::Scheme;
use crate::algebra::Vec3;
use crate::coupled::Coupled;
use crate::factors::{Factors, StandIn};
use crate::force_model::{ForceError, StepTime};
use crate::matrix::Matrix;
use crate::nodes::Nodes;
use crate::system::System;
use crate::threads::Pool;

/// Bounds on a body's fastest motions, about the state it is in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Frequencies {
    /// rad/s, the highest of `M^-1 K`: power iteration with a margin of 5 %, never above Gershgorin's bound
    pub stiffness: f64,
    /// rad/s, Gershgorin's bound of the same: certain, and some 16 to 33 % higher
    pub bound: f64,
    /// 1/s, the highest rate of `M^-1 C`
    pub damping: f64,
}

/// What a scheme makes of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepLimit {
    /// Stable up to this step, s; zero means never.
    At(f64),
    /// Stable at any step for convex energies.
    None,
}

/// Power iterations.
const ITERATIONS: usize = 40;
/// On their result, which comes from below.
const MARGIN: f64 = 1.05;

impl Frequencies {
    /// Of the body as it stands. Builds its matrix if it has none, and drops it again.
    ///
    /// # Errors
    /// What the material says.
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

    fn measure(
        system: &System,
        pool: &Pool,
        matrix: &mut Matrix,
        mut coupled: Option<&mut Coupled>,
    ) -> Result<Self, ForceError> {
        if system.nodes.is_empty() {
            return Ok(Self::default());
        }
        let nodes = &system.nodes;
        let mut highest = |factors: (f64, f64)| -> Result<(f64, f64), ForceError> {
            let (k, c) = factors;
            let factors = Factors {
                mass: 0.0,
                stiffness: k,
                damping: c,
                stand_in: StandIn::Certain,
                after_forces: false,
                rounded: false,
            };
            let state = (nodes, coupled.as_deref_mut());
            matrix.assemble(pool, &*system.material, &system.sets, state, factors, StepTime::default())?;
            if let Some(normals) = &system.normals {
                matrix.add_normals(pool, normals, (&system.sets, nodes), factors);
            }
            let bound = matrix.gershgorin(&nodes.mass, &nodes.constraint);
            Ok((bound.min(MARGIN * power(matrix, pool, nodes)), bound))
        };
        let (stiffness, bound) = highest((1.0, 0.0))?;
        let damping = if system.is_damped() { highest((0.0, 1.0))?.0 } else { 0.0 };
        Ok(Self { stiffness: stiffness.sqrt(), bound: bound.sqrt(), damping })
    }

    /// With `stiffness` over mass (1/s^2) and `damping` over mass (1/s) added to a node.
    pub fn with_spring(self, (stiffness, damping): (f64, f64)) -> Self {
        let more = |w: f64| (w * w + stiffness).sqrt();
        Self { stiffness: more(self.stiffness), bound: more(self.bound), damping: self.damping + damping }
    }

    /// The largest stable step of `scheme`, s.
    pub fn limit(&self, scheme: Scheme) -> StepLimit {
        let (w, d) = (self.stiffness, self.damping);
        if w == 0.0 && d == 0.0 {
            return StepLimit::None;
        }
        match scheme {
            // Every mode needs w^2 dt < d_mode; with damping proportional to stiffness that is dt < d/w^2 below critical,
            // and dt < 2/d for the fastest overdamped mode.
            Scheme::ExplicitEuler if d == 0.0 => StepLimit::At(0.0),
            Scheme::ExplicitEuler if d >= 2.0 * w => {
                StepLimit::At(2.0 / (0.5 * d + (0.25 * d * d - w * w).max(0.0).sqrt()))
            }
            Scheme::ExplicitEuler => StepLimit::At(d / (w * w)),
            // (w dt)^2 + 2 d dt < 4
            Scheme::SymplecticEuler if w == 0.0 => StepLimit::At(2.0 / d),
            Scheme::SymplecticEuler => StepLimit::At(((d * d + 4.0 * w * w).sqrt() - d) / (w * w)),
            _ => StepLimit::None,
        }
    }
}

/// The largest eigenvalue of `M^-1 A`, from below.
fn power(matrix: &Matrix, pool: &Pool, nodes: &Nodes) -> f64 {
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
