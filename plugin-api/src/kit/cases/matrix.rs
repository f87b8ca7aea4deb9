//! Dense matrices of test bodies, n x n, row-major.

/// Whether a symmetric matrix with `shift` added to its diagonal is positive definite (Cholesky 1910).
pub(super) fn is_positive_definite(a: &[f64], n: usize, shift: f64) -> bool {
    let mut l = a.to_vec();
    for j in 0..n {
        let pivot = l[j * n + j] + shift - (0..j).map(|k| l[j * n + k] * l[j * n + k]).sum::<f64>();
        if !(pivot.is_finite() && pivot > 0.0) {
            return false;
        }
        let root = pivot.sqrt();
        l[j * n + j] = root;
        for i in j + 1..n {
            let sum: f64 = (0..j).map(|k| l[i * n + k] * l[j * n + k]).sum();
            l[i * n + j] = (l[i * n + j] - sum) / root;
        }
    }
    true
}

/// Whether a matrix is symmetric, to 1e-9 of its largest entry.
pub(super) fn is_symmetric(a: &[f64], n: usize) -> bool {
    let tolerance = 1e-9 * max_abs(a);
    (0..n * n).all(|i| (a[i] - a[i % n * n + i / n]).abs() <= tolerance)
}

/// Largest absolute value; 0 of no values.
pub(super) fn max_abs<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |max: f64, v| max.max(v.abs()))
}

/// Largest difference of two matrices, relative to the largest entry of the first.
pub(super) fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |max: f64, (a, b)| max.max((a - b).abs())) / max_abs(a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positive_definite_and_indefinite_matrices() {
        assert!(is_positive_definite(&[2.0, 1.0, 1.0, 2.0], 2, 0.0));
        assert!(!is_positive_definite(&[1.0, 2.0, 2.0, 1.0], 2, 0.0));
        let singular = [1.0, 1.0, 1.0, 1.0];
        assert!(!is_positive_definite(&singular, 2, -1e-6) && is_positive_definite(&singular, 2, 1e-6));
        assert!(is_symmetric(&[1.0, 2.0, 2.0, 3.0], 2) && !is_symmetric(&[1.0, 2.0, 2.1, 3.0], 2));
    }
}
