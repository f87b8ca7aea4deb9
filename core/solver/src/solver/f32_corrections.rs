//! Conjugate gradients in single precision, the inner solver of iterative refinement.
//!
//! An iteration is bound by memory bandwidth, and single precision halves the traffic. The unknown is a correction, so its rounding does not
//! limit the accuracy of the solution: [`crate::solver`] computes the residual in double precision and requests corrections until it is small
//! enough (iterative refinement: Wilkinson 1963). Matrix and residual are scaled by powers of two, so that nothing underflows in any units.

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
use pliant_plugin_api::lanes::vector_unit;
use std::sync::atomic::{AtomicU64, Ordering};

/// Matrix, preconditioner and vectors of the corrections.
#[derive(Debug, Default)]
pub struct F32Corrections {
    matrix: F32Matrix,
    /// Weighted inverses of the diagonal blocks, six numbers each, in groups of sixteen nodes.
    inverse: Lines<f32>,
    levels: Option<Multilevel>,
    refresh: Refresh,
    constrained: Vec<ConstrainedNode>,
    /// Nodes that were constrained in the last solve, ascending, and their constraints.
    previous_constraints: Vec<(usize, Constraint)>,
    /// Weight of block Jacobi in the preconditioner, divided by the scale of the matrix.
    jacobi_weight: f64,
    /// `sum_i x_i . A_ii x_i` of positions at the last update.
    quadratic_form: f64,
    /// Largest condition number of a diagonal block; 0 before the first matrix.
    max_condition: f64,
    /// Residual, in groups of sixteen nodes.
    r: Lines<f32>,
    /// `P r`, in groups of sixteen nodes.
    h: Lines<f32>,
    /// Scale of the residual in `r`, a power of two.
    scale: f64,
}

/// Smallest factor by which one correction can reduce `r . P r` with the digits of single precision.
const MAX_REDUCTION: f64 = 1e-10;
/// Groups of sixteen nodes in a chunk of a vector for one thread.
const CHUNK: usize = 128;

/// Largest condition number of a diagonal block, divided by the tolerance of the solve, for a matrix in single precision: the relative error of
/// the stiffness between neighbours is then about 1e-3 of the tolerance.
const MAX_CONDITION_PER_TOLERANCE: f64 = 1e10;
/// Largest condition number of a diagonal block for a matrix in single precision at any tolerance: its smallest eigenvalue then has an error
/// of 1 %.
const MAX_CONDITION: f64 = 1e5;

/// Reduction of `r . P r` from one stop test to the next.
const STOP_TEST_INTERVAL: f64 = 0.1;
/// Multiple of the target below which there is no stop test, because finishing takes less time than starting again.
const STOP_TEST_END: f64 = 20.0;

/// Returns true if a solve is to stop with the partial solution.
pub type StopTest<'a> = dyn FnMut(&PartialSolution<'_>) -> bool + 'a;

/// Start and end of a correction.
#[derive(Clone, Copy, Debug)]
pub struct CorrectionGoal {
    /// `r . P r` of the residual that was loaded.
    pub d: f64,
    /// Value of `r . P r` at which the correction ends.
    pub target: f64,
    /// Largest number of iterations of a solve.
    pub max_iterations: usize,
}

/// Report of a correction.
#[derive(Clone, Copy, Debug, Default)]
pub struct CorrectionReport {
    /// Products with the matrix.
    pub iterations: usize,
    /// Whether a direction had zero or negative curvature, or a number was not finite.
    pub broken: bool,
    /// Whether the stop test ended the correction.
    pub stopped: bool,
}

impl F32Corrections {
    /// Sets the number of nodes and discards matrix and levels.
    pub fn resize(&mut self, n: usize) {
        let room = n.next_multiple_of(LANES);
        (self.r, self.h) = (Lines::new(3 * room), Lines::new(3 * room));
        self.inverse = Lines::new(6 * room);
        self.constrained.clear();
        self.constrained.reserve(n);
        self.previous_constraints.clear();
        self.previous_constraints.reserve(n);
        self.levels = None;
        self.refresh.end();
        self.matrix.forget();
        self.max_condition = 0.0;
    }

    /// Builds the levels of the multilevel preconditioner if there are none. `rest` are rest positions, m (n x 3).
    pub fn prepare(&mut self, matrix: &Matrix, sets: &[ElementSet], rest: &[Vec3]) {
        self.levels.get_or_insert_with(|| Multilevel::new(matrix, sets, rest));
    }

    /// Memory of matrix, levels and vectors, bytes.
    pub fn bytes(&self) -> usize {
        let vectors = 2 * self.r.bytes() + self.inverse.bytes();
        vectors + self.matrix.bytes() + self.levels.as_ref().map_or(0, Multilevel::bytes)
    }

    /// Loads the values of a matrix.
    pub fn load(&mut self, pool: &Pool, matrix: &Matrix) {
        self.matrix.update(pool, matrix);
    }

    /// Constrained nodes of the last update, ascending.
    pub fn constrained(&self) -> &[ConstrainedNode] {
        &self.constrained
    }

    /// `out[k] = A x[k]` in double precision.
    pub fn products<const K: usize>(&mut self, pool: &Pool, matrix: &Matrix, x: [&[Vec3]; K], out: [&mut [Vec3]; K]) {
        self.matrix.exact_products(pool, matrix, x, out);
    }

    /// Prepares the preconditioner for solves with the loaded matrix. Returns `sum_i x_i . A_ii x_i` of the positions x, and whether the condition
    /// of the diagonal blocks allows a preconditioner in single precision.
    pub fn update(&mut self, pool: &Pool, system: &FilteredSystem<'_>) -> (f64, bool) {
        let constraints = system.constraints;
        ConstrainedNode::list(constraints, &mut self.constrained);
        if system.same_matrix {
            // The levels of the previous constraints remain valid preconditioners; only changed diagonal blocks are inverted again.
            let before = |i: usize| match self.previous_constraints.binary_search_by_key(&i, |(node, _)| *node) {
                Ok(at) => self.previous_constraints[at].1,
                Err(_) => Constraint::Free,
            };
            let nodes = self
                .previous_constraints
                .iter()
                .map(|(node, _)| *node)
                .chain(self.constrained.iter().map(ConstrainedNode::index));
            for i in nodes.filter(|i| constraints[*i] != before(*i)) {
                let inverse = constrained_inverse(system.matrix.diagonal(i), &constraints[i]);
                put_inverse(self.inverse.flat_mut(), i, &inverse.map(|c| self.jacobi_weight * c));
            }
        }
        self.previous_constraints.clear();
        self.previous_constraints.extend(self.constrained.iter().map(|node| (node.index(), constraints[node.index()])));
        if system.same_matrix {
            return (self.quadratic_form, self.max_condition <= MAX_BLOCK_CONDITION);
        }
        self.jacobi_weight = 1.0 / self.matrix.scale();
        if let Some(levels) = &mut self.levels {
            let due = self.refresh.due(self.matrix.scale());
            self.matrix.without_fixed(pool, system.matrix, constraints, levels.sources(due));
            levels.update(pool, self.matrix.values(), due);
            self.jacobi_weight *= levels.finest_weight();
        }
        // Condition numbers are not negative, so their order is that of their bits, and an atomic maximum of the bits works.
        let (jacobi_weight, max_condition) = (self.jacobi_weight, AtomicU64::new(0));
        let all = Sixteens(self.inverse.flat_mut().as_chunks_mut().0.as_chunks_mut().0);
        self.quadratic_form = pool.fold(all, &|first, Sixteens(out)| {
            let (quadratic_form, condition) =
                vector_unit().dispatch(BlockInverses { system, weight: jacobi_weight, first, out });
            max_condition.fetch_max(condition.to_bits(), Ordering::Relaxed);
            quadratic_form
        });
        self.max_condition = f64::from_bits(max_condition.into_inner());
        (self.quadratic_form, self.max_condition <= MAX_BLOCK_CONDITION)
    }

    /// Whether the rounding of a matrix in single precision is below the error of a solve to `tolerance`, judged by the condition of the last
    /// matrix; true before the first matrix.
    pub fn allows_f32(&self, tolerance: f64) -> bool {
        let scale = self.matrix.scale();
        self.max_condition <= (tolerance * MAX_CONDITION_PER_TOLERANCE).min(MAX_CONDITION)
            && (scale == 0.0 || (1e-20..1e20).contains(&scale))
    }

    /// Marks all levels for an update, because the next matrix is unrelated to the last one.
    pub fn forget(&mut self) {
        self.refresh.end();
    }

    /// Records the iterations of the first solve with a matrix, which decide when all levels are updated.
    pub fn record_iterations(&mut self, iterations: usize) {
        self.refresh.record_iterations(iterations);
    }

    /// Loads a filtered residual (n x 3) with its squared norm. Returns `r . P r`.
    pub fn apply_preconditioner(&mut self, pool: &Pool, r: &[Vec3], squares: f64) -> f64 {
        let norm = squares.sqrt();
        self.scale = if norm.is_normal() { power_of_two(norm) } else { 1.0 };
        let down = 1.0 / self.scale;
        pool.par_chunks(self.r.vectors_mut(), CHUNK, &|first, to| {
            widest(ScaledBySixteen { scale: down, r: &r[LANES * first..], to })
        });
        self.unit() * self.precondition(pool)
    }

    /// Factor from the scaled `r . P r` of this solver to the unscaled one.
    fn unit(&self) -> f64 {
        self.scale * self.scale * self.matrix.scale()
    }

    /// Iterates on a correction for the residual loaded last until the goal is reached or `stop` returns true, and adds it to `x` (n x 3).
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
        while d > target && done.iterations < goal.max_iterations && !system.is_interrupted() {
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

    /// Factor from the scaled correction to the solution.
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
