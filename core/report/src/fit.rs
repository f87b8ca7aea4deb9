//! Numbers drawn from several runs: orders, exponents, the front, medians.

/// The exponent `p` in `error ~ size^p` between two runs; `None` where an error is zero or not finite.
pub fn order(coarse: (f64, f64), fine: (f64, f64)) -> Option<f64> {
    let p = (coarse.1 / fine.1).ln() / (coarse.0 / fine.0).ln();
    (p.is_finite() && coarse.1 > 0.0 && fine.1 > 0.0).then_some(p)
}

/// The exponent `p` in `y ~ x^p` by least squares of the logarithms; `None` of fewer than two points.
pub fn exponent(points: &[(f64, f64)]) -> Option<f64> {
    let logs: Vec<_> = points.iter().filter(|p| p.0 > 0.0 && p.1 > 0.0).map(|p| (p.0.ln(), p.1.ln())).collect();
    let n = logs.len() as f64;
    let mean = logs.iter().fold((0.0, 0.0), |m, p| (m.0 + p.0 / n, m.1 + p.1 / n));
    let top: f64 = logs.iter().map(|p| (p.0 - mean.0) * (p.1 - mean.1)).sum();
    let bottom: f64 = logs.iter().map(|p| (p.0 - mean.0).powi(2)).sum();
    (logs.len() > 1 && bottom > 0.0).then(|| top / bottom)
}

/// Which of (cost, error) no other beats in both (Pareto front).
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    let on = |p: &(f64, f64)| p.1.is_finite() && !points.iter().any(|q| beats(q, p));
    points.iter().map(on).collect()
}

/// The middle one of a list in any order; 0 of an empty one.
pub fn median(values: &[f64]) -> f64 {
    percentile(values, 0.5)
}

/// The value below which `share` of a list lies; 0 of an empty one.
pub fn percentile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().max(1) - 1;
    sorted.get(((sorted.len() as f64 * share) as usize).min(last)).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_and_exponents_are_those_put_in() {
        assert!((order((0.1, 3e-2), (0.05, 7.5e-3)).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(order((0.1, 0.0), (0.05, 0.0)), None);
        let points: Vec<_> = (1..6).map(|i| (f64::from(i), 4.0 * f64::from(i).powf(1.3))).collect();
        assert!((exponent(&points).unwrap() - 1.3).abs() < 1e-12);
        assert_eq!(exponent(&points[..1]), None);
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 1e-1), (2.0, 1e-2), (3.0, 5e-2), (4.0, f64::NAN), (4.0, 1e-3)];
        assert_eq!(front(&points), [true, true, false, false, true]);
    }

    #[test]
    fn percentiles_of_few() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), percentile(&[3.0, 1.0, 2.0], 0.99), median(&[])), (2.0, 3.0, 0.0));
    }
}
