//! What can be told of a solution while it is being found.

use super::solve::Solve;
use crate::algebra::{Vec3, matrix3};
use crate::matrix::Matrix;
use crate::single::Single;
use crate::system::System;

/// A solution on its way, and how far it can be from the end of it.
pub struct Peek<'a> {
    system: &'a Solve<'a>,
    /// Before the correction that is under way.
    x: &'a [Vec3],
    /// How far the correction has come, and its scale.
    correction: (&'a Single, f64),
    /// `r . P r` of what is left.
    d: f64,
}

impl<'a> Peek<'a> {
    pub(super) fn new(system: &'a Solve<'a>, x: &'a [Vec3], correction: (&'a Single, f64), d: f64) -> Self {
        Self { system, x, correction, d }
    }

    /// The solution at a node.
    pub fn at(&self, i: usize) -> Vec3 {
        let mut x = [self.x[i]];
        let (descent, scale) = self.correction;
        descent.add_to(i, scale, &mut x);
        x[0]
    }

    /// `A x - b` at a node: what it takes to hold it.
    pub fn reaction(&self, i: usize) -> Vec3 {
        self.system.matrix.row_of(i, |j| self.at(j)) - self.system.b[i]
    }

    /// `r . P r` of what is left.
    pub fn left(&self) -> f64 {
        self.d
    }
}

/// How far a velocity may be from where it will end up, from `d = r . P r`, the form that `e . A e` has of what is wrong with it, e:
/// N, what it takes to hold a node, along a unit vector u, as `(u . A_i e)^2 <= (u . A_ii u) (e . A e)` (Cauchy and Schwarz); and
/// m/s, the velocity itself, as A is no less than the masses. `g` (s) is by how much a velocity moves positions.
pub fn doubt(matrix: &Matrix, d: f64, g: f64) -> impl Fn(&System, usize, Vec3) -> [f64; 2] {
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

    /// A net of masses joined by springs that are stiff in their plane and soft across it.
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

        fn solve(&self, tolerance: f64, again: bool) -> Solve<'_> {
            let Self { matrix, b, z, constraints, x } = self;
            Solve { matrix, b, z, constraints, motion: (x, 1e-3), again, tolerance, most: 1000 }
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
    fn reactions_end_up_within_the_doubt() {
        let (case, pool) = (Case::new(), Pool::new(1));
        let mut pcg = case.pcg(&pool, |_| Vec3::zeros());
        let mut seen = Vec::new();
        let directions = [Vec3::x(), Vec3::y(), Vec3::new(0.6, 0.0, 0.8)];
        let report = pcg.solve_watched(&pool, &case.solve(1e-7, false), &mut |peek| {
            for (i, u) in [815, 816, 855, 856].into_iter().flat_map(|i| directions.map(|u| (i, u))) {
                let doubt = (u.dot(&(matrix3(case.matrix.diagonal(i)) * u)) * peek.left()).sqrt();
                seen.push((i, u, peek.reaction(i), doubt));
            }
            false
        });
        assert!(report.converged && report.stopped.is_none(), "{report:?}");
        let mut largest = 0.0_f64;
        for (i, u, early, doubt) in &seen {
            let end = case.matrix.row_product(*i, &pcg.x) - case.b[*i];
            largest = largest.max((end - *early).dot(u).abs() / doubt);
        }
        assert!(seen.len() > 60 && largest > 0.01 && largest < 0.9, "{largest} of the doubt, {} looks", seen.len());
    }

    #[test]
    fn a_solve_that_is_stopped_can_be_gone_on_with() {
        let (case, pool) = (Case::new(), Pool::new(1));
        let (mut pcg, mut whole) = (case.pcg(&pool, |_| Vec3::zeros()), case.pcg(&pool, |_| Vec3::zeros()));
        let all = whole.solve(&pool, &case.solve(1e-6, false));
        let mut looks = 0;
        let report = pcg.solve_watched(&pool, &case.solve(1e-6, false), &mut |_| {
            looks += 1;
            looks > 3
        });
        assert!(report.stopped.is_some() && !report.converged && report.iterations < all.iterations, "{report:?}");
        let rest = pcg.solve(&pool, &case.solve(1e-6, true));
        assert!(rest.converged && rest.iterations < all.iterations, "{rest:?} {all:?}");
        assert!(pcg.x.iter().zip(&whole.x).all(|(a, b)| (a - b).norm() < 1e-6));
    }

    #[test]
    fn nodes_that_are_let_go_and_others_that_are_held_are_solved_for_again() {
        let (mut case, pool) = (Case::new(), Pool::new(1));
        let mut pcg = case.pcg(&pool, |_| Vec3::zeros());
        assert!(pcg.solve(&pool, &case.solve(1e-6, false)).converged);
        (case.constraints[815], case.constraints[855]) = (Constraint::Free, Constraint::Line(Vec3::new(0.6, 0.0, 0.8)));
        (case.constraints[700], case.z[700]) = (Constraint::Fixed, Vec3::new(0.1, 0.0, 0.0));
        let mut fresh = case.pcg(&pool, |i| pcg.x[i]);
        let want = fresh.solve(&pool, &case.solve(1e-6, false));
        let again = pcg.solve(&pool, &case.solve(1e-6, true));
        assert!(again.converged && again.iterations <= want.iterations + 2, "{again:?} {want:?}");
        assert!(pcg.x.iter().zip(&fresh.x).all(|(a, b)| (a - b).norm() < 1e-5));
        let held: Vec<usize> = pcg.held().map(|(i, _)| i).skip_while(|i| *i < N).collect();
        assert_eq!(held, [700, 816, 855, 856]);
        for (i, product) in pcg.held() {
            let want = case.matrix.row_product(i, &pcg.x);
            assert!((product - want).norm() < 1e-12, "{i}: {product:?} {want:?}");
        }
    }

    #[test]
    fn a_guess_that_is_worse_than_none_is_made_as_long_as_serves_best() {
        let (case, pool) = (Case::new(), Pool::new(1));
        let mut pcg = case.pcg(&pool, |_| Vec3::zeros());
        let none = pcg.solve(&pool, &case.solve(1e-4, false));
        let solution = pcg.x.clone();
        // Of the right shape it serves at any length; of none it does no harm.
        let long = case.pcg(&pool, |i| -700.0 * solution[i]).solve(&pool, &case.solve(1e-4, false));
        assert!(long.converged && 3 * long.iterations < none.iterations, "{long:?} {none:?}");
        let odd = case.pcg(&pool, |i| Vec3::repeat(40.0 * wave(5 * i))).solve(&pool, &case.solve(1e-4, false));
        assert!(odd.converged && odd.iterations <= none.iterations + none.iterations / 5, "{odd:?} {none:?}");
    }
}
