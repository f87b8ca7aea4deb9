//! A solution before its solve has converged, with bounds of its error.

use super::filtered_system::FilteredSystem;
use crate::algebra::{Vec3, matrix3};
use crate::f32_matrix::F32Matrix;
use crate::matrix::Matrix;
use crate::system::System;

/// The solution of a solve that has not converged yet.
pub struct PartialSolution<'a> {
    system: &'a FilteredSystem<'a>,
    /// The solution before the present correction.
    x: &'a [Vec3],
    /// Holds the present correction.
    correction: &'a F32Matrix,
    /// Factor from the correction to the solution.
    scale: f64,
    /// `r . P r`.
    d: f64,
}

impl<'a> PartialSolution<'a> {
    pub(super) fn new(
        system: &'a FilteredSystem<'a>,
        x: &'a [Vec3],
        correction: &'a F32Matrix,
        scale: f64,
        d: f64,
    ) -> Self {
        Self { system, x, correction, scale, d }
    }

    /// The solution x at a node.
    pub fn at(&self, i: usize) -> Vec3 {
        let mut x = [self.x[i]];
        self.correction.add_to(i, self.scale, &mut x);
        x[0]
    }

    /// `A x - b` at a node: g times the constraint force on it.
    pub fn reaction(&self, i: usize) -> Vec3 {
        self.system.matrix.row_of(i, |j| self.at(j)) - self.system.b[i]
    }

    /// `r . P r` of the residual r.
    pub fn residual_squared(&self) -> f64 {
        self.d
    }
}

/// Returns a function that bounds the error e of a partial solution, from `d = r . P r`, which estimates `e . A e`. For a node i and a unit
/// vector u it returns the bound of the constraint force along u, N, by `(u . A_i e)^2 <= (u . A_ii u) (e . A e)` (Cauchy-Schwarz), and the bound of
/// the velocity, m/s, by `A >= M`. `g` is the effective step size, s.
pub fn error_bound(matrix: &Matrix, d: f64, g: f64) -> impl Fn(&System, usize, Vec3) -> [f64; 2] {
    move |system, i, u| {
        let force = (u.dot(&(matrix3(matrix.diagonal(i)) * u)) * d).sqrt() / g;
        [force, (d / system.nodes.mass[i]).sqrt()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraint::Constraint;
    use crate::solver::Pcg;
    use crate::threads::Pool;

    const N: usize = 40;

    fn wave(i: usize) -> f64 {
        (1.7 * i as f64).sin()
    }

    /// A square net of masses and springs, stiff in its plane and soft perpendicular to it.
    fn net() -> Matrix {
        let mut matrix = Matrix::default();
        let pairs = (0..N * N).flat_map(|i| {
            let right = (i % N + 1 < N).then_some((i, i + 1));
            right.into_iter().chain((i + N < N * N).then_some((i, i + N)))
        });
        let pairs: Vec<_> = pairs.map(|(i, j)| (i as u32, j as u32)).collect();
        matrix.set_pattern(N * N, |join| pairs.iter().for_each(|(i, j)| join(*i, *j)));
        (0..N * N).for_each(|i| *matrix.diagonal_mut(i) = [1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.0, 1e-3]);
        for (i, j) in pairs {
            let k = [3e-2, 4e-3, 0.0, 4e-3, 2e-2, 0.0, 0.0, 0.0, 3e-3];
            for (slot, sign) in [
                (matrix.diagonal_slot(i as usize), 1.0),
                (matrix.diagonal_slot(j as usize), 1.0),
                (matrix.slot(i, j), -1.0),
            ] {
                matrix.values_mut()[slot].iter_mut().zip(k).for_each(|(to, k)| *to += sign * k);
            }
        }
        matrix
    }

    struct Case {
        matrix: Matrix,
        b: Vec<Vec3>,
        z: Vec<Vec3>,
        constraints: Vec<Constraint>,
        x: Vec<Vec3>,
    }

    impl Case {
        fn new() -> Self {
            let (mut constraints, mut z) = (vec![Constraint::Free; N * N], vec![Vec3::zeros(); N * N]);
            for i in [815, 816, 855, 856] {
                constraints[i] = if i == 855 { Constraint::Plane(Vec3::new(0.6, 0.0, 0.8)) } else { Constraint::Fixed };
                z[i] = Vec3::new(0.12, 0.0, 0.16);
            }
            (0..N).for_each(|i| constraints[i] = Constraint::Fixed);
            let b =
                (0..N * N).map(|i| Vec3::new(1e-5 * wave(i), 2e-5 * wave(i / 7), 1e-4 + 1e-5 * wave(3 * i))).collect();
            Self { matrix: net(), b, z, constraints, x: vec![Vec3::zeros(); N * N] }
        }

        fn solve(&self, tolerance: f64, same_matrix: bool) -> FilteredSystem<'_> {
            let Self { matrix, b, z, constraints, x } = self;
            FilteredSystem {
                matrix,
                b,
                z,
                constraints,
                positions: x,
                displacement_per_unit: 1e-3,
                same_matrix,
                tolerance,
                max_iterations: 1000,
                interrupts: None,
            }
        }

        fn pcg(&self, pool: &Pool, x: impl Fn(usize) -> Vec3) -> Pcg {
            let mut pcg = Pcg::default();
            pcg.resize(N * N);
            pcg.guess(pool, &self.matrix, None);
            pcg.x.iter_mut().enumerate().for_each(|(i, to)| *to = x(i));
            pcg.load(pool, &self.matrix, None);
            pcg
        }
    }

    #[test]
    fn reactions_stay_within_their_error_bound() {
        let (case, pool) = (Case::new(), Pool::new(1));
        let mut pcg = case.pcg(&pool, |_| Vec3::zeros());
        let mut samples = Vec::new();
        let directions = [Vec3::x(), Vec3::y(), Vec3::new(0.6, 0.0, 0.8)];
        let report = pcg.solve_until(&pool, &case.solve(1e-7, false), &mut |partial| {
            for (i, u) in [815, 816, 855, 856].into_iter().flat_map(|i| directions.map(|u| (i, u))) {
                let bound = (u.dot(&(matrix3(case.matrix.diagonal(i)) * u)) * partial.residual_squared()).sqrt();
                samples.push((i, u, partial.reaction(i), bound));
            }
            false
        });
        assert!(report.converged && report.stopped_at.is_none(), "{report:?}");
        let mut largest = 0.0_f64;
        for (i, u, early, bound) in &samples {
            let end = case.matrix.row_product(*i, &pcg.x) - case.b[*i];
            largest = largest.max((end - *early).dot(u).abs() / bound);
        }
        assert!(
            samples.len() > 60 && largest > 0.01 && largest < 0.9,
            "{largest} of the bound, {} looks",
            samples.len()
        );
    }

    #[test]
    fn a_stopped_solve_can_be_continued() {
        let (case, pool) = (Case::new(), Pool::new(1));
        let (mut pcg, mut whole) = (case.pcg(&pool, |_| Vec3::zeros()), case.pcg(&pool, |_| Vec3::zeros()));
        let all = whole.solve(&pool, &case.solve(1e-6, false));
        let mut tests = 0;
        let report = pcg.solve_until(&pool, &case.solve(1e-6, false), &mut |_| {
            tests += 1;
            tests > 3
        });
        assert!(report.stopped_at.is_some() && !report.converged && report.iterations < all.iterations, "{report:?}");
        let rest = pcg.solve(&pool, &case.solve(1e-6, true));
        assert!(rest.converged && rest.iterations < all.iterations, "{rest:?} {all:?}");
        assert!(pcg.x.iter().zip(&whole.x).all(|(a, b)| (a - b).norm() < 1e-6));
    }

    #[test]
    fn a_changed_active_set_is_solved_from_the_last_solution() {
        let (mut case, pool) = (Case::new(), Pool::new(1));
        let mut pcg = case.pcg(&pool, |_| Vec3::zeros());
        assert!(pcg.solve(&pool, &case.solve(1e-6, false)).converged);
        (case.constraints[815], case.constraints[855]) = (Constraint::Free, Constraint::Line(Vec3::new(0.6, 0.0, 0.8)));
        (case.constraints[700], case.z[700]) = (Constraint::Fixed, Vec3::new(0.1, 0.0, 0.0));
        let mut fresh = case.pcg(&pool, |i| pcg.x[i]);
        let expected = fresh.solve(&pool, &case.solve(1e-6, false));
        let again = pcg.solve(&pool, &case.solve(1e-6, true));
        assert!(again.converged && again.iterations <= expected.iterations + 2, "{again:?} {expected:?}");
        assert!(pcg.x.iter().zip(&fresh.x).all(|(a, b)| (a - b).norm() < 1e-5));
        let held: Vec<usize> = pcg.constrained().map(|(i, _)| i).skip_while(|i| *i < N).collect();
        assert_eq!(held, [700, 816, 855, 856]);
        for (i, product) in pcg.constrained() {
            let expected = case.matrix.row_product(i, &pcg.x);
            assert!((product - expected).norm() < 1e-12, "{i}: {product:?} {expected:?}");
        }
    }

    #[test]
    fn a_guess_that_is_worse_than_zero_is_scaled() {
        let (case, pool) = (Case::new(), Pool::new(1));
        let mut pcg = case.pcg(&pool, |_| Vec3::zeros());
        let none = pcg.solve(&pool, &case.solve(1e-4, false));
        let solution = pcg.x.clone();
        // A multiple of the solution helps; an unrelated guess does no harm.
        let long = case.pcg(&pool, |i| -700.0 * solution[i]).solve(&pool, &case.solve(1e-4, false));
        assert!(long.converged && 3 * long.iterations < none.iterations, "{long:?} {none:?}");
        let odd = case.pcg(&pool, |i| Vec3::repeat(40.0 * wave(5 * i))).solve(&pool, &case.solve(1e-4, false));
        assert!(odd.converged && odd.iterations <= none.iterations + none.iterations / 5, "{odd:?} {none:?}");
    }
}
