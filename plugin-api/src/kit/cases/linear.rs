//! Dense matrices of test bodies.

/// Whether a symmetric matrix (n x n, row-major) with `shift` on its diagonal is positive definite (Cholesky 1910).
pub(super) fn is_definite(a: &[f64], n: usize, shift: f64) -> bool {
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

/// Largest entry without its sign.
pub(super) fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |m: f64, v| m.max(v.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn definite_or_not() {
        assert!(is_definite(&[2.0, 1.0, 1.0, 2.0], 2, 0.0));
        assert!(!is_definite(&[1.0, 2.0, 2.0, 1.0], 2, 0.0));
        assert!(!is_definite(&[1.0, 1.0, 1.0, 1.0], 2, -1e-6) && is_definite(&[1.0, 1.0, 1.0, 1.0], 2, 1e-6));
    }
}
