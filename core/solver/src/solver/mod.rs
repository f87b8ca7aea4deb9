//! Filtered preconditioned conjugate gradients.
//!
//! The method of Baraff and Witkin (1998) in the form of Ascher and Boxerman (2003): PCG on the projected system with a warm start, and a
//! stopping test relative to the projected right-hand side. The preconditioner is block Jacobi with the *constrained* blocks
//! `S (S A_ii S + I - S)^-1 S`, which needs half of the iterations of the unconstrained ones, alone or as the finest level of
//! [`super::multilevel`]. A residual whose correction is below the last digit of every position counts as zero; otherwise a body at rest
//! would iterate on rounding errors. Iterations are in single precision ([`self::f32_corrections`]), residuals in double precision.

mod block_jacobi;
mod constrained_nodes;
mod f32_corrections;
mod f64_solver;
pub mod filtered_system;
mod initial_guess;
pub mod partial_solution;
mod residual;

use super::algebra::Vec3;
use super::elements::ElementSet;
use super::matrix::Matrix;
use super::threads::{NODES, Pool};
use constrained_nodes::ConstrainedNode;
use f32_corrections::{CorrectionGoal, F32Corrections, StopTest};
use f64_solver::F64Solver;
use filtered_system::{FilteredSystem, SolveReport, StoppingTest};
use initial_guess::InitialGuess;
use pliant_plugin_api::lanes::vector_unit;
use residual::{Residual, SquaredNorm};

/// Approximation of the inverse of the matrix, P.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preconditioner {
    /// Inverses of the diagonal blocks, for matrices dominated by the masses.
    #[default]
    BlockJacobi,
    /// An additive multilevel method for stiff bodies, whose iterations hardly grow with the mesh.
    Multilevel,
}

impl Preconditioner {
    /// Name in scene files, such as `block-jacobi`.
    pub fn name(self) -> &'static str {
        match self {
            Self::BlockJacobi => "block-jacobi",
            Self::Multilevel => "multilevel",
        }
    }
}

/// The preconditioned conjugate gradient solver of one body, with its work vectors, previous solutions and statistics.
#[derive(Debug, Default)]
pub struct Pcg {
    /// Preconditioner of the solve.
    pub preconditioner: Preconditioner,
    /// The solution (n x 3); on entry the initial guess.
    pub x: Vec<Vec3>,
    guess: InitialGuess,
    /// `A x` of the last solve (n x 3).
    product: Vec<Vec3>,
    /// Residual (n x 3).
    r: Vec<Vec3>,
    inner: F32Corrections,
    double: F64Solver,
}

/// Safety factor on the target of a correction, for the rounding error of its residual in single precision.
const TARGET_MARGIN: f64 = 0.95;
/// A correction that reduces `r . P r` by less than this factor is slow; after two slow ones single precision is exhausted.
const SLOW_REDUCTION: f64 = 0.25;

/// A velocity field and its product with the matrix, `A v`, for right-hand sides linearised at the present state.
pub struct Momentum<'a> {
    /// Velocities, m/s (n x 3).
    pub v: &'a [Vec3],
    /// Receives `A v`, N s (n x 3).
    pub product: &'a mut [Vec3],
}

/// The product in a residual.
enum ResidualOf {
    /// `A x`, in `product`.
    Solution,
    /// `A (I - S) z`, in `r` itself.
    Prescribed,
}

impl Pcg {
    /// Sets the number of nodes and the guess to zero.
    pub fn resize(&mut self, n: usize) {
        for field in [&mut self.x, &mut self.product, &mut self.r] {
            field.clear();
            field.resize(n, Vec3::zeros());
        }
        self.guess.resize(n);
        self.inner.resize(n);
        self.double.resize(n);
    }

    /// Sets the next guess to zero and marks the levels for an update.
    pub fn forget(&mut self) {
        self.x.fill(Vec3::zeros());
        self.guess.forget();
        self.inner.forget();
    }

    /// Builds the levels of the multilevel preconditioner if it is selected and nodes or elements have changed.
    /// `rest` are rest positions, m (n x 3).
    pub fn prepare(&mut self, matrix: &Matrix, sets: &[ElementSet], rest: &[Vec3]) {
        if self.preconditioner == Preconditioner::Multilevel {
            self.inner.prepare(matrix, sets, rest);
        }
    }

    /// Nodes that were constrained in the last solve, ascending, each with its row of `A x`.
    pub fn constrained(&self) -> impl Iterator<Item = (usize, Vec3)> {
        self.inner.constrained().iter().map(|node| (node.index(), self.product[node.index()]))
    }

    /// Memory of vectors, matrices and levels, bytes.
    pub fn bytes(&self) -> usize {
        3 * self.x.len() * size_of::<Vec3>() + self.guess.bytes() + self.inner.bytes() + self.double.bytes()
    }

    /// Extrapolates an initial guess from the last solutions and loads the matrix. Call it before the first solve with a matrix. Also computes the
    /// product of `momentum`.
    pub fn guess(&mut self, pool: &Pool, matrix: &Matrix, momentum: Option<Momentum<'_>>) {
        self.guess.extrapolate(pool, &mut self.x);
        self.load(pool, matrix, momentum);
    }

    /// Loads a matrix and computes its product with the guess.
    pub fn load(&mut self, pool: &Pool, matrix: &Matrix, momentum: Option<Momentum<'_>>) {
        self.inner.load(pool, matrix);
        match momentum {
            Some(Momentum { v: x, product: out }) => {
                self.inner.products(pool, matrix, [&self.x, x], [&mut self.product, out])
            }
            None => self.inner.products(pool, matrix, [&self.x], [&mut self.product]),
        }
    }

    /// Sets the solution to zero, for solves with the last matrix and other right-hand sides.
    pub fn begin_responses(&mut self) {
        self.x.fill(Vec3::zeros());
        self.product.fill(Vec3::zeros());
    }

    /// Adds `by` to the solution at every node, and its product with a matrix that lets a body with these masses (kg, n) move without force: `M by`.
    pub fn add_uniform(&mut self, mass: &[f64], by: Vec3) {
        for ((x, product), mass) in self.x.iter_mut().zip(&mut self.product).zip(mass) {
            *x += by;
            *product += *mass * by;
        }
    }

    /// Solves a system into `self.x`, starting from [`Pcg::guess`] or from the last solution with the same matrix.
    pub fn solve(&mut self, pool: &Pool, system: &FilteredSystem<'_>) -> SolveReport {
        self.solve_until(pool, system, &mut |_| false)
    }

    /// Solves a system, or stops early when `stop` returns true for a partial solution. A stopped solve is continued by another one with
    /// `same_matrix`.
    pub fn solve_until(&mut self, pool: &Pool, system: &FilteredSystem<'_>, stop: &mut StopTest<'_>) -> SolveReport {
        let (z, s) = (system.z, system.constraints);
        let unit = system.displacement_per_unit;
        let last_digit = (f64::EPSILON / unit) * (f64::EPSILON / unit);
        let (size, fits) = self.inner.update(pool, system);
        let floor = last_digit * if size.is_finite() { size } else { 0.0 };
        if !fits || (system.matrix.is_f32() && !self.inner.allows_f32(system.tolerance)) {
            return self.solve_in_f64(pool, system, floor, 0);
        }
        for i in self.inner.constrained().iter().map(ConstrainedNode::index) {
            let before = self.x[i];
            self.x[i] = s[i].merge(before, z[i]);
            let change = self.x[i] - before;
            if change != Vec3::zeros() {
                system.matrix.add_column(i, change, &mut self.product);
            }
        }
        // The reference of the stopping test is the residual of the prescribed part alone.
        self.product_of_prescribed(system);
        let squares = self.residual_of(pool, system, ResidualOf::Prescribed);
        let scale = self.inner.apply_preconditioner(pool, &self.r, squares);
        let mut d = self.residual(pool, system);
        if d > scale {
            self.scale_guess(pool, system);
            d = self.residual(pool, system);
        }
        let test = StoppingTest::new(system.tolerance, scale, floor);
        let mut report = SolveReport::default();
        let mut slow = 0;
        while d > test.target && report.iterations < system.max_iterations && slow < 2 && report.stopped_at.is_none() {
            let before = (report.iterations, d);
            let left = system.max_iterations - report.iterations;
            let goal = CorrectionGoal { d, target: TARGET_MARGIN * test.target, max_iterations: left };
            let done = self.inner.correct(pool, system, &mut self.x, goal, stop);
            report.iterations += done.iterations;
            self.inner.products(pool, system.matrix, [&self.x], [&mut self.product]);
            d = self.residual(pool, system);
            slow = if d > SLOW_REDUCTION * before.1 { slow + 1 } else { 0 };
            report.broken = done.broken && d > test.target;
            report.stopped_at = done.stopped.then_some(d);
            if done.iterations == 0 || !d.is_finite() || system.is_interrupted() {
                break;
            }
        }
        if !system.same_matrix && report.stopped_at.is_none() {
            self.inner.record_iterations(report.iterations);
            self.guess.record_iterations(report.iterations);
        }
        report.close(d, test);
        if report.converged
            || report.stopped_at.is_some()
            || (report.iterations >= system.max_iterations && !report.broken)
            || system.is_interrupted()
        {
            return report;
        }
        // Either single precision is not sufficient or the system is singular; double precision decides.
        self.solve_in_f64(pool, system, floor, report.iterations)
    }

    /// Whether the next matrix may be stored in single precision for a solve to `tolerance`, judged by the last one.
    pub fn allows_f32(&self, tolerance: f64) -> bool {
        self.inner.allows_f32(tolerance)
    }

    /// Solves in double precision after `before` iterations in single precision; not with a matrix in single precision.
    fn solve_in_f64(&mut self, pool: &Pool, system: &FilteredSystem<'_>, floor: f64, before: usize) -> SolveReport {
        if system.matrix.is_f32() {
            return SolveReport { iterations: before, needs_f64: true, residual: f64::NAN, ..SolveReport::default() };
        }
        let report = self.double.solve(pool, system, &mut self.x, &mut self.r, floor);
        system.matrix.product(pool, &self.x, &mut self.product);
        SolveReport { iterations: before + report.iterations, ..report }
    }

    /// `r = A (I - S) z`
    fn product_of_prescribed(&mut self, system: &FilteredSystem<'_>) {
        self.r.fill(Vec3::zeros());
        for i in self.inner.constrained().iter().map(ConstrainedNode::index) {
            let prescribed = system.z[i] - system.constraints[i].filter(system.z[i]);
            if prescribed != Vec3::zeros() {
                system.matrix.add_column(i, prescribed, &mut self.r);
            }
        }
    }

    /// Scales a guess that is worse than zero, as after a jump of the solution: multiplies `S x`, and `A x` accordingly, by the factor that
    /// minimises the error in the norm of the matrix.
    fn scale_guess(&mut self, pool: &Pool, system: &FilteredSystem<'_>) {
        self.product_of_prescribed(system);
        let (x, product, constraints, r) = (&mut self.x, &mut self.product, system.constraints, &self.r);
        let (x_now, product_now) = (&x[..], &product[..]);
        let sum = |of: &(dyn Fn(usize) -> Vec3 + Sync)| {
            pool.fold(0..x_now.len(), &|_, part: std::ops::Range<usize>| {
                part.map(|i| constraints[i].filter(x_now[i]).dot(&of(i))).sum()
            })
        };
        let (wanted, has) = (sum(&|i| system.b[i] - r[i]), sum(&|i| product_now[i] - r[i]));
        let correction = wanted / has - 1.0;
        if !(has > 0.0 && correction.is_finite()) {
            return;
        }
        pool.par_chunks((&mut x[..], &mut product[..]), NODES, &|first, (x, product): (&mut [Vec3], &mut [Vec3])| {
            for (i, (x, product)) in (first..).zip(x.iter_mut().zip(product)) {
                *x += correction * constraints[i].filter(*x);
                *product += correction * (*product - r[i]);
            }
        });
    }

    /// Computes `r = S (b - A x)`. Returns `r . P r`.
    fn residual(&mut self, pool: &Pool, system: &FilteredSystem<'_>) -> f64 {
        let squares = self.residual_of(pool, system, ResidualOf::Solution);
        self.inner.apply_preconditioner(pool, &self.r, squares)
    }

    /// Computes `r = S (b - A x)` from a known product. Returns `r . r`.
    fn residual_of(&mut self, pool: &Pool, system: &FilteredSystem<'_>, of: ResidualOf) -> f64 {
        let product = match of {
            ResidualOf::Solution => Some(&self.product),
            ResidualOf::Prescribed => None,
        };
        let (constrained, arch) = (self.inner.constrained(), vector_unit());
        pool.fold(&mut self.r[..], &|first, r: &mut [Vec3]| {
            let product = product.map(|product| &product[first..]);
            arch.dispatch(Residual { b: &system.b[first..], product, r: &mut *r });
            let (from, end) = (constrained.partition_point(|node| node.index() < first), first + r.len());
            for i in constrained[from..].iter().map(ConstrainedNode::index).take_while(|i| *i < end) {
                r[i - first] = system.constraints[i].filter(r[i - first]);
            }
            arch.dispatch(SquaredNorm(r))
        })
    }
}
