//! Statistics of several runs: orders of convergence, power laws, Pareto fronts, percentiles.

/// An error and the size of its resolution: a cell, a step, or their inverse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ErrorAt {
    pub(crate) size: f64,
    pub(crate) error: f64,
}

/// The exponent `p` in `error ~ size^p` between two runs; `None` where an error is zero or not finite.
pub(crate) fn order(coarse: ErrorAt, fine: ErrorAt) -> Option<f64> {
    let p = (coarse.error / fine.error).ln() / (coarse.size / fine.size).ln();
    (p.is_finite() && coarse.error > 0.0 && fine.error > 0.0).then_some(p)
}

/// The exponent `p` in `y ~ x^p` of points (x, y), by least squares of the logarithms; `None` with fewer than two points above zero.
pub(crate) fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<_> = points.iter().filter(|p| p.0 > 0.0 && p.1 > 0.0).map(|p| (p.0.ln(), p.1.ln())).collect();
    let n = logs.len() as f64;
    let mean = logs.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let covariance: f64 = logs.iter().map(|p| (p.0 - mean.0) * (p.1 - mean.1)).sum();
    let variance: f64 = logs.iter().map(|p| (p.0 - mean.0).powi(2)).sum();
    (logs.len() > 1 && variance > 0.0).then(|| covariance / variance)
}

/// Whether each point (cost, error) is on the Pareto front: no other is at most as large in both and smaller in one.
pub(crate) fn pareto_front(points: &[(f64, f64)]) -> Vec<bool> {
    let dominates = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    let on_front = |p: &(f64, f64)| p.1.is_finite() && !points.iter().any(|q| dominates(q, p));
    points.iter().map(on_front).collect()
}

/// Median of an unsorted list; 0 for an empty one.
pub(crate) fn median(values: &[f64]) -> f64 {
    percentile(values, 0.5)
}

/// Quantile of an unsorted list for the fraction `share` (0 to 1); 0 for an empty one.
pub(crate) fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().max(1) - 1;
    sorted.get(((sorted.len() as f64 * share) as usize).min(last)).copied().unwrap_or(0.0)
}

/// The range of a list over its median.
pub(crate) fn relative_range(values: &[f64]) -> f64 {
    (percentile(values, 1.0) - percentile(values, 0.0)) / median(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_and_exponents_are_those_put_in() {
        let at = |size, error| ErrorAt { size, error };
        assert!((order(at(0.1, 3e-2), at(0.05, 7.5e-3)).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(order(at(0.1, 0.0), at(0.05, 0.0)), None);
        let points: Vec<_> = (1..6).map(|i| (f64::from(i), 4.0 * f64::from(i).powf(1.3))).collect();
        assert!((exponent(&points).unwrap() - 1.3).abs() < 1e-12);
        assert_eq!(exponent(&points[..1]), None);
    }

    #[test]
    fn the_front_is_what_nothing_dominates() {
        let points = [(1.0, 1e-1), (2.0, 1e-2), (3.0, 5e-2), (4.0, f64::NAN), (4.0, 1e-3)];
        assert_eq!(pareto_front(&points), [true, true, false, false, true]);
    }

    #[test]
    fn percentiles_of_few() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), percentile(&[3.0, 1.0, 2.0], 0.99), median(&[])), (2.0, 3.0, 0.0));
    }
}
