//! The least eigenvalue of a symmetric matrix, from what the matrix makes of a few vectors (Lanczos 1950).

use nalgebra::DMatrix;

/// Vectors at most, and how many are added between two looks.
const MOST: usize = 80;
const BETWEEN: usize = 10;
/// Of what was found at the last look: if less than this was gained since, that is it.
const GAIN: f64 = 0.03;

/// Of a positive matrix with this diagonal and `entries` beside it by row and column, rows and columns over the roots of the
/// diagonal. What is found is never below it, and the nearer the more of its eigenvector is in `start`. Rows without a diagonal are as if
/// they were not there; `None` if there are no others, or nothing starts.
pub fn least_eigenvalue(diagonal: &[f64], entries: &[(u32, u32, f64)], start: Vec<f64>) -> Option<f64> {
    // In the scalar product of the diagonal, rows over their diagonal are symmetric too, and have the same eigenvalues.
    let over: Vec<f64> = diagonal.iter().map(|d| if *d > 0.0 { 1.0 / d } else { 0.0 }).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).zip(diagonal).map(|((a, b), d)| a * b * d).sum::<f64>();
    let (mut last, mut next, mut product) = (vec![0.0; start.len()], start, vec![0.0; diagonal.len()]);
    let (mut along, mut across): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
    let mut least: Option<f64> = None;
    while along.len() < MOST {
        let size = dot(&next, &next).sqrt();
        if !(size > 1e-12 && size.is_finite()) {
            // What was reached so far is all that can be.
            return least_of(&along, &across);
        }
        next.iter_mut().for_each(|c| *c /= size);
        if !along.is_empty() {
            across.push(size);
        }
        for ((product, next), over) in product.iter_mut().zip(&next).zip(&over) {
            *product = if *over > 0.0 { *next } else { 0.0 };
        }
        for &(i, j, v) in entries {
            product[i as usize] += v * over[i as usize] * next[j as usize];
        }
        let own = dot(&next, &product);
        along.push(own);
        let back = across.last().copied().unwrap_or(0.0);
        for ((product, next), last) in product.iter_mut().zip(&next).zip(&last) {
            *product -= own * next + back * last;
        }
        (last, next, product) = (next, product, last);
        if along.len().is_multiple_of(BETWEEN) {
            let found = least_of(&along, &across);
            if least.zip(found).is_some_and(|(before, now)| now > (1.0 - GAIN) * before) {
                return found;
            }
            least = found;
        }
    }
    least
}

/// Of a matrix with three diagonals.
fn least_of(along: &[f64], across: &[f64]) -> Option<f64> {
    let mut matrix = DMatrix::from_diagonal(&along.to_vec().into());
    for (i, &c) in across.iter().take(along.len().saturating_sub(1)).enumerate() {
        (matrix[(i, i + 1)], matrix[(i + 1, i)]) = (c, c);
    }
    (!along.is_empty()).then(|| matrix.symmetric_eigenvalues().min())
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
