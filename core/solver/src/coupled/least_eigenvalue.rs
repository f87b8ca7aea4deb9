//! The least eigenvalue of the Jacobi-scaled matrix G, by Lanczos iteration.

use crate::lanczos::Tridiagonal;

/// Most products with the matrix, and how many are done from one estimate to the next.
const MOST: usize = 80;
const BETWEEN: usize = 10;
/// The last estimate is good enough if it is less than this below the one before, relative to it.
const GAIN: f64 = 0.03;

/// The least eigenvalue of `D^-1/2 A D^-1/2` for a positive matrix A with the diagonal D and `entries` off it, by row and column. The estimate is
/// never below the eigenvalue, and the closer to it the more `start` has of its eigenvector. Rows whose diagonal is zero are left out; `None` if there are
/// no others, or if `start` is zero.
pub fn least_eigenvalue(diagonal: &[f64], entries: &[(u32, u32, f64)], start: Vec<f64>) -> Option<f64> {
    // D^-1 A has the same eigenvalues, and is self-adjoint in the scalar product of D.
    let inverse: Vec<f64> = diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d } else { 0.0 }).collect();
    let product = |x: &[f64], y: &mut [f64]| {
        for ((y, x), inverse) in y.iter_mut().zip(x).zip(&inverse) {
            *y = if *inverse > 0.0 { *x } else { 0.0 };
        }
        for &(i, j, v) in entries {
            y[i as usize] += v * inverse[i as usize] * x[j as usize];
        }
    };
    let mut last: Option<f64> = None;
    let done = |projection: &Tridiagonal| {
        if !projection.products().is_multiple_of(BETWEEN) {
            return false;
        }
        let found = projection.least();
        let settled = last.zip(found).is_some_and(|(before, now)| now > (1.0 - GAIN) * before);
        last = found;
        settled || projection.products() >= MOST
    };
    Tridiagonal::project(diagonal, start, product, done).least()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_chain_and_of_one_weak_pair_in_it() {
        // 2 and -1 beside it: 1 - cos(pi / (n + 1)) over the diagonal; the diagonal itself rises, and one row has none.
        let n = 60_usize;
        let diagonal: Vec<f64> = (0..=n).map(|i| if i < n { 1.0 + i as f64 } else { 0.0 }).collect();
        let beside = |i: usize, j: usize, c: f64| (i as u32, j as u32, c * (diagonal[i] * diagonal[j]).sqrt());
        let chain = |weak: f64| -> Vec<(u32, u32, f64)> {
            let value = |i: usize| if i == 30 { weak } else { -0.1 };
            (0..n - 1).flat_map(|i| [beside(i, i + 1, value(i)), beside(i + 1, i, value(i))]).collect()
        };
        let start = |only: Option<usize>| -> Vec<f64> {
            (0..=n).map(|i| if only.is_none_or(|o| i.abs_diff(o) < 2) { (1.7 * i as f64).sin() } else { 0.0 }).collect()
        };
        let want = 1.0 - 0.2 * (std::f64::consts::PI / (n + 1) as f64).cos();
        let got = least_eigenvalue(&diagonal, &chain(-0.1), start(None)).unwrap();
        assert!((0.0..0.01).contains(&(got - want)), "{got} {want}");
        // The pair alone has 1 - 0.9, and what is beside it takes a little more.
        let got = least_eigenvalue(&diagonal, &chain(-0.9), start(Some(30))).unwrap();
        assert!((0.08..0.1).contains(&got), "{got}");
        assert_eq!(least_eigenvalue(&[0.0; 3], &[], vec![1.0; 3]), None);
        assert_eq!(least_eigenvalue(&[4.0], &[], vec![1.0]), Some(1.0));
    }
}
