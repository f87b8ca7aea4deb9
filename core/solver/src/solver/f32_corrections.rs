//! Conjugate gradients in single precision, the inner solver of iterative refinement.
//!
//! An iteration is bound by memory bandwidth, and single precision halves what it reads. The unknown is a correction, so its last digits
//! are not those of the solution: [`crate::solver`] computes the residual in double precision and asks for another correction until it is
//! small enough (iterative refinement: Wilkinson 1963). Matrix and residual are scaled by powers of two, so no unit is too small.

use super::block_jacobi::BlockInverses;
use super::constrained_nodes::ConstrainedNode;
use super::filtered_system::FilteredSystem;
use super::partial_solution::PartialSolution;
use super::residual::ScaledBySixteen;
use crate::algebra::{MAX_BLOCK_CONDITION, Vec3};
use crate::constraint::{Constraint, constrained_inverse};
use crate::elements::ElementSet;
use crate::f32_matrix::{F32Matrix, power_of_two};
use crate::lanes::aligned::{Lines, Sixteens};
use crate::lanes::symmetric::put_inverse;
use crate::lanes::{LANES, widest};
use crate::matrix::Matrix;
use crate::multilevel::Multilevel;
use crate::multilevel::refresh::Refresh;
use crate::threads::Pool;
use std::sync::atomic::{AtomicU64, Ordering};

/// Matrix, preconditioner and vectors of the corrections.
#[derive(Debug, Default)]
pub struct F32Corrections {
    matrix: F32Matrix,
    /// Inverses of the diagonal blocks, six numbers each, by sixteen nodes.
    inverse: Lines<f32>,
    levels: Option<Multilevel>,
    refresh: Refresh,
    constrained: Vec<ConstrainedNode>,
    /// Constraints of nodes that were constrained in the last solve.
    was: Vec<(usize, Constraint)>,
    /// Share of block Jacobi over the scale of the matrix.
    share: f64,
    /// `sum_i x_i . A_ii x_i` of positions at the last update.
    size: f64,
    /// Condition of the worst diagonal block; 0 before the first matrix.
    width: f64,
    /// Residual, by sixteen nodes.
    r: Lines<f32>,
    /// `P r`, by sixteen nodes.
    h: Lines<f32>,
    /// Scale of the residual in `r`, a power of two.
    scale: f64,
}

/// Least share of `r . P r` that one correction can leave: single precision has no more digits.
const MAX_REDUCTION: f64 = 1e-10;
/// Sixteens of nodes in a chunk of a vector for a thread.
const CHUNK: usize = 128;

/// Condition of a diagonal block over the solve's tolerance up to which the matrix may be in single precision: the stiffness between
/// neighbours is then off by some 1e-3 of the tolerance.
const MAX_CONDITION_PER_TOLERANCE: f64 = 1e10;
/// The same at any tolerance: the least eigenvalue of a block is 1 % off.
const MAX_CONDITION: f64 = 1e5;

/// Share of `r . P r` at the last stop test that is left when the next one is made.
const STOP_TEST_INTERVAL: f64 = 0.1;
/// Times the target below which there is no stop test: so little is left that finishing takes less time than beginning again.
const STOP_TEST_END: f64 = 20.0;

/// Returns true if a solve is to stop with the partial solution.
pub type StopTest<'a> = dyn FnMut(&PartialSolution<'_>) -> bool + 'a;

/// Where a correction begins and ends.
#[derive(Clone, Copy, Debug)]
pub struct CorrectionGoal {
    /// `r . P r` of the residual that was loaded.
    pub d: f64,
    /// The correction ends at this value.
    pub target: f64,
    /// Largest number of iterations of a solve.
    pub max_iterations: usize,
}

/// Report of a correction.
#[derive(Clone, Copy, Debug, Default)]
pub struct CorrectionReport {
    /// Products with the matrix.
    pub iterations: usize,
    /// Whether a direction of no or negative curvature was met, or a number that is not finite.
    pub broken: bool,
    /// Whether the stop test ended it.
    pub stopped: bool,
}

impl F32Corrections {
    /// Makes room for `n` nodes and forgets matrix and levels.
    pub fn resize(&mut self, n: usize) {
        let room = n.next_multiple_of(LANES);
        (self.r, self.h) = (Lines::new(3 * room), Lines::new(3 * room));
        self.inverse = Lines::new(6 * room);
        self.constrained.clear();
        self.constrained.reserve(n);
        self.was.clear();
        self.was.reserve(n);
        self.levels = None;
        self.refresh.end();
        self.matrix.forget();
        self.width = 0.0;
    }

    /// Builds the levels, if there are none since nodes or elements changed.
    pub fn prepare(&mut self, matrix: &Matrix, sets: &[ElementSet], rest: &[Vec3]) {
        self.levels.get_or_insert_with(|| Multilevel::new(matrix, sets, rest));
    }

    /// Memory, bytes.
    pub fn bytes(&self) -> usize {
        let vectors = 2 * self.r.bytes() + self.inverse.bytes();
        vectors + self.matrix.bytes() + self.levels.as_ref().map_or(0, Multilevel::bytes)
    }

    /// Loads the values of a matrix.
    pub fn load(&mut self, pool: &Pool, matrix: &Matrix) {
        self.matrix.update(pool, matrix);
    }

    /// Constrained nodes as of the last update, rising.
    pub fn constrained(&self) -> &[ConstrainedNode] {
        &self.constrained
    }

    /// `out[k] = A x[k]` in double precision.
    pub fn products<const K: usize>(&mut self, pool: &Pool, matrix: &Matrix, x: [&[Vec3]; K], out: [&mut [Vec3]; K]) {
        self.matrix.exact_products(pool, matrix, x, out);
    }

    /// Prepares the preconditioner for solves with the loaded matrix. Returns `sum_i x_i . A_ii x_i` of the positions x, and whether single
    /// precision can hold the preconditioner.
    pub fn update(&mut self, pool: &Pool, system: &FilteredSystem<'_>) -> (f64, bool) {
        let constraints = system.constraints;
        ConstrainedNode::list(constraints, &mut self.constrained);
        if system.same_matrix {
            // Levels built for the previous constraints serve as well.
            let before = |i: usize| match self.was.binary_search_by_key(&i, |(node, _)| *node) {
                Ok(at) => self.was[at].1,
                Err(_) => Constraint::Free,
            };
            let nodes =
                self.was.iter().map(|(node, _)| *node).chain(self.constrained.iter().map(ConstrainedNode::index));
            for i in nodes.filter(|i| constraints[*i] != before(*i)) {
                let inverse = constrained_inverse(system.matrix.diagonal(i), &constraints[i]);
                put_inverse(self.inverse.flat_mut(), i, &inverse.map(|c| self.share * c));
            }
        }
        self.was.clear();
        self.was.extend(self.constrained.iter().map(|node| (node.index(), constraints[node.index()])));
        if system.same_matrix {
            return (self.size, self.width <= MAX_BLOCK_CONDITION);
        }
        self.share = 1.0 / self.matrix.scale();
        if let Some(levels) = &mut self.levels {
            let due = self.refresh.due(self.matrix.scale());
            self.matrix.without_fixed(pool, system.matrix, constraints, levels.sources(due));
            levels.update(pool, self.matrix.values(), due);
            self.share *= levels.share();
        }
        // Widths are not negative, so they are in the order of their bits.
        let (share, width) = (self.share, AtomicU64::new(0));
        let all = Sixteens(self.inverse.flat_mut().as_chunks_mut().0.as_chunks_mut().0);
        self.size = pool.fold(all, &|first, Sixteens(out)| {
            let (size, widest) = pulp::Arch::new().dispatch(BlockInverses { system, share, first, out });
            width.fetch_max(widest.to_bits(), Ordering::Relaxed);
            size
        });
        self.width = f64::from_bits(width.into_inner());
        (self.size, self.width <= MAX_BLOCK_CONDITION)
    }

    /// Whether rounding the blocks of a matrix like the last one changes less than a solve to `tolerance` leaves. Before the first matrix it
    /// is assumed to.
    pub fn allows_f32(&self, tolerance: f64) -> bool {
        let scale = self.matrix.scale();
        self.width <= (tolerance * MAX_CONDITION_PER_TOLERANCE).min(MAX_CONDITION)
            && (scale == 0.0 || (1e-20..1e20).contains(&scale))
    }

    /// Declares the levels out of date: the next matrix is unrelated to the last one.
    pub fn forget(&mut self) {
        self.refresh.end();
    }

    /// Records the iterations of the first solve with a matrix.
    pub fn record_iterations(&mut self, iterations: usize) {
        self.refresh.record_iterations(iterations);
    }

    /// Loads a filtered residual with its squared norm. Returns `r . P r`.
    pub fn apply_preconditioner(&mut self, pool: &Pool, r: &[Vec3], squares: f64) -> f64 {
        let size = squares.sqrt();
        self.scale = if size.is_normal() { power_of_two(size) } else { 1.0 };
        let down = 1.0 / self.scale;
        pool.par_chunks(self.r.vectors_mut(), CHUNK, &|first, to| {
            widest(ScaledBySixteen { scale: down, r: &r[LANES * first..], to })
        });
        self.unit() * self.precondition(pool)
    }

    /// The unit in which `r . P r` is counted here.
    fn unit(&self) -> f64 {
        self.scale * self.scale * self.matrix.scale()
    }

    /// Adds to `x` a correction for the residual that was loaded last, until the goal is reached or `stop` ends it.
    pub fn correct(
        &mut self,
        pool: &Pool,
        system: &FilteredSystem<'_>,
        x: &mut [Vec3],
        goal: CorrectionGoal,
        stop: &mut StopTest<'_>,
    ) -> CorrectionReport {
        let (mut d, mut next_test) = (goal.d / self.unit(), f64::INFINITY);
        let target = (goal.target / self.unit()).max(MAX_REDUCTION * d);
        self.matrix.start();
        self.matrix.update_direction(pool, self.h.vectors(), 0.0, 0.0);
        let mut done = CorrectionReport::default();
        while d > target && done.iterations < goal.max_iterations {
            if d < next_test && d > STOP_TEST_END * target {
                done.stopped = stop(&PartialSolution::new(system, x, &self.matrix, self.step(), d * self.unit()));
                next_test = STOP_TEST_INTERVAL * d;
                if done.stopped {
                    break;
                }
            }
            let q = self.matrix.product(pool);
            if !(q > 0.0 && q.is_finite()) {
                done.broken = true;
                break;
            }
            let a = (d / q) as f32;
            let next = self.descend(pool, a);
            self.matrix.update_direction(pool, self.h.vectors(), a, (next / d) as f32);
            d = next;
            done.iterations += 1;
        }
        let (matrix, step) = (&self.matrix, self.step());
        pool.par_chunks(x, LANES * CHUNK, &|first, x| matrix.add_to(first, step, x));
        done
    }

    /// What a unit of the correction adds to the solution.
    fn step(&self) -> f64 {
        self.scale * self.matrix.scale()
    }

    /// `r -= a S A p`, `h = P r`. Returns `r . h`.
    fn descend(&mut self, pool: &Pool, a: f32) -> f64 {
        let matrix = &self.matrix;
        pool.par_chunks(self.r.vectors_mut(), CHUNK, &|first, r| matrix.update_residual(first, a, r));
        ConstrainedNode::filter(&self.constrained, self.r.vectors_mut());
        self.precondition(pool)
    }

    /// `h = P r`. Returns `r . h`.
    fn precondition(&mut self, pool: &Pool) -> f64 {
        let mut none = Multilevel::default();
        let levels = self.levels.as_mut().unwrap_or(&mut none);
        let sum = levels.apply(pool, self.inverse.flat(), self.r.vectors(), self.h.vectors_mut());
        ConstrainedNode::filter(&self.constrained, self.h.vectors_mut());
        sum
    }
}
