//! The second derivative of an isotropic energy density in the frames of the principal stretches, and the stiffness blocks it gives.

use super::matrix::{Mat3, apply, determinant, product, product_transposed, transposed};
use super::svd::{Eigen, Svd, symmetric_eigen};
use super::tetrahedron::Tetrahedron;
use crate::lanes::{Real, Vec3};

/// The second derivative of the energy density by F, in the frames of the principal stretches: `F = U diag(s) V^T`.
///
/// For entries of `U^T dF V`, it couples the diagonal ones to each other, and each off-diagonal one to itself and its mirror image.
pub struct EnergyHessian<T> {
    /// Left frame, U.
    pub u: Mat3<T>,
    /// Right frame, V.
    pub v: Mat3<T>,
    /// Coupling of the diagonal entries (i, i) and (j, j), Pa.
    pub stretch: Mat3<T>,
    /// Diagonal coefficient of the off-diagonal entry (i, j), Pa; unused for i = j.
    pub shear_own: Mat3<T>,
    /// Coupling of the off-diagonal entries (i, j) and (j, i), Pa; unused for i = j.
    pub shear_cross: Mat3<T>,
}

/// Second derivatives of an isotropic energy density in its principal stretches s, Pa.
#[derive(Clone, Copy, Debug)]
pub struct PrincipalModes<T> {
    /// `d2psi/ds_i ds_j` for stretches i and j.
    pub stretch: Mat3<T>,
    /// `(psi_i - psi_j) / (s_i - s_j)` for the two axes other than k, with `psi_i = dpsi/ds_i`; a polynomial needs no division.
    pub symmetric: Vec3<T>,
    /// `(psi_i + psi_j) / (s_i + s_j)` for the two axes other than k.
    pub antisymmetric: Vec3<T>,
}

impl<T: Real> EnergyHessian<T> {
    /// The Hessian at `F = u diag(s) v^T` with these modes (Smith, de Goes and Kim 2019), made positive semi-definite if `project`.
    #[inline(always)]
    pub fn new(svd: &Svd<T>, modes: PrincipalModes<T>, project: bool) -> Self {
        let zero = svd.s[0].splat(0.0);
        let zeros = [Vec3([zero; 3]); 3];
        let (mut stretch, mut shear_own, mut shear_cross) = (modes.stretch, zeros, zeros);
        for i in 0..3 {
            for j in 0..3 {
                if i == j {
                    continue;
                }
                let (mut symmetric, mut antisymmetric) = (modes.symmetric[3 - i - j], modes.antisymmetric[3 - i - j]);
                if project {
                    (symmetric, antisymmetric) = (zero.max(symmetric), zero.max(antisymmetric));
                }
                shear_own[i][j] = (symmetric + antisymmetric) * 0.5;
                shear_cross[i][j] = (symmetric - antisymmetric) * 0.5;
            }
        }
        if project {
            stretch = positive_part(stretch);
        }
        Self { u: svd.u, v: svd.v, stretch, shear_own, shear_cross }
    }
}

/// The nearest positive semi-definite matrix to a symmetric one: negative eigenvalues become zero.
#[inline(always)]
fn positive_part<T: Real>(a: Mat3<T>) -> Mat3<T> {
    let (zero, least) = (a[0][0].splat(0.0), a[0][0].min_positive());
    // Sylvester's criterion: the matrix is positive definite if its leading minors are positive. NaN counts as positive here, so that it
    // stays.
    let (first, second, third) = (a[0][0], a[0][0] * a[1][1] - a[0][1] * a[0][1], determinant(&a));
    let is_definite = first.if_less(least, zero, second.if_less(least, zero, third));
    if !is_definite.any_below(f64::MIN_POSITIVE) {
        return a;
    }
    let Eigen { values, vectors: v } = symmetric_eigen(a);
    let w = [values[0].max(zero), values[1].max(zero), values[2].max(zero)];
    let mut out = a;
    for i in 0..3 {
        for j in 0..3 {
            let (p, q) = (v[i], v[j]);
            let projected = w[0] * p[0] * q[0] + w[1] * p[1] * q[1] + w[2] * p[2] * q[2];
            // Definite lanes keep their matrix, so that they do not depend on their neighbours.
            out[i][j] = is_definite.if_less(least, projected, a[i][j]);
        }
    }
    out
}

/// The stiffness matrix of a tetrahedron, computed block by block.
pub struct Stiffness<T> {
    /// Second derivative of the energy density, Pa.
    hessian: EnergyHessian<T>,
    /// Shape function gradients in the frame of the principal stretches, 1/m.
    gradient: [Vec3<T>; 4],
    /// Volume times the factor of the stiffness, m^3.
    volume: T,
}

impl<T: Real> Stiffness<T> {
    /// The stiffness of a tetrahedron whose energy density has `factor` times this Hessian.
    #[inline(always)]
    pub fn new(shape: &Tetrahedron<T>, factor: f64, hessian: EnergyHessian<T>) -> Self {
        let (columns, mut gradient) = (transposed(&hessian.v), shape.gradient);
        for corner in 0..4 {
            gradient[corner] = apply(&columns, shape.gradient[corner]);
        }
        Self { hessian, gradient, volume: shape.volume * factor }
    }

    /// Block of corners a and b, N/m.
    #[inline(always)]
    pub fn block(&self, a: usize, b: usize) -> Mat3<T> {
        let (h, a, b) = (&self.hessian, self.gradient[a], self.gradient[b]);
        let mut k = h.stretch;
        for i in 0..3 {
            k[i][i] = h.stretch[i][i] * a[i] * b[i];
            for j in 0..3 {
                if i != j {
                    k[i][j] = h.stretch[i][j] * a[i] * b[j] + h.shear_cross[i][j] * a[j] * b[i];
                    k[i][i] = k[i][i] + h.shear_own[i][j] * a[j] * b[j];
                }
            }
        }
        for row in &mut k {
            *row = *row * self.volume;
        }
        product(&h.u, &product_transposed(&k, &h.u))
    }
}
