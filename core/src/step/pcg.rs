//! Filtered preconditioned conjugate gradients.
//!
//! The method of Baraff and Witkin (1998) in the form of Ascher and Boxerman (2003): PCG on the projected system, warm
//! started, with the right scale in its stopping test. The preconditioner is block Jacobi of the *constrained* blocks,
//! `S (S A_ii S + I - S)^-1 S`, which halves the iterations against the unconstrained ones.

use super::constraint::Constraint;
use super::matrix::Matrix;
use super::pool::Pool;
use super::{Block, V3, axpy, dot, times};
use nalgebra::Matrix3;

/// Vectors of a solve, kept from one to the next.
#[derive(Debug, Default)]
pub struct Pcg {
    /// The solution; on entry the guess.
    pub x: Vec<V3>,
    r: Vec<V3>,
    p: Vec<V3>,
    s: Vec<V3>,
    h: Vec<V3>,
    inverse: Vec<Block>,
}

/// `S A x = S b`, `(I - S) x = (I - S) z`.
pub struct Solve<'a> {
    /// `A`.
    pub matrix: &'a Matrix,
    /// Right side (n x 3).
    pub b: &'a [V3],
    /// What is prescribed (n x 3).
    pub z: &'a [V3],
    /// `S` (n).
    pub constraints: &'a [Constraint],
    /// Relative to the filtered right side, in the preconditioner's norm.
    pub tolerance: f64,
    /// Iterations at most.
    pub most: usize,
}

/// How a solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Products with the matrix after the first residual.
    pub iterations: usize,
    /// Final residual over the scale of the stopping test; not finite if the system was not.
    pub residual: f64,
    /// Whether the tolerance was met.
    pub converged: bool,
    /// Whether a direction of no or negative curvature was met, or a number that is not finite.
    pub broken: bool,
}

impl Pcg {
    /// Room for `n` nodes; the guess is zero.
    pub fn resize(&mut self, n: usize) {
        for field in [&mut self.x, &mut self.r, &mut self.p, &mut self.s, &mut self.h] {
            field.clear();
            field.resize(n, [0.0; 3]);
        }
        self.inverse.resize(n, [0.0; 9]);
    }

    /// The next guess is zero.
    pub fn forget(&mut self) {
        self.x.fill([0.0; 3]);
    }

    /// Solves, starting from `self.x`.
    pub fn solve(&mut self, pool: &Pool, system: &Solve<'_>) -> SolveReport {
        let n = system.b.len();
        let (b, z, s) = (system.b, system.z, system.constraints);
        self.precondition(system);
        for i in 0..n {
            self.x[i] = s[i].merge(self.x[i], z[i]);
        }
        // Scale: the right side as the prescribed part alone leaves it.
        for i in 0..n {
            self.p[i] = axpy(z[i], -1.0, s[i].filter(z[i]));
        }
        self.apply(pool, system);
        for i in 0..n {
            self.r[i] = s[i].filter(axpy(b[i], -1.0, self.s[i]));
        }
        let scale = self.precondition_residual(pool);
        self.p.copy_from_slice(&self.x);
        self.apply(pool, system);
        for i in 0..n {
            self.r[i] = s[i].filter(axpy(b[i], -1.0, self.s[i]));
        }
        let mut d = self.precondition_residual(pool);
        self.p.copy_from_slice(&self.h);
        let enough = system.tolerance * system.tolerance * scale;
        let mut report = SolveReport::default();
        while d > enough && report.iterations < system.most {
            self.apply(pool, system);
            for i in 0..n {
                self.s[i] = s[i].filter(self.s[i]);
            }
            let q = self.dot(pool, &self.p, &self.s);
            if !(q > 0.0 && q.is_finite()) {
                report.broken = true;
                break;
            }
            let step = d / q;
            for i in 0..n {
                self.x[i] = axpy(self.x[i], step, self.p[i]);
                self.r[i] = axpy(self.r[i], -step, self.s[i]);
            }
            let next = self.precondition_residual(pool);
            let beta = next / d;
            for i in 0..n {
                self.p[i] = axpy(self.h[i], beta, self.p[i]);
            }
            d = next;
            report.iterations += 1;
        }
        report.broken |= !d.is_finite();
        // A scale that is not finite, or overflowed, measures nothing.
        report.residual = match scale {
            0.0 => 0.0,
            _ if scale.is_finite() => (d / scale).sqrt(),
            _ => f64::NAN,
        };
        report.converged = d <= enough && !report.broken;
        report
    }

    fn dot(&self, pool: &Pool, a: &[V3], b: &[V3]) -> f64 {
        pool.sum(a.len(), &|range| a[range.clone()].iter().zip(&b[range]).map(|(a, b)| dot(*a, *b)).sum())
    }

    /// `s = A p`
    fn apply(&mut self, pool: &Pool, system: &Solve<'_>) {
        system.matrix.product(pool, &self.p, &mut self.s);
    }

    /// `h = P r`; gives `r.h`.
    fn precondition_residual(&mut self, pool: &Pool) -> f64 {
        for i in 0..self.r.len() {
            self.h[i] = times(&self.inverse[i], self.r[i]);
        }
        self.dot(pool, &self.r, &self.h)
    }

    fn precondition(&mut self, system: &Solve<'_>) {
        for i in 0..system.b.len() {
            self.inverse[i] = constrained_inverse(system.matrix.diagonal(i), &system.constraints[i]);
        }
    }
}

/// `S (S A S + I - S)^-1 S`
fn constrained_inverse(block: &Block, constraint: &Constraint) -> Block {
    let filter = |m: Matrix3<f64>| {
        Matrix3::from_columns(&[0, 1, 2].map(|c| {
            let column = m.column(c);
            constraint.filter([column[0], column[1], column[2]]).into()
        }))
    };
    let a = Matrix3::from_row_slice(block);
    let s = filter(Matrix3::identity());
    let inner = s * a * s + Matrix3::identity() - s;
    let inverse = inner.try_inverse().unwrap_or_else(Matrix3::identity);
    let out = s * inverse * s;
    std::array::from_fn(|e| out[(e / 3, e % 3)])
}
