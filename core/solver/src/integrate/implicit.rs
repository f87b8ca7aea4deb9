//! Steps of the implicit schemes but equilibria: Newton's method, contacts looked at again while it goes.

use super::holds::{Doubt, Holds, Outcome, PASSES};
use super::right_side::{RightSide, Start};
use super::{Integrator, Loads, Scheme, StepError, StepReport, add_loads, check, is_finite};
use crate::algebra::{Vec3, without_dust};
use crate::factors::{Factors, StandIn};
use crate::force_model::{ForceError, StepTime};
use crate::matrix::Matrix;
use crate::nodes::Nodes;
use crate::solver::peek::doubt;
use crate::solver::solve::Solve;
use crate::system::System;
use crate::threads::{NODES, Pool};
use pliant_plugin_api::TangentScale;
use std::time::Instant;

/// Tolerance of a solve from which on moments of hinges are found to six digits.
const SIX_DIGITS: f64 = 1e-5;
/// Times a solve of a step is stopped, at most, for it will not be the last.
const STOPS: usize = 8;

/// `M (v - V) = g f(X + g v)`, where `X = x + carry (x - x_before)` and V likewise.
struct Form {
    g: f64,
    carry: f64,
}

impl Form {
    /// X of a node that is at `x` and was at `before` a step ago.
    fn carried(&self, x: Vec3, before: Vec3) -> Vec3 {
        if self.carry > 0.0 { x + self.carry * (x - before) } else { x }
    }
}

impl Integrator {
    pub(super) fn implicit(
        &mut self,
        pool: &Pool,
        system: &mut System,
        (loads, holds): (&Loads<'_>, &mut dyn Holds),
        now: StepTime,
        report: &mut StepReport,
    ) -> Result<(), StepError> {
        let dt = now.dt;
        let (nodes, [x, v]) = (&system.nodes, &mut self.from);
        pool.pieces((&mut x[..], &mut v[..]), NODES, &|first, (x, v)| {
            x.copy_from_slice(&nodes.x[first..first + x.len()]);
            v.copy_from_slice(&nodes.v[first..first + v.len()]);
        });
        holds.begin(system, dt);
        let two = self.scheme == Scheme::Bdf2 && self.has_past && !holds.is_holding();
        let form = match self.scheme {
            Scheme::Bdf2 if two => Form { g: 2.0 / 3.0 * dt, carry: 1.0 / 3.0 },
            Scheme::ImplicitMidpoint => Form { g: 0.5 * dt, carry: 0.0 },
            _ => Form { g: dt, carry: 0.0 },
        };
        let mut first = 0.0;
        for iteration in 0..self.newton.max(1) {
            let size = self.newton_step(pool, system, (loads, holds), (now, &form), iteration, report)?;
            if iteration == 0 {
                first = size;
            }
            report.newton += 1;
            if size <= self.newton_tolerance * first {
                break;
            }
        }
        std::mem::swap(&mut self.from, &mut self.before);
        self.has_past = true;
        let (Nodes { x: to, v: speed, constraint, prescribed, .. }, [x, v], past) =
            (&mut system.nodes, &self.before, &self.from[0]);
        pool.pieces((&mut to[..], &mut speed[..]), NODES, &|first, (to, speed)| {
            for (i, (to, speed)) in (first..).zip(to.iter_mut().zip(speed)) {
                if self.scheme == Scheme::ImplicitMidpoint {
                    *to = x[i] + dt * *speed;
                    let after = 2.0 * *speed - v[i];
                    *speed = constraint[i].merge(after, prescribed[i]);
                } else {
                    *to = form.carried(x[i], past[i]) + form.g * *speed;
                }
            }
        });
        report.fastest = check(system).inspect_err(|_| system.nodes.x.copy_from_slice(&self.before[0]))?;
        holds.end(system, &mut self.reaction);
        Ok(())
    }

    /// One Newton step, contacts included. Gives the size of what it set out to remove.
    fn newton_step(
        &mut self,
        pool: &Pool,
        system: &mut System,
        (loads, holds): (&Loads<'_>, &mut dyn Holds),
        (now, form): (StepTime, &Form),
        iteration: usize,
        report: &mut StepReport,
    ) -> Result<f64, StepError> {
        let (g, dt) = (form.g, now.dt);
        // The first step of backward Euler is linearised where the body is, all others where it is expected to be.
        let here = iteration == 0 && form.carry == 0.0 && g == dt;
        if !here {
            self.expect(&mut system.nodes, form);
        }
        // Backward Euler bears a matrix of half the stiffness; one step of the others would grow with a softer one than exact.
        let stand_in = if form.carry > 0.0 || g < dt { StandIn::Certain } else { StandIn::Half };
        let rounded = here && self.newton == 1 && self.pcg.bears_rounding(self.tolerance);
        let factors = Factors { mass: 1.0, stiffness: g * g, damping: g, stand_in, after_forces: true, rounded };
        let start = Instant::now();
        let still = if here { Some(&self.still[..]) } else { None };
        let force = (&mut self.force[..], rounded && self.tolerance >= SIX_DIGITS);
        let mut matrix = linearise(pool, system, (still, force), factors, now)?;
        report.seconds[0] += start.elapsed().as_secs_f64();
        add_tools(&mut matrix, loads, g);
        let v = (!here).then_some(&system.nodes.v[..]);
        add_loads(&mut self.force, loads, &system.nodes.x, v);
        self.pcg.prepare(&matrix, &system.sets, &system.nodes.rest);
        // Where the body is: b = M v + g f_elastic - A v.
        let moving = here.then_some((&system.nodes.v[..], &mut self.moving[..]));
        self.pcg.guess(pool, &matrix, moving);
        let mut size = 0.0_f64;
        let (mut pass, mut stops, mut again) = (0, 0, false);
        while pass < PASSES {
            let squares = self.right_side(pool, &system.nodes, (loads, &*holds), (form, now.dt), here);
            if !again {
                size = squares.sqrt();
            }
            let nodes = &system.nodes;
            let solve = Solve {
                matrix: &matrix,
                b: &self.b,
                z: &self.z,
                constraints: &nodes.constraint,
                motion: (&nodes.x, g),
                again,
                tolerance: self.tolerance,
                most: self.most_iterations,
            };
            let start = Instant::now();
            let (near, known) = (holds.is_near(), &*holds);
            let solved = self.pcg.solve_watched(pool, &solve, &mut |peek| {
                let outcome = Outcome {
                    after: &|s, i| s.nodes.v[i] + peek.at(i),
                    reaction: &|i| peek.reaction(i) / g,
                    doubt: Some(&doubt(&matrix, peek.left(), g)),
                };
                near && stops < STOPS && known.foresees(system, &outcome)
            });
            report.seconds[1] += start.elapsed().as_secs_f64();
            if solved.too_rough {
                let start = Instant::now();
                matrix = assemble(pool, system, matrix, Factors { rounded: false, ..factors }, now)?;
                report.seconds[0] += start.elapsed().as_secs_f64();
                add_tools(&mut matrix, loads, g);
                let moving = here.then_some((&system.nodes.v[..], &mut self.moving[..]));
                self.pcg.load(pool, &matrix, moving);
                again = false;
                continue;
            }
            again = true;
            if !solved.residual.is_finite() {
                let error = self.diverged(system, &matrix);
                system.matrix = Some(matrix);
                system.nodes.x.copy_from_slice(&self.from[0]);
                return Err(error);
            }
            report.iterations += solved.iterations;
            if solved.stopped.is_some() {
                stops += 1;
            } else {
                pass += 1;
                report.residual = report.residual.max(solved.residual);
                report.converged &= solved.converged;
            }
            self.reaction.fill(Vec3::zeros());
            if !near && self.pcg.held().next().is_none() {
                break;
            }
            let (b, change) = (&self.b, &self.pcg.x);
            for (i, product) in self.pcg.held() {
                self.reaction[i] = (product - b[i]) / g;
            }
            let (reaction, doubt) = (&self.reaction, doubt(&matrix, solved.stopped.unwrap_or(0.0), g));
            let outcome = Outcome {
                after: &|s, i| s.nodes.v[i] + change[i],
                reaction: &|i| reaction[i],
                doubt: solved.stopped.map(|_| &doubt as &Doubt<'_>),
            };
            if !holds.revise(system, &outcome) && solved.stopped.is_none() {
                break;
            }
        }
        pool.pieces(
            (&mut system.nodes.v[..], &mut self.pcg.x[..]),
            NODES,
            &|_, (v, dv): (&mut [Vec3], &mut [Vec3])| {
                for (v, dv) in v.iter_mut().zip(dv) {
                    *dv = without_dust(*dv);
                    *v = without_dust(*v + *dv);
                }
            },
        );
        if iteration > 0 || self.newton > 1 {
            // What is left to do next time has nothing to do with what was done.
            self.pcg.forget();
        }
        system.matrix = Some(matrix);
        Ok(size)
    }

    /// Puts nodes where they are expected to be at the time the scheme looks at.
    fn expect(&self, nodes: &mut Nodes, form: &Form) {
        for (i, (to, v)) in nodes.x.iter_mut().zip(&nodes.v).enumerate() {
            *to = form.carried(self.from[0][i], self.before[0][i]) + form.g * *v;
        }
    }

    /// The right side, and what is prescribed of held nodes, for what holds them now. Gives the sum of squares of the free part.
    fn right_side(
        &mut self,
        pool: &Pool,
        nodes: &Nodes,
        (loads, holds): (&Loads<'_>, &dyn Holds),
        (form, dt): (&Form, f64),
        here: bool,
    ) -> f64 {
        let (mut b, mut z) = (std::mem::take(&mut self.b), std::mem::take(&mut self.z));
        z.fill(Vec3::zeros());
        holds.add_forces(&mut z);
        let start = match here {
            true => Start::Here(&self.moving),
            false => Start::There([&self.from[1], &self.before[1]], form.carry),
        };
        let (force, gravity, g) = (&self.force[..], loads.gravity, form.g);
        let squares = pool.fold((&mut b[..], &mut z[..]), &|first, (b, z)| {
            let prescribed = |i: usize| self.prescribed(i, nodes.prescribed[i], form, dt);
            pulp::Arch::new().dispatch(RightSide { nodes, force, gravity, g, start, prescribed, first, b, z })
        });
        (self.b, self.z) = (b, z);
        squares
    }

    /// Whose doing it is that a system has no finite solution: the material's where its stiffness is not finite.
    fn diverged(&self, system: &System, matrix: &Matrix) -> StepError {
        let is_stiff = |i: usize| matrix.diagonal(i).iter().all(|k| k.is_finite());
        let node = (0..self.b.len()).find(|i| !is_finite(self.b[*i]) || !is_stiff(*i)).unwrap_or(0);
        if is_stiff(node) { StepError::Diverged { node } } else { system.material.not_finite("tangent", node).into() }
    }

    /// The velocity of a held node that takes it where it has to be at the end of the step.
    fn prescribed(&self, i: usize, p: Vec3, form: &Form, dt: f64) -> Vec3 {
        if form.carry == 0.0 {
            return p;
        }
        let x = self.from[0][i];
        (x + dt * p - form.carried(x, self.before[0][i])) / form.g
    }
}

/// Adds what tools do to nodes, linearly, to the matrix of a step that moves positions by `g` (s) times velocities.
fn add_tools(matrix: &mut Matrix, loads: &Loads<'_>, g: f64) {
    for springs in loads.tools {
        matrix.add_diagonal(springs, TangentScale { stiffness: g * g, damping: g });
    }
}

/// The matrix and the forces of `system` as it stands, with velocities `v` in the forces, which may be those of
/// [`System::forces_rounded`]. The matrix is lent: it has to be put back.
///
/// # Errors
/// What the material says; then nothing is lent.
pub fn linearise(
    pool: &Pool,
    system: &mut System,
    (v, force): (Option<&[Vec3]>, (&mut [Vec3], bool)),
    factors: Factors,
    now: StepTime,
) -> Result<Matrix, ForceError> {
    system.forces_rounded(pool, v, now, force)?;
    let matrix = system.matrix.take().unwrap_or_default();
    assemble(pool, system, matrix, factors, now)
}

/// A matrix of `system` takes on the values of its state; it is put back if that fails.
fn assemble(
    pool: &Pool,
    system: &mut System,
    mut matrix: Matrix,
    factors: Factors,
    now: StepTime,
) -> Result<Matrix, ForceError> {
    let state = (&system.nodes, system.coupled.as_mut());
    let assembled = matrix.assemble(pool, &*system.material, &system.sets, state, factors, now);
    if let (Some(normals), Ok(())) = (&system.normals, &assembled) {
        matrix.add_normals(pool, normals, (&system.sets, &system.nodes), factors);
    }
    match assembled {
        Ok(()) => Ok(matrix),
        Err(error) => {
            system.matrix = Some(matrix);
            Err(error)
        }
    }
}
