//! Right-hand side of a step's linear system, and the prescribed part of its solution.

use crate::algebra::Vec3;
use crate::constraint::Constraint;
use crate::nodes::Nodes;
use bytemuck::{cast_slice, cast_slice_mut};
use pulp::NullaryFnOnce;

/// Number of nodes processed together.
const LANES: usize = 8;
type Numbers = [f64; 3 * LANES];

/// Computes `b = effective_dt f + M (V - v)` and z for a range of nodes. On entry `z` holds contact forces that are not in `f`, N; on return it holds the
/// prescribed change of each node's velocity, m/s. Returns `|S b|^2` of the range, N^2 s^2.
pub struct RightSide<'a, P> {
    pub nodes: &'a Nodes,
    /// Force on each node, N (n x 3).
    pub force: &'a [Vec3],
    /// Acceleration of gravity, m/s^2.
    pub gravity: Vec3,
    /// Effective step size g, s.
    pub effective_dt: f64,
    pub start: Start<'a>,
    /// Prescribed velocity of a node, m/s.
    pub prescribed: P,
    /// Index of the first node of the range.
    pub first: usize,
    /// Right-hand side of the range, N s.
    pub b: &'a mut [Vec3],
    /// Contact forces, then prescribed velocity changes of the range.
    pub z: &'a mut [Vec3],
}

/// The state forces were evaluated at.
#[derive(Clone, Copy)]
pub enum Start<'a> {
    /// The state before the step: `M (V - v)` is `M v - A v`.
    Current {
        /// `A v`, N s (n x 3).
        momentum: &'a [Vec3],
    },
    /// A predicted state, with `V = v_0 + history (v_0 - v_before)`.
    Predicted {
        /// Velocities at the beginning of the step, v_0, m/s (n x 3).
        velocity: &'a [Vec3],
        /// Velocities one step earlier, m/s (n x 3).
        before: &'a [Vec3],
        history: f64,
    },
}

impl<P: Fn(usize) -> Vec3> NullaryFnOnce for RightSide<'_, P> {
    type Output = f64;

    #[inline(always)]
    fn call(self) -> f64 {
        let Self { nodes, force, gravity, effective_dt, start, prescribed, first, b, z } = self;
        let all = first..first + b.len();
        let (force, mass, v) = (&force[all.clone()], &nodes.mass[all.clone()], &nodes.v[all.clone()]);
        match start {
            Start::Current { momentum } => {
                let momentum = &momentum[all.clone()];
                Current { force, momentum, mass, v, effective_dt, gravity }.write(b, z);
            }
            Start::Predicted { velocity, before, history } => {
                for (at, i) in all.clone().enumerate() {
                    let target = match history > 0.0 {
                        true => velocity[i] + history * (velocity[i] - before[i]),
                        false => velocity[i],
                    };
                    let pull = force[at] + z[at] + mass[at] * gravity;
                    let change = target - v[at];
                    b[at] = effective_dt * pull + mass[at] * change;
                }
            }
        }
        let mut squares = [0.0; 3 * LANES];
        let constraints = &nodes.constraint[all];
        for (at, constraints) in (0..).step_by(LANES).zip(constraints.chunks(LANES)) {
            let (b, z) = (&b[at..at + constraints.len()], &mut z[at..at + constraints.len()]);
            if let (Some(b), true) = (b.first_chunk::<LANES>(), constraints.iter().all(Constraint::is_free)) {
                z.fill(Vec3::zeros());
                for (square, b) in squares.iter_mut().zip(cast_slice::<Vec3, f64>(b)) {
                    *square += b * b;
                }
                continue;
            }
            for (lane, constraint) in constraints.iter().enumerate() {
                z[lane] = match constraint {
                    Constraint::Free => Vec3::zeros(),
                    Constraint::Fixed | Constraint::Plane(_) | Constraint::Line(_) => {
                        prescribed(first + at + lane) - v[at + lane]
                    }
                };
                let free_part = constraint.filter(b[lane]);
                squares[lane] += free_part.norm_squared();
            }
        }
        squares.iter().sum()
    }
}

/// Inputs for a range of nodes whose forces were evaluated at the state before the step.
struct Current<'a> {
    force: &'a [Vec3],
    momentum: &'a [Vec3],
    mass: &'a [f64],
    v: &'a [Vec3],
    effective_dt: f64,
    gravity: Vec3,
}

impl Current<'_> {
    /// Computes `b = effective_dt (f + z + M gravity) + M v - A v` component by component; masses are repeated for the three components of a node, so that
    /// the loop runs over plain arrays of numbers.
    #[inline(always)]
    fn write(self, b: &mut [Vec3], z: &[Vec3]) {
        let Self { force, momentum, mass, v, effective_dt, gravity } = self;
        let mut gravities: Numbers = [0.0; 3 * LANES];
        for (at, to) in gravities.iter_mut().enumerate() {
            *to = gravity[at % 3];
        }
        for (at, b) in (0..).step_by(LANES).zip(b.chunks_mut(LANES)) {
            let nodes = at..at + b.len();
            let mut masses: Numbers = [0.0; 3 * LANES];
            for (masses, mass) in masses.as_chunks_mut::<3>().0.iter_mut().zip(&mass[nodes.clone()]) {
                masses.fill(*mass);
            }
            let [z, force, v, momentum] = [z, force, v, momentum].map(|of| cast_slice::<Vec3, f64>(&of[nodes.clone()]));
            let given = z.iter().zip(force).zip(v).zip(momentum).zip(masses.iter().zip(&gravities));
            for (b, ((((z, force), v), momentum), (mass, gravity))) in
                cast_slice_mut::<Vec3, f64>(b).iter_mut().zip(given)
            {
                *b = effective_dt * (force + z + mass * gravity) + mass * v - momentum;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_plugin_api::lanes::vector_unit;

    fn wave(n: usize, seed: usize) -> Vec<Vec3> {
        (0..n).map(|i| Vec3::from_fn(|c, _| (1.7 * (seed + 3 * i + c) as f64).sin())).collect()
    }

    #[test]
    fn right_side_matches_its_definition() {
        let n = 29;
        let mut constraint = vec![Constraint::Free; n];
        (constraint[1], constraint[10], constraint[28]) =
            (Constraint::Fixed, Constraint::Plane(Vec3::new(0.0, 0.6, 0.8)), Constraint::Line(Vec3::x()));
        let mass = (0..n).map(|i| 0.1 + i as f64).collect();
        let nodes = Nodes { v: wave(n, 9), mass, constraint, ..Nodes::default() };
        let (force, contact_force, initial) = (wave(n, 1), wave(n, 2), [wave(n, 3), wave(n, 4)]);
        let (gravity, effective_dt) = (Vec3::new(0.1, -9.81, 0.3), 0.25);
        for (start, history) in [(Start::Current { momentum: &initial[0] }, 0.0)].into_iter().chain(
            [0.0, 0.5]
                .map(|history| (Start::Predicted { velocity: &initial[0], before: &initial[1], history }, history)),
        ) {
            let (mut b, mut z) = (vec![Vec3::repeat(7.0); n], contact_force.clone());
            let (mut squares, mut expected) = (0.0, 0.0);
            for (first, (b, z)) in (0..).step_by(16).zip(b.chunks_mut(16).zip(z.chunks_mut(16))) {
                let (nodes, force, prescribed) = (&nodes, &force[..], |i: usize| Vec3::new(i as f64, 2.0, 3.0));
                squares += vector_unit().dispatch(RightSide {
                    nodes,
                    force,
                    gravity,
                    effective_dt,
                    start,
                    prescribed,
                    first,
                    b,
                    z,
                });
            }
            for i in 0..n {
                let (m, v) = (nodes.mass[i], nodes.v[i]);
                for c in 0..3 {
                    let pull = effective_dt * (force[i][c] + contact_force[i][c] + m * gravity[c]);
                    let target = initial[0][i][c] + history * (initial[0][i][c] - initial[1][i][c]);
                    let right = pull
                        + if matches!(start, Start::Current { .. }) {
                            m * v[c] - initial[0][i][c]
                        } else {
                            m * (target - v[c])
                        };
                    assert!((b[i][c] - right).abs() < 1e-12 * (1.0 + right.abs()), "{i}: {:?} {right}", b[i]);
                }
                let free = nodes.constraint[i].is_free();
                assert_eq!(z[i], if free { Vec3::zeros() } else { Vec3::new(i as f64, 2.0, 3.0) - v });
                let free_part = nodes.constraint[i].filter(b[i]);
                expected += free_part.norm_squared();
            }
            assert!((squares - expected).abs() < 1e-12 * expected, "{squares} {expected}");
        }
    }
}
