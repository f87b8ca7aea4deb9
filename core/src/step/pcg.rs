//! Filtered preconditioned conjugate gradients.
//!
//! The method of Baraff and Witkin (1998) in the form of Ascher and Boxerman (2003): PCG on the projected system, warm
//! started, with the right scale in its stopping test. The preconditioner is block Jacobi of the *constrained* blocks,
//! `S (S A_ii S + I - S)^-1 S`, which halves the iterations against the unconstrained ones, alone or as the finest level of
//! [`Multilevel`]. A residual that would move no position by its last digit is nothing: without that a body at rest would
//! iterate on rounding.

use super::constraint::Constraint;
use super::elements::ElementSet;
use super::matrix::Matrix;
use super::multilevel::Multilevel;
use super::pool::Pool;
use super::{Block, V3, axpy, dot, times};
use nalgebra::Matrix3;

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
    pub x: Vec<V3>,
    r: Vec<V3>,
    p: Vec<V3>,
    s: Vec<V3>,
    h: Vec<V3>,
    inverse: Vec<Block>,
    levels: Option<Multilevel>,
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
    /// m, positions that the solution moves (n x 3), and by how much a unit of it does
    pub motion: (&'a [V3], f64),
    /// Whether the matrix is that of the last solve.
    pub again: bool,
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
        self.levels = None;
    }

    /// The next guess is zero.
    pub fn forget(&mut self) {
        self.x.fill([0.0; 3]);
    }

    /// Finds the levels, if they are wanted and not there since the nodes or elements changed.
    pub fn prepare(&mut self, matrix: &Matrix, sets: &[ElementSet]) {
        if self.preconditioner == Preconditioner::Multilevel && self.levels.is_none() {
            self.levels = Some(Multilevel::new(matrix, sets));
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.x.len() * (5 * size_of::<V3>() + size_of::<Block>()) + self.levels.as_ref().map_or(0, Multilevel::bytes)
    }

    /// Solves, starting from `self.x`.
    pub fn solve(&mut self, pool: &Pool, system: &Solve<'_>) -> SolveReport {
        let n = system.b.len();
        let (z, s) = (system.z, system.constraints);
        let floor = self.precondition(pool, system);
        for i in 0..n {
            self.x[i] = s[i].merge(self.x[i], z[i]);
            // Scale: the right side as the prescribed part alone leaves it.
            self.p[i] = axpy(z[i], -1.0, s[i].filter(z[i]));
        }
        let scale = self.start(pool, system);
        self.p.copy_from_slice(&self.x);
        let mut d = self.start(pool, system);
        self.p.copy_from_slice(&self.h);
        let enough = (system.tolerance * system.tolerance * scale).max(floor);
        let mut report = SolveReport::default();
        while d > enough && report.iterations < system.most {
            let q = self.apply(pool, system);
            if !(q > 0.0 && q.is_finite()) {
                report.broken = true;
                break;
            }
            let next = self.descend(pool, system, d / q);
            let (h, beta) = (&self.h, next / d);
            pool.pieces(&mut self.p, PIECE, &|first, p| {
                p.iter_mut().zip(&h[first..]).for_each(|(p, h)| *p = axpy(*h, beta, *p));
            });
            d = next;
            report.iterations += 1;
        }
        report.broken |= !d.is_finite();
        // A scale that is not finite, or overflowed, measures nothing; one below the floor is zero.
        report.residual = match scale {
            _ if !scale.is_finite() => f64::NAN,
            _ if d <= floor && scale <= floor => 0.0,
            _ => (d / scale).sqrt(),
        };
        report.converged = d <= enough && !report.broken;
        report
    }

    /// `s = S A p`; gives `p.s`.
    fn apply(&mut self, pool: &Pool, system: &Solve<'_>) -> f64 {
        let (p, constraints) = (&self.p, system.constraints);
        pool.fold(&mut self.s[..], &|first, s| {
            system.matrix.rows_product(first, p, s);
            let rows = s.iter_mut().zip(&p[first..]).zip(&constraints[first..]);
            rows.fold(0.0, |sum, ((s, p), constraint)| {
                *s = constraint.filter(*s);
                sum + dot(*p, *s)
            })
        })
    }

    /// `r = S (b - A p)`, `h = P r`; gives `r.h`.
    fn start(&mut self, pool: &Pool, system: &Solve<'_>) -> f64 {
        self.apply(pool, system);
        for i in 0..system.b.len() {
            self.r[i] = axpy(system.constraints[i].filter(system.b[i]), -1.0, self.s[i]);
        }
        self.descend_nowhere(pool, system)
    }

    fn descend_nowhere(&mut self, pool: &Pool, system: &Solve<'_>) -> f64 {
        let (r, inverse) = (&self.r, &self.inverse);
        let sum = pool.fold(&mut self.h[..], &|first, h| {
            let rows = h.iter_mut().zip(&r[first..]).zip(&inverse[first..]);
            rows.fold(0.0, |sum, ((h, r), inverse)| {
                *h = times(inverse, *r);
                sum + dot(*r, *h)
            })
        });
        self.add_levels(pool, system).unwrap_or(sum)
    }

    /// `x += a p`, `r -= a s`, `h = P r`; gives `r.h`.
    fn descend(&mut self, pool: &Pool, system: &Solve<'_>, a: f64) -> f64 {
        let (p, s, inverse) = (&self.p, &self.s, &self.inverse);
        let sum = pool.fold((&mut self.x[..], (&mut self.r[..], &mut self.h[..])), &|first, (x, (r, h))| {
            let mut sum = 0.0;
            for i in 0..x.len() {
                x[i] = axpy(x[i], a, p[first + i]);
                r[i] = axpy(r[i], -a, s[first + i]);
                h[i] = times(&inverse[first + i], r[i]);
                sum += dot(r[i], h[i]);
            }
            sum
        });
        self.add_levels(pool, system).unwrap_or(sum)
    }

    /// Adds the coarse levels to `h`, if there are any; gives `r.h`.
    fn add_levels(&mut self, pool: &Pool, system: &Solve<'_>) -> Option<f64> {
        let (r, constraints) = (&self.r, system.constraints);
        self.levels.as_mut().map(|levels| levels.add(pool, r, &mut self.h, constraints))
    }

    /// Takes over the matrix. Gives the floor of the stopping test.
    fn precondition(&mut self, pool: &Pool, system: &Solve<'_>) -> f64 {
        let (mut share, (x, unit)) = (1.0, system.motion);
        if let Some(levels) = &mut self.levels {
            levels.update(pool, system.matrix, system.constraints, system.again);
            share = levels.share();
        }
        let last_digit = (f64::EPSILON / unit) * (f64::EPSILON / unit);
        let size = pool.fold(&mut self.inverse[..], &|first, inverse| {
            let mut size = 0.0;
            for (i, inverse) in inverse.iter_mut().enumerate() {
                let block = system.matrix.diagonal(first + i);
                *inverse = constrained_inverse(block, &system.constraints[first + i]).map(|c| share * c);
                size += dot(x[first + i], times(block, x[first + i]));
            }
            size
        });
        last_digit * if size.is_finite() { size } else { 0.0 }
    }
}

/// Nodes in a piece of a vector for a thread.
const PIECE: usize = 1024;

/// `S (S A S + I - S)^-1 S`
fn constrained_inverse(block: &Block, constraint: &Constraint) -> Block {
    match constraint {
        Constraint::Fixed => return [0.0; 9],
        Constraint::Free => {
            if let Some(inverse) = symmetric_inverse(block) {
                return inverse;
            }
        }
        _ => {}
    }
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

/// By cofactors; `None` where there is none.
pub(super) fn symmetric_inverse(m: &Block) -> Option<Block> {
    let (c0, c1, c2) = (m[4] * m[8] - m[5] * m[5], m[5] * m[2] - m[1] * m[8], m[1] * m[5] - m[4] * m[2]);
    let det = m[0] * c0 + m[1] * c1 + m[2] * c2;
    if !(det.is_finite() && det != 0.0) {
        return None;
    }
    let (c3, c4, c5) = (m[0] * m[8] - m[2] * m[2], m[2] * m[1] - m[0] * m[5], m[0] * m[4] - m[1] * m[1]);
    let i = 1.0 / det;
    Some([c0 * i, c1 * i, c2 * i, c1 * i, c3 * i, c4 * i, c2 * i, c4 * i, c5 * i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_is_one() {
        let a = [4.0, 1.0, -0.5, 1.0, 3.0, 0.25, -0.5, 0.25, 2.0];
        let b = symmetric_inverse(&a).unwrap();
        for i in 0..9 {
            let product: f64 = (0..3).map(|k| a[3 * (i / 3) + k] * b[3 * k + i % 3]).sum();
            assert!((product - f64::from(u8::from(i % 4 == 0))).abs() < 1e-15, "{i}: {product}");
        }
        assert!(symmetric_inverse(&[0.0; 9]).is_none() && symmetric_inverse(&[f64::NAN; 9]).is_none());
    }
}
