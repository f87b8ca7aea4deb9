//! Conjugate gradients in double precision, for systems that single precision ([`super::inner`]) has no room for.
//!
//! Triangles that have collapsed have hinges some 1e12 times as stiff as the rest. Such a step is rare: blocks are inverted
//! where they are used, and there are no levels.

use super::solve::{Solve, SolveReport};
use crate::algebra::{Vec3, matrix3};
use crate::constraint::constrained_inverse;
use crate::threads::Pool;

/// Vectors of a solve.
#[derive(Debug, Default)]
pub struct Double {
    p: Vec<Vec3>,
    s: Vec<Vec3>,
    h: Vec<Vec3>,
}

impl Double {
    /// Room for `n` nodes.
    pub fn resize(&mut self, n: usize) {
        for field in [&mut self.p, &mut self.s, &mut self.h] {
            field.clear();
            field.resize(n, Vec3::zeros());
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        3 * self.p.len() * size_of::<Vec3>()
    }

    /// Solves from `x`, or from nothing if it is not finite; `r` is the residual. What is below `floor` counts as none.
    pub fn solve(
        &mut self,
        pool: &Pool,
        system: &Solve<'_>,
        (x, r): (&mut [Vec3], &mut [Vec3]),
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
        let enough = (system.tolerance * system.tolerance * scale).max(floor);
        let mut report = SolveReport::default();
        while d > enough && report.iterations < system.most {
            let q = self.apply(pool, system);
            if !(q > 0.0 && q.is_finite()) {
                report.broken = true;
                break;
            }
            for i in 0..x.len() {
                x[i] += d / q * self.p[i];
                r[i] -= d / q * self.s[i];
            }
            let next = self.weigh(pool, system, r);
            for (p, h) in self.p.iter_mut().zip(&self.h) {
                *p = *h + next / d * *p;
            }
            d = next;
            report.iterations += 1;
        }
        report.close(d, scale, (enough, floor));
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
                sum + p.dot(s)
            })
        })
    }

    /// `r = S (b - A p)`, `h = P r`; gives `r.h`.
    fn start(&mut self, pool: &Pool, system: &Solve<'_>, r: &mut [Vec3]) -> f64 {
        self.apply(pool, system);
        for i in 0..r.len() {
            r[i] = system.constraints[i].filter(system.b[i]) - self.s[i];
        }
        self.weigh(pool, system, r)
    }

    /// `h = P r`; gives `r.h`.
    fn weigh(&mut self, pool: &Pool, system: &Solve<'_>, r: &[Vec3]) -> f64 {
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
