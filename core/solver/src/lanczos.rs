//! Extreme eigenvalues of a self-adjoint operator from its products with a few vectors (Lanczos 1950).

use nalgebra::{DMatrix, SymmetricEigen};

/// Remainder of a product, relative to the largest entry of the diagonal, below which the Krylov space is complete.
const COMPLETE: f64 = 1e-12;

/// The projection of an operator onto a Krylov space: a symmetric tridiagonal matrix.
#[derive(Clone, Debug, Default)]
pub struct Tridiagonal {
    diagonal: Vec<f64>,
    /// Entries beside the diagonal, one fewer than the diagonal has.
    off_diagonal: Vec<f64>,
    /// Norm of what the last product has outside of the Krylov space.
    remainder: f64,
}

/// An eigenvalue of the projection.
#[derive(Clone, Copy, Debug)]
pub struct RitzValue {
    pub value: f64,
    /// The operator has an eigenvalue this near to the value.
    pub distance: f64,
}

impl Tridiagonal {
    /// Projects an operator that is self-adjoint in the scalar product `sum weights[i] a[i] b[i]`, beginning with `start`, until `done` says so or
    /// the Krylov space is complete. `product` writes the operator's product with its first argument to its second.
    pub fn project(
        weights: &[f64],
        start: Vec<f64>,
        mut product: impl FnMut(&[f64], &mut [f64]),
        mut done: impl FnMut(&Self) -> bool,
    ) -> Self {
        let norm = |a: &[f64]| a.iter().zip(weights).map(|(a, w)| a * a * w).sum::<f64>().sqrt();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).zip(weights).map(|((a, b), w)| a * b * w).sum::<f64>();
        let (mut previous, mut next, mut image) = (vec![0.0; start.len()], start, vec![0.0; weights.len()]);
        let mut projection = Self { remainder: norm(&next), ..Self::default() };
        loop {
            let size = projection.remainder;
            let scale = projection.diagonal.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
            if !(size > COMPLETE * scale && size.is_finite()) {
                return projection;
            }
            next.iter_mut().for_each(|c| *c /= size);
            if !projection.diagonal.is_empty() {
                projection.off_diagonal.push(size);
            }
            product(&next, &mut image);
            let own = dot(&next, &image);
            projection.diagonal.push(own);
            let back = projection.off_diagonal.last().copied().unwrap_or(0.0);
            for ((image, next), previous) in image.iter_mut().zip(&next).zip(&previous) {
                *image -= own * next + back * previous;
            }
            projection.remainder = norm(&image);
            (previous, next, image) = (next, image, previous);
            if done(&projection) {
                return projection;
            }
        }
    }

    /// Number of products so far.
    pub fn products(&self) -> usize {
        self.diagonal.len()
    }

    /// The least eigenvalue, never below that of the operator; `None` without products.
    pub fn least(&self) -> Option<f64> {
        (!self.diagonal.is_empty()).then(|| self.matrix().symmetric_eigenvalues().min())
    }

    /// The largest eigenvalue, never above that of the operator; `None` without products.
    pub fn largest(&self) -> Option<RitzValue> {
        if self.diagonal.is_empty() {
            return None;
        }
        let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(self.matrix());
        let (at, value) = eigenvalues.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(RitzValue { value, distance: self.remainder * eigenvectors[(eigenvectors.nrows() - 1, at)].abs() })
    }

    fn matrix(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::from_diagonal(&self.diagonal.clone().into());
        for (i, &c) in self.off_diagonal.iter().enumerate() {
            (matrix[(i, i + 1)], matrix[(i + 1, i)]) = (c, c);
        }
        matrix
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of `n` equal masses and springs between two walls.
    fn chain(stiffness: f64) -> impl Fn(&[f64], &mut [f64]) {
        move |x, y| {
            for i in 0..x.len() {
                let beside = i.checked_sub(1).map_or(0.0, |j| x[j]) + x.get(i + 1).copied().unwrap_or(0.0);
                y[i] = stiffness * (2.0 * x[i] - beside);
            }
        }
    }

    #[test]
    fn eigenvalues_of_a_chain_lie_within_the_distance_stated() {
        for (n, stiffness) in [(1, 1.0), (2, 1e-14), (7, 1e9), (50, 3.0), (400, 1e4)] {
            // 2 - 2 cos(k pi / (n + 1)) times the stiffness over the mass.
            let mass = 0.25;
            let exact =
                |k: usize| stiffness / mass * (2.0 - 2.0 * (k as f64 * std::f64::consts::PI / (n + 1) as f64).cos());
            let start = (0..n).map(|i| (1.7 * i as f64 + 0.3).sin()).collect();
            let product = |x: &[f64], y: &mut [f64]| {
                chain(stiffness)(x, y);
                y.iter_mut().for_each(|y| *y /= mass);
            };
            let found = Tridiagonal::project(&vec![mass; n], start, product, |p| p.products() >= 24);
            assert!(found.products() <= n.min(24), "{n}");
            let (least, largest) = (found.least().unwrap(), found.largest().unwrap());
            let rounding = 1e-12 * exact(n);
            assert!(least >= exact(1) - rounding && largest.value <= exact(n) + rounding, "{n}: {least} {largest:?}");
            let nearest = (1..=n).map(|k| (exact(k) - largest.value).abs()).fold(f64::INFINITY, f64::min);
            assert!(nearest <= largest.distance + rounding, "{n}: {nearest} {largest:?}");
            // A Krylov space of k dimensions has a polynomial that is within (pi / 2k)^2 of the ends of a spectrum without gaps.
            let close = (std::f64::consts::FRAC_PI_2 / found.products() as f64).powi(2);
            assert!(largest.value >= (1.0 - close) * exact(n), "{n}: {largest:?} {}", exact(n));
        }
    }

    #[test]
    fn without_a_start_there_is_nothing() {
        let found = Tridiagonal::project(&[1.0; 3], vec![0.0; 3], chain(1.0), |_| false);
        assert!(found.least().is_none() && found.largest().is_none());
    }
}
