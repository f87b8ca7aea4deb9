//! A tetrahedron with linear shape functions: one constant deformation gradient.

use crate::energy::EnergyHessian;
use crate::matrix::{Mat3, Vec3, apply, cofactors, determinant, product, product_transposed, transposed};
use pliant_plugin_api::Elements;
use pliant_plugin_api::lanes::Real;

/// Doubles of rest data per element: the shape function gradients of the last three corners (1/m), then the volume (m^3).
pub(crate) const STRIDE: usize = 10;

/// The rest shape of a tetrahedron.
pub(crate) struct Tetrahedron<T = f64> {
    /// Gradient of each corner's shape function, 1/m.
    pub(crate) gradient: [Vec3<T>; 4],
    /// Volume at rest that belongs to the body, m^3, times the factor of Young's modulus.
    pub(crate) volume: T,
}

impl Tetrahedron {
    /// From the rest positions of its corners, m, and the share of it that belongs to the body; `None` where the volume is not
    /// positive.
    pub(crate) fn new(x: [Vec3; 4], share: f64) -> Option<Self> {
        let edges = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
        let six_volumes = determinant(&edges);
        if !(six_volumes.is_finite() && six_volumes > 0.0 && share > 0.0) {
            return None;
        }
        // With edges as rows, the columns of the inverse are the gradients: rows of the cofactors over the determinant.
        let gradients = cofactors(&edges).map(|row| Vec3(row.0.map(|c| c / six_volumes)));
        Some(Self::from_gradients(gradients, share * six_volumes / 6.0))
    }

    /// Its rest data.
    pub(crate) fn rest_data(&self) -> [f64; STRIDE] {
        let g = &self.gradient;
        std::array::from_fn(|s| if s < 9 { g[1 + s / 3][s % 3] } else { self.volume })
    }

    /// Element `e` from the planes of rest data.
    #[inline(always)]
    pub(crate) fn from_rest_data(planes: &[&[f64]; STRIDE], e: usize) -> Self {
        let value = |s: usize| planes[s][e];
        let gradients = [0, 3, 6].map(|s| Vec3([value(s), value(s + 1), value(s + 2)]));
        Self::from_gradients(gradients, value(9))
    }
}

impl<T: Real> Tetrahedron<T> {
    /// From the shape function gradients of the last three corners, 1/m, and the volume, m^3.
    #[inline(always)]
    pub(crate) fn from_gradients([b, c, d]: [Vec3<T>; 3], volume: T) -> Self {
        Self { gradient: [-(b + c + d), b, c, d], volume }
    }

    /// The shape with the gradients by which positions give the elastic deformation gradient `Fe = F Fp^-1`, for the inverse of Fp. Its
    /// volume is the same, for flow keeps it.
    #[inline(always)]
    pub(crate) fn after_flow(&self, inverse: &Mat3<T>) -> Self {
        let (columns, g) = (transposed(inverse), &self.gradient);
        Self::from_gradients([apply(&columns, g[1]), apply(&columns, g[2]), apply(&columns, g[3])], self.volume)
    }

    /// `sum_a p_a gradient_a^T`: the deformation gradient F from positions, or its rate from velocities.
    #[inline(always)]
    pub(crate) fn deformation_gradient(&self, p: [Vec3<T>; 4]) -> Mat3<T> {
        let mut out = [p[0]; 3];
        for i in 0..3 {
            let (a, b, c) = (p[1][i] - p[0][i], p[2][i] - p[0][i], p[3][i] - p[0][i]);
            for j in 0..3 {
                out[i][j] = a * self.gradient[1][j] + b * self.gradient[2][j] + c * self.gradient[3][j];
            }
        }
        out
    }

    /// Force on each corner, N, of a first Piola-Kirchhoff stress, Pa.
    #[inline(always)]
    pub(crate) fn forces(&self, stress: &Mat3<T>) -> [Vec3<T>; 4] {
        let mut forces = self.gradient;
        for corner in 0..4 {
            forces[corner] = apply(stress, self.gradient[corner]) * -self.volume;
        }
        forces
    }
}

/// The stiffness blocks of an element.
pub(crate) struct Stiffness<T> {
    hessian: EnergyHessian<T>,
    /// Shape function gradients in the frame of the principal stretches, 1/m.
    gradient: [Vec3<T>; 4],
    /// Volume times the factor of the stiffness, m^3.
    volume: T,
}

impl<T: Real> Stiffness<T> {
    /// Of `factor` times the Hessian of the energy density.
    #[inline(always)]
    pub(crate) fn new(shape: &Tetrahedron<T>, factor: f64, hessian: EnergyHessian<T>) -> Self {
        let (columns, mut gradient) = (transposed(&hessian.v), shape.gradient);
        for corner in 0..4 {
            gradient[corner] = apply(&columns, shape.gradient[corner]);
        }
        Self { hessian, gradient, volume: shape.volume * factor }
    }

    /// Block of corners a and b, N/m.
    #[inline(always)]
    pub(crate) fn block(&self, a: usize, b: usize) -> Mat3<T> {
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

/// Coefficients of a viscosity that acts on the rate of Green's strain, Pa s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ViscosityCoefficients {
    pub(crate) shear: f64,
    pub(crate) dilatation: f64,
}

/// The damping blocks of an element.
pub(crate) struct Damping<T> {
    /// `F F^T`
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
    pub(crate) fn new(shape: &Tetrahedron<T>, f: &Mat3<T>, viscosity: ViscosityCoefficients) -> Self {
        let (gradient, mut f_gradient) = (shape.gradient, shape.gradient);
        for corner in 0..4 {
            f_gradient[corner] = apply(f, gradient[corner]);
        }
        let (shear, dilatation) = (shape.volume * viscosity.shear, shape.volume * viscosity.dilatation);
        Self { f_ft: product_transposed(f, f), f_gradient, gradient, shear, dilatation }
    }

    /// Adds the block of corners a and b, N s/m.
    #[inline(always)]
    pub(crate) fn add_block(&self, a: usize, b: usize, sum: &mut Mat3<T>) {
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
pub(crate) fn add_viscous_stress<T: Real>(
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

/// Vectors at the corners of an element.
#[inline(always)]
pub(crate) fn at_corners(nodes: [u32; 4], vectors: &[[f64; 3]]) -> [Vec3; 4] {
    nodes.map(|n| Vec3(vectors[n as usize]))
}

/// Planes of rest data of a call.
pub(crate) fn rest_planes<'a>(elements: &Elements<'a>) -> [&'a [f64]; STRIDE] {
    std::array::from_fn(|s| elements.rest_data(s))
}
