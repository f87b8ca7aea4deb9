//! Time integration: one step of one body.

use super::pcg::{Pcg, Solve};
use super::pool::Pool;
use super::springs::NodeSprings;
use super::system::System;
use super::{Constraint, V3, axpy, dot};
use crate::host::HostError;
use thiserror::Error;

/// How positions and velocities are advanced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scheme {
    /// Positions with the old velocities, as Qi, Zhu and Fan (2019) print it: gains energy in every undamped mode.
    ExplicitEuler,
    /// Velocities first.
    SymplecticEuler,
    /// `(M + dt C + dt^2 K) dv = dt (f - dt K v)`, linearised once (Baraff and Witkin 1998).
    BackwardEuler,
}

impl Scheme {
    /// As scenes write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::ExplicitEuler => "explicit-euler",
            Self::SymplecticEuler => "symplectic-euler",
            Self::BackwardEuler => "backward-euler",
        }
    }

    /// Whether a step solves a system of equations.
    pub fn is_implicit(self) -> bool {
        self == Self::BackwardEuler
    }
}

/// What acts on a body during a step, besides itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct Loads<'a> {
    /// m/s^2
    pub gravity: V3,
    /// N (n x 3), or empty
    pub forces: &'a [V3],
    /// What the tools do.
    pub tools: &'a [NodeSprings],
}

/// How a step went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepReport {
    /// Iterations of all solves.
    pub iterations: usize,
    /// The largest final relative residual.
    pub residual: f64,
    /// Whether every solve met its tolerance.
    pub converged: bool,
    /// m/s, the fastest node at the end
    pub fastest: f64,
}

impl Default for StepReport {
    fn default() -> Self {
        Self { iterations: 0, residual: 0.0, converged: true, fastest: 0.0 }
    }
}

/// Why a step was not taken.
#[derive(Debug, Error)]
pub enum StepError {
    /// The material failed.
    #[error(transparent)]
    Host(#[from] HostError),
    /// A node's velocity is not finite. Positions are those before the step, and the body stands still.
    #[error("the velocity of node {node} is not finite")]
    Diverged {
        /// Which.
        node: usize,
    },
}

/// A scheme with its settings and the vectors it works in.
pub struct Integrator {
    /// How.
    pub scheme: Scheme,
    /// Relative, of each solve.
    pub tolerance: f64,
    /// Iterations of each solve, at most.
    pub most_iterations: usize,
    force: Vec<V3>,
    still: Vec<V3>,
    b: Vec<V3>,
    z: Vec<V3>,
    pcg: Pcg,
}

impl Integrator {
    /// With room for nothing yet.
    pub fn new(scheme: Scheme, tolerance: f64, most_iterations: usize) -> Self {
        let (force, still, b, z) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        Self { scheme, tolerance, most_iterations, force, still, b, z, pcg: Pcg::default() }
    }

    /// Room for `n` nodes. After a change of nodes or elements, also forgets the last solution.
    pub fn resize(&mut self, n: usize) {
        self.force.resize(n, [0.0; 3]);
        if self.scheme.is_implicit() {
            for field in [&mut self.still, &mut self.b, &mut self.z] {
                field.clear();
                field.resize(n, [0.0; 3]);
            }
            self.pcg.resize(n);
        }
    }

    /// Moves `system` from `time` by `substeps` steps that come to `dt` (s) together.
    ///
    /// # Errors
    /// A material that fails, or a state that is no longer finite.
    pub fn step(
        &mut self,
        pool: &Pool,
        system: &mut System,
        loads: &Loads<'_>,
        (time, dt): (f64, f64),
        substeps: usize,
    ) -> Result<StepReport, StepError> {
        let h = dt / substeps as f64;
        let mut report = StepReport::default();
        for sub in 0..substeps {
            let now = (time + sub as f64 * h, h);
            match self.scheme {
                Scheme::BackwardEuler => self.implicit(pool, system, loads, now, &mut report)?,
                _ => self.explicit(pool, system, loads, now)?,
            }
            report.fastest = self.finish(system, h).map_err(|error| self.blame(error, system))?;
            system.advance((now.0 + h, h))?;
        }
        Ok(report)
    }

    fn explicit(
        &mut self,
        pool: &Pool,
        system: &mut System,
        loads: &Loads<'_>,
        now: (f64, f64),
    ) -> Result<(), StepError> {
        system.forces(pool, &system.nodes.v, now, &mut self.force)?;
        add_loads(&mut self.force, loads, &system.nodes.x, Some(&system.nodes.v));
        let (nodes, dt) = (&mut system.nodes, now.1);
        if self.scheme == Scheme::ExplicitEuler {
            for (x, v) in nodes.x.iter_mut().zip(&nodes.v) {
                *x = axpy(*x, dt, *v);
            }
        }
        for i in 0..nodes.v.len() {
            let a = axpy(loads.gravity, 1.0 / nodes.mass[i], self.force[i]);
            nodes.v[i] = axpy(nodes.v[i], dt, a);
        }
        Ok(())
    }

    fn implicit(
        &mut self,
        pool: &Pool,
        system: &mut System,
        loads: &Loads<'_>,
        now: (f64, f64),
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let dt = now.1;
        let mut matrix = system.matrix.take().unwrap_or_default();
        let assembled = matrix.assemble(pool, &system.material, &system.sets, &system.nodes, (1.0, dt * dt, dt), now);
        let ready = assembled.and_then(|()| system.forces(pool, &self.still, now, &mut self.force));
        if let Err(error) = ready {
            system.matrix = Some(matrix);
            return Err(error.into());
        }
        let nodes = &mut system.nodes;
        for springs in loads.tools {
            matrix.add_diagonal(springs, (dt * dt, dt));
        }
        add_loads(&mut self.force, loads, &nodes.x, None);
        // A dv = dt (f - dt K v) written with one product: b = M v + dt f_elastic - A v.
        matrix.product(pool, &nodes.v, &mut self.b);
        for i in 0..nodes.v.len() {
            let pull = axpy(self.force[i], nodes.mass[i], loads.gravity);
            self.b[i] = axpy(axpy(pull.map(|f| dt * f), nodes.mass[i], nodes.v[i]), -1.0, self.b[i]);
            self.z[i] = match nodes.constraint[i] {
                Constraint::Free => [0.0; 3],
                _ => axpy(nodes.prescribed[i], -1.0, nodes.v[i]),
            };
        }
        let solve = Solve {
            matrix: &matrix,
            b: &self.b,
            z: &self.z,
            constraints: &nodes.constraint,
            tolerance: self.tolerance,
            most: self.most_iterations,
        };
        let solved = self.pcg.solve(pool, &solve);
        if !solved.residual.is_finite() {
            let odd = |i: &usize| !is_finite(self.b[*i]) || !matrix.diagonal(*i).iter().all(|k| k.is_finite());
            let node = (0..self.b.len()).find(odd).unwrap_or(0);
            let stiff = matrix.diagonal(node).iter().all(|k| k.is_finite());
            system.matrix = Some(matrix);
            return Err(match stiff {
                true => self.blame(StepError::Diverged { node }, system),
                false => system.material.not_finite("tangent", node).into(),
            });
        }
        for (v, dv) in nodes.v.iter_mut().zip(&self.pcg.x) {
            *v = axpy(*v, 1.0, *dv);
        }
        system.matrix = Some(matrix);
        report.iterations += solved.iterations;
        report.residual = report.residual.max(solved.residual);
        report.converged &= solved.converged;
        Ok(())
    }

    /// A state that is no longer finite is the material's doing where its force is not.
    fn blame(&self, error: StepError, system: &System) -> StepError {
        match error {
            StepError::Diverged { node } if !is_finite(self.force[node]) => {
                system.material.not_finite("forces", node).into()
            }
            other => other,
        }
    }

    /// Constraints, the check for numbers that are not finite, and positions where they come last.
    fn finish(&mut self, system: &mut System, dt: f64) -> Result<f64, StepError> {
        let nodes = &mut system.nodes;
        let mut fastest = 0.0_f64;
        for i in 0..nodes.v.len() {
            let v = nodes.constraint[i].merge(nodes.v[i], nodes.prescribed[i]);
            nodes.v[i] = v;
            let speed = dot(v, v);
            if !speed.is_finite() {
                nodes.v.fill([0.0; 3]);
                return Err(StepError::Diverged { node: i });
            }
            fastest = fastest.max(speed);
        }
        if self.scheme != Scheme::ExplicitEuler {
            for (x, v) in nodes.x.iter_mut().zip(&nodes.v) {
                *x = axpy(*x, dt, *v);
            }
        }
        Ok(fastest.sqrt())
    }
}

fn is_finite(v: V3) -> bool {
    v.iter().all(|c| c.is_finite())
}

/// Adds external forces and those of the tools to `force`.
fn add_loads(force: &mut [V3], loads: &Loads<'_>, x: &[V3], v: Option<&[V3]>) {
    for (f, load) in force.iter_mut().zip(loads.forces) {
        *f = axpy(*f, 1.0, *load);
    }
    for springs in loads.tools {
        springs.add_to(force, x, v);
    }
}
