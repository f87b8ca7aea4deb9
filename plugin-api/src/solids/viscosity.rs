//! A viscosity that acts on the rate of Green's strain, so it does not resist rotation.

use super::matrix::{Mat3, apply, product, product_transposed, transposed};
use super::tetrahedron::Tetrahedron;
use crate::lanes::{Real, Vec3};

/// Coefficients of a viscosity that acts on the rate of Green's strain, Pa s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViscosityCoefficients {
    /// Coefficient of the rate of shear, Pa s.
    pub shear: f64,
    /// Coefficient of the rate of volume, Pa s.
    pub dilatation: f64,
}

/// The damping blocks of an element.
pub struct Damping<T> {
    /// Left Cauchy-Green tensor, `F F^T`.
    f_ft: Mat3<T>,
    /// F times the shape function gradients, 1/m.
    f_gradient: [Vec3<T>; 4],
    /// Shape function gradients, 1/m.
    gradient: [Vec3<T>; 4],
    /// Coefficients times the volume, Pa s m^3.
    shear: T,
    dilatation: T,
}

impl<T: Real> Damping<T> {
    /// The damping blocks at the deformation gradient `f`.
    #[inline(always)]
    pub fn new(shape: &Tetrahedron<T>, f: &Mat3<T>, viscosity: ViscosityCoefficients) -> Self {
        let (gradient, mut f_gradient) = (shape.gradient, shape.gradient);
        for corner in 0..4 {
            f_gradient[corner] = apply(f, gradient[corner]);
        }
        let (shear, dilatation) = (shape.volume * viscosity.shear, shape.volume * viscosity.dilatation);
        Self { f_ft: product_transposed(f, f), f_gradient, gradient, shear, dilatation }
    }

    /// Adds the block of corners a and b, N s/m.
    #[inline(always)]
    pub fn add_block(&self, a: usize, b: usize, sum: &mut Mat3<T>) {
        let (p, q) = (self.f_gradient[a], self.f_gradient[b]);
        let gradients = self.gradient[a].dot(self.gradient[b]);
        for i in 0..3 {
            for j in 0..3 {
                let shear = self.f_ft[i][j] * gradients + q[i] * p[j];
                sum[i][j] = sum[i][j] + self.shear * shear + self.dilatation * p[i] * q[j];
            }
        }
    }
}

/// Adds the viscous first Piola-Kirchhoff stress, Pa: `F (2 eta E' + zeta tr(E') I)`, with E' the rate of Green's strain and eta, zeta the
/// coefficients of shear and dilatation.
#[inline(always)]
pub fn add_viscous_stress<T: Real>(
    f: &Mat3<T>,
    f_rate: &Mat3<T>,
    viscosity: ViscosityCoefficients,
    stress: &mut Mat3<T>,
) {
    let (columns, rates) = (transposed(f), transposed(f_rate));
    let mut strain = *f;
    for i in 0..3 {
        for j in 0..3 {
            strain[i][j] = (columns[i].dot(rates[j]) + rates[i].dot(columns[j])) * 0.5;
        }
    }
    let pressure = (strain[0][0] + strain[1][1] + strain[2][2]) * viscosity.dilatation;
    for i in 0..3 {
        for j in 0..3 {
            strain[i][j] = strain[i][j] * (2.0 * viscosity.shear);
        }
        strain[i][i] = strain[i][i] + pressure;
    }
    let viscous = product(f, &strain);
    for i in 0..3 {
        stress[i] = stress[i] + viscous[i];
    }
}
