//! Conjugate gradients in double precision, for systems that are too ill-conditioned for single precision ([`super::f32_corrections`]).
//!
//! The hinges of collapsed triangles are about 1e12 times as stiff as the others. Such steps are rare, so this solver is simple: block Jacobi,
//! whose blocks are inverted at every use, without levels.

use super::filtered_system::{FilteredSystem, SolveReport, StoppingTest};
use crate::algebra::{Vec3, matrix3};
use crate::constraint::constrained_inverse;
use crate::threads::Pool;

/// Work vectors of the solver.
#[derive(Debug, Default)]
pub struct F64Solver {
    p: Vec<Vec3>,
    s: Vec<Vec3>,
    h: Vec<Vec3>,
}

impl F64Solver {
    /// Sets the number of nodes.
    pub fn resize(&mut self, n: usize) {
        for field in [&mut self.p, &mut self.s, &mut self.h] {
            field.clear();
            field.resize(n, Vec3::zeros());
        }
    }

    /// Memory of the work vectors, bytes.
    pub fn bytes(&self) -> usize {
        3 * self.p.len() * size_of::<Vec3>()
    }

    /// Solves a system. `x` holds the initial guess and receives the solution; a guess that is not finite counts as zero. `r` receives the
    /// residual. Values of `r . P r` below `floor` count as zero.
    pub fn solve(
        &mut self,
        pool: &Pool,
        system: &FilteredSystem<'_>,
        x: &mut [Vec3],
        r: &mut [Vec3],
        floor: f64,
    ) -> SolveReport {
        let (z, s) = (system.z, system.constraints);
        if !x.iter().flatten().all(|c| c.is_finite()) {
            x.fill(Vec3::zeros());
        }
        for i in 0..x.len() {
            x[i] = s[i].merge(x[i], z[i]);
            self.p[i] = z[i] - s[i].filter(z[i]);
        }
        let scale = self.start(pool, system, r);
        self.p.copy_from_slice(x);
        let mut d = self.start(pool, system, r);
        self.p.copy_from_slice(&self.h);
        let test = StoppingTest::new(system.tolerance, scale, floor);
        let mut report = SolveReport::default();
        while d > test.target && report.iterations < system.max_iterations && !system.is_interrupted() {
            let q = self.apply(pool, system);
            if !(q > 0.0 && q.is_finite()) {
                report.broken = true;
                break;
            }
            for i in 0..x.len() {
                x[i] += d / q * self.p[i];
                r[i] -= d / q * self.s[i];
            }
            let next = self.apply_preconditioner(pool, system, r);
            for (p, h) in self.p.iter_mut().zip(&self.h) {
                *p = *h + next / d * *p;
            }
            d = next;
            report.iterations += 1;
        }
        report.close(d, test);
        report
    }

    /// `s = S A p`. Returns `p . s`.
    fn apply(&mut self, pool: &Pool, system: &FilteredSystem<'_>) -> f64 {
        let (p, constraints) = (&self.p, system.constraints);
        pool.fold(&mut self.s[..], &|first, s| {
            system.matrix.rows_product(first, p, s);
            let rows = s.iter_mut().zip(&p[first..]).zip(&constraints[first..]);
            rows.fold(0.0, |sum, ((s, p), constraint)| {
                *s = constraint.filter(*s);
                sum + p.dot(s)
            })
        })
    }

    /// `r = S (b - A p)`, `h = P r`. Returns `r . h`.
    fn start(&mut self, pool: &Pool, system: &FilteredSystem<'_>, r: &mut [Vec3]) -> f64 {
        self.apply(pool, system);
        for i in 0..r.len() {
            r[i] = system.constraints[i].filter(system.b[i]) - self.s[i];
        }
        self.apply_preconditioner(pool, system, r)
    }

    /// `h = P r`. Returns `r . h`.
    fn apply_preconditioner(&mut self, pool: &Pool, system: &FilteredSystem<'_>, r: &[Vec3]) -> f64 {
        pool.fold(&mut self.h[..], &|first, h| {
            let mut sum = 0.0;
            for (i, h) in h.iter_mut().enumerate() {
                let node = first + i;
                *h = matrix3(&constrained_inverse(system.matrix.diagonal(node), &system.constraints[node])) * r[node];
                sum += r[node].dot(h);
            }
            sum
        })
    }
}
