//! Filtered preconditioned conjugate gradients.
//!
//! The method of Baraff and Witkin (1998) in the form of Ascher and Boxerman (2003): PCG on the projected system, warm
//! started, with the right scale in its stopping test. The preconditioner is block Jacobi of the *constrained* blocks,
//! `S (S A_ii S + I - S)^-1 S`, which halves the iterations against the unconstrained ones, alone or as the finest level of
//! [`super::multilevel`]. A residual that would move no position by its last digit is nothing: without that a body at rest
//! would iterate on rounding. Iterations are in single precision ([`self::inner`]), residuals in double.

mod double;
mod guess;
mod held;
mod inner;
mod inverses;
pub mod peek;
mod residual;
pub mod solve;

use super::algebra::Vec3;
use super::elements::ElementSet;
use super::matrix::Matrix;
use super::threads::{NODES, Pool};
use double::Double;
use guess::Guess;
use held::Held;
use inner::{Inner, Watch};
use residual::{Left, Squares};
use solve::{Solve, SolveReport};

/// What stands for the inverse of the matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preconditioner {
    /// Each node by itself: for matrices that are nearly those of the masses.
    #[default]
    BlockJacobi,
    /// Levels of ever coarser bodies: for stiff ones, iterations hardly grow with the mesh.
    Multilevel,
}

impl Preconditioner {
    /// As scenes write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::BlockJacobi => "block-jacobi",
            Self::Multilevel => "multilevel",
        }
    }
}

/// Vectors of a solve, kept from one to the next.
#[derive(Debug, Default)]
pub struct Pcg {
    /// Which preconditioner.
    pub preconditioner: Preconditioner,
    /// The solution; on entry the guess.
    pub x: Vec<Vec3>,
    guess: Guess,
    /// `A x` of the last solve.
    product: Vec<Vec3>,
    r: Vec<Vec3>,
    inner: Inner,
    double: Double,
}

/// Of what is enough, what a correction is asked for: what it says of itself is off by the rounding of its own.
const MARGIN: f64 = 0.95;
/// Of a residual, squared, what a correction has to leave less than: twice in a row more, and it is as good as it gets.
const SLOWEST: f64 = 0.25;

impl Pcg {
    /// Room for `n` nodes; the guess is zero.
    pub fn resize(&mut self, n: usize) {
        for field in [&mut self.x, &mut self.product, &mut self.r] {
            field.clear();
            field.resize(n, Vec3::zeros());
        }
        self.guess.resize(n);
        self.inner.resize(n);
        self.double.resize(n);
    }

    /// The next guess is zero.
    pub fn forget(&mut self) {
        self.x.fill(Vec3::zeros());
        self.guess.forget();
        self.inner.forget();
    }

    /// Finds the levels, if they are wanted and not there since the nodes or elements changed.
    pub fn prepare(&mut self, matrix: &Matrix, sets: &[ElementSet], rest: &[Vec3]) {
        if self.preconditioner == Preconditioner::Multilevel {
            self.inner.prepare(matrix, sets, rest);
        }
    }

    /// Nodes that were not free in the last solve, and what the matrix makes there of the solution.
    pub fn held(&self) -> impl Iterator<Item = (usize, Vec3)> {
        self.inner.held().iter().map(|held| (held.node(), self.product[held.node()]))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        3 * self.x.len() * size_of::<Vec3>() + self.guess.bytes() + self.inner.bytes() + self.double.bytes()
    }

    /// Before the first solve with a matrix: the guess, and what the matrix makes of it; and of `also` besides, which it puts into
    /// the second.
    pub fn guess(&mut self, pool: &Pool, matrix: &Matrix, also: Option<(&[Vec3], &mut [Vec3])>) {
        self.guess.go_on(pool, &mut self.x);
        self.load(pool, matrix, also);
    }

    /// The second half of that: takes over a matrix, and finds what it makes of the guess.
    pub fn load(&mut self, pool: &Pool, matrix: &Matrix, also: Option<(&[Vec3], &mut [Vec3])>) {
        self.inner.load(pool, matrix);
        match also {
            Some((x, out)) => self.inner.products(pool, matrix, [&self.x, x], [&mut self.product, out]),
            None => self.inner.products(pool, matrix, [&self.x], [&mut self.product]),
        }
    }

    /// Solves, starting from [`Pcg::guess`] or the last solution with the same matrix.
    pub fn solve(&mut self, pool: &Pool, system: &Solve<'_>) -> SolveReport {
        self.solve_watched(pool, system, &mut |_| false)
    }

    /// The same, unless `watch` has seen enough before it is done.
    pub fn solve_watched(&mut self, pool: &Pool, system: &Solve<'_>, watch: &mut Watch<'_>) -> SolveReport {
        let (z, s) = (system.z, system.constraints);
        let last_digit = (f64::EPSILON / system.motion.1) * (f64::EPSILON / system.motion.1);
        let (size, fits) = self.inner.update(pool, system);
        let floor = last_digit * if size.is_finite() { size } else { 0.0 };
        if !fits || (system.matrix.is_rounded() && !self.inner.bears_rounding(system.tolerance)) {
            return self.in_double(pool, system, floor, 0);
        }
        for i in self.inner.held().iter().map(Held::node) {
            let before = self.x[i];
            self.x[i] = s[i].merge(before, z[i]);
            let change = self.x[i] - before;
            if change != Vec3::zeros() {
                system.matrix.add_column(i, change, &mut self.product);
            }
        }
        // Scale: the right side as the prescribed part alone leaves it.
        self.product_of_held(system);
        let squares = self.left(pool, system, false);
        let scale = self.inner.weigh(pool, &self.r, squares);
        let mut d = self.residual(pool, system);
        if d > scale {
            self.shorten(pool, system);
            d = self.residual(pool, system);
        }
        let enough = (system.tolerance * system.tolerance * scale).max(floor);
        let mut report = SolveReport::default();
        let mut slow = 0;
        while d > enough && report.iterations < system.most && slow < 2 && report.stopped.is_none() {
            let before = (report.iterations, d);
            let most = system.most - report.iterations;
            let done = self.inner.correct(pool, (system, &mut self.x), (d, MARGIN * enough), most, watch);
            report.iterations += done.iterations;
            self.inner.products(pool, system.matrix, [&self.x], [&mut self.product]);
            d = self.residual(pool, system);
            slow = if d > SLOWEST * before.1 { slow + 1 } else { 0 };
            report.broken = done.broken && d > enough;
            report.stopped = done.stopped.then_some(d);
            if done.iterations == 0 || !d.is_finite() {
                break;
            }
        }
        if !system.again && report.stopped.is_none() {
            self.inner.took(report.iterations);
            self.guess.took(report.iterations);
        }
        report.close(d, scale, (enough, floor));
        if report.converged || report.stopped.is_some() || (report.iterations >= system.most && !report.broken) {
            return report;
        }
        // Single precision was too short, or the system has no solution: double precision tells.
        self.in_double(pool, system, floor, report.iterations)
    }

    /// Whether the next matrix may be rounded for a solve to a tolerance, going by the last one.
    pub fn bears_rounding(&self, tolerance: f64) -> bool {
        self.inner.bears_rounding(tolerance)
    }

    fn in_double(&mut self, pool: &Pool, system: &Solve<'_>, floor: f64, before: usize) -> SolveReport {
        if system.matrix.is_rounded() {
            return SolveReport { iterations: before, too_rough: true, residual: f64::NAN, ..SolveReport::default() };
        }
        let report = self.double.solve(pool, system, (&mut self.x, &mut self.r), floor);
        system.matrix.product(pool, &self.x, &mut self.product);
        SolveReport { iterations: before + report.iterations, ..report }
    }

    /// `r = A (I - S) z`
    fn product_of_held(&mut self, system: &Solve<'_>) {
        self.r.fill(Vec3::zeros());
        for i in self.inner.held().iter().map(Held::node) {
            let held = system.z[i] - system.constraints[i].filter(system.z[i]);
            if held != Vec3::zeros() {
                system.matrix.add_column(i, held, &mut self.r);
            }
        }
    }

    /// A guess that is worse than none, as after a jump, is made as long as serves best: `s = S x` is scaled so that what is wrong is
    /// least in the norm of the matrix, and `A x` with it.
    fn shorten(&mut self, pool: &Pool, system: &Solve<'_>) {
        self.product_of_held(system);
        let (x, product, constraints, r) = (&mut self.x, &mut self.product, system.constraints, &self.r);
        let (x_now, product_now) = (&x[..], &product[..]);
        let sum = |of: &(dyn Fn(usize) -> Vec3 + Sync)| {
            pool.fold(0..x_now.len(), &|_, part: std::ops::Range<usize>| {
                part.map(|i| constraints[i].filter(x_now[i]).dot(&of(i))).sum()
            })
        };
        let (wanted, has) = (sum(&|i| system.b[i] - r[i]), sum(&|i| product_now[i] - r[i]));
        let more = wanted / has - 1.0;
        if !(has > 0.0 && more.is_finite()) {
            return;
        }
        pool.pieces((&mut x[..], &mut product[..]), NODES, &|first, (x, product): (&mut [Vec3], &mut [Vec3])| {
            for (i, (x, product)) in (first..).zip(x.iter_mut().zip(product)) {
                *x += more * constraints[i].filter(*x);
                *product += more * (*product - r[i]);
            }
        });
    }

    /// `r = S (b - A x)`; gives `r . P r`.
    fn residual(&mut self, pool: &Pool, system: &Solve<'_>) -> f64 {
        let squares = self.left(pool, system, true);
        self.inner.weigh(pool, &self.r, squares)
    }

    /// `r = S (b - r)`, or with the product in the place of r; gives `r . r`.
    fn left(&mut self, pool: &Pool, system: &Solve<'_>, of_product: bool) -> f64 {
        let (product, held, arch) = (of_product.then_some(&self.product), self.inner.held(), pulp::Arch::new());
        pool.fold(&mut self.r[..], &|first, r: &mut [Vec3]| {
            arch.dispatch(Left { b: &system.b[first..], taken: product.map(|product| &product[first..]), r: &mut *r });
            let (from, end) = (held.partition_point(|held| held.node() < first), first + r.len());
            for i in held[from..].iter().map(Held::node).take_while(|i| *i < end) {
                r[i - first] = system.constraints[i].filter(r[i - first]);
            }
            arch.dispatch(Squares(r))
        })
    }
}
