//! A tetrahedron with linear shape functions: one deformation gradient.

use crate::energy::Curvature;
use crate::matrix::{M3, V3, cofactors, determinant, dot, product, product_transposed, times, transposed};
use pliant_plugin_api::Elements;
use pliant_plugin_api::lanes::Real;

/// Values of rest data of an element: the gradients of the last three corners' weights, then its volume.
pub(crate) const STRIDE: usize = 10;

/// The rest shape of one.
pub(crate) struct Tetrahedron<T = f64> {
    /// 1/m, gradient of each corner's weight (4 x 3)
    pub(crate) gradient: [V3<T>; 4],
    /// m^3
    pub(crate) volume: T,
}

impl Tetrahedron {
    /// From the rest places of its corners, m; `None` where it has no volume.
    pub(crate) fn new(x: [[f64; 3]; 4], share: f64) -> Option<Self> {
        let edges = [1, 2, 3].map(|a| [0, 1, 2].map(|i| x[a][i] - x[0][i]));
        let six = determinant(&edges);
        if !(six.is_finite() && six > 0.0 && share > 0.0) {
            return None;
        }
        // Edges as rows: the inverse has the gradients as columns, and its transpose is cofactors over determinant.
        let gradients = cofactors(&edges).map(|row| row.map(|c| c / six));
        Some(Self::whole(gradients, share * six / 6.0))
    }

    /// As values of rest data.
    pub(crate) fn values(&self) -> [f64; STRIDE] {
        let g = &self.gradient;
        std::array::from_fn(|s| if s < 9 { g[1 + s / 3][s % 3] } else { self.volume })
    }

    /// Back from planes of rest data.
    #[inline(always)]
    pub(crate) fn read(planes: &[&[f64]; STRIDE], e: usize) -> Self {
        let at = |s: usize| planes[s][e];
        let gradients = [0, 3, 6].map(|s| [at(s), at(s + 1), at(s + 2)]);
        Self::whole(gradients, at(9))
    }
}

impl<T: Real> Tetrahedron<T> {
    /// From the gradients of the last three corners' weights.
    #[inline(always)]
    pub(crate) fn whole([b, c, d]: M3<T>, volume: T) -> Self {
        let a = [-(b[0] + c[0] + d[0]), -(b[1] + c[1] + d[1]), -(b[2] + c[2] + d[2])];
        Self { gradient: [a, b, c, d], volume }
    }

    /// `sum_a p_a gradient_a^T`: of positions the deformation gradient, of velocities its rate.
    #[inline(always)]
    pub(crate) fn derivative(&self, p: [V3<T>; 4]) -> M3<T> {
        let mut out = [p[0]; 3];
        for i in 0..3 {
            let (a, b, c) = (p[1][i] - p[0][i], p[2][i] - p[0][i], p[3][i] - p[0][i]);
            for j in 0..3 {
                out[i][j] = a * self.gradient[1][j] + b * self.gradient[2][j] + c * self.gradient[3][j];
            }
        }
        out
    }

    /// N, on each corner under a stress, Pa
    #[inline(always)]
    pub(crate) fn forces(&self, stress: &M3<T>) -> [V3<T>; 4] {
        let mut forces = self.gradient;
        for corner in 0..4 {
            let f = times(stress, self.gradient[corner]);
            for i in 0..3 {
                forces[corner][i] = -self.volume * f[i];
            }
        }
        forces
    }
}

/// What blocks of stiffness are made of, once for all pairs of corners.
pub(crate) struct Stiffness<T> {
    curvature: Curvature<T>,
    /// 1/m, gradients in the frame of stretches
    gradient: [V3<T>; 4],
    /// m^3, volume times a factor
    factor: T,
}

impl<T: Real> Stiffness<T> {
    /// Of `scale` times a curvature.
    #[inline(always)]
    pub(crate) fn new(shape: &Tetrahedron<T>, scale: f64, curvature: Curvature<T>) -> Self {
        let (columns, mut gradient) = (transposed(&curvature.v), shape.gradient);
        for corner in 0..4 {
            gradient[corner] = times(&columns, shape.gradient[corner]);
        }
        Self { curvature, gradient, factor: shape.volume * scale }
    }

    /// Block (a, b), N/m.
    #[inline(always)]
    pub(crate) fn block(&self, a: usize, b: usize) -> M3<T> {
        let (c, a, b) = (&self.curvature, self.gradient[a], self.gradient[b]);
        let mut k = c.scaling;
        for i in 0..3 {
            k[i][i] = c.scaling[i][i] * a[i] * b[i];
            for j in 0..3 {
                if i != j {
                    k[i][j] = c.scaling[i][j] * a[i] * b[j] + c.other[i][j] * a[j] * b[i];
                    k[i][i] = k[i][i] + c.own[i][j] * a[j] * b[j];
                }
            }
        }
        for row in &mut k {
            for entry in row {
                *entry = self.factor * *entry;
            }
        }
        product(&c.u, &product_transposed(&k, &c.u))
    }
}

/// The same of a viscosity that acts on the rate of Green's strain, with shear `eta` and dilation `zeta`, Pa s.
pub(crate) struct Viscosity<T> {
    /// F F^T, and F times gradients, 1/m
    square: M3<T>,
    turned: [V3<T>; 4],
    gradient: [V3<T>; 4],
    /// Pa s m^3
    eta: T,
    zeta: T,
}

impl<T: Real> Viscosity<T> {
    /// At the deformation gradient `f`.
    #[inline(always)]
    pub(crate) fn new(shape: &Tetrahedron<T>, f: &M3<T>, (eta, zeta): (f64, f64)) -> Self {
        let (gradient, mut turned) = (shape.gradient, shape.gradient);
        for corner in 0..4 {
            turned[corner] = times(f, gradient[corner]);
        }
        let (eta, zeta) = (shape.volume * eta, shape.volume * zeta);
        Self { square: product_transposed(f, f), turned, gradient, eta, zeta }
    }

    /// Adds block (a, b), N s/m, to another.
    #[inline(always)]
    pub(crate) fn add(&self, a: usize, b: usize, to: &mut M3<T>) {
        let (p, q) = (self.turned[a], self.turned[b]);
        let both = dot(self.gradient[a], self.gradient[b]);
        for i in 0..3 {
            for j in 0..3 {
                let shear = self.square[i][j] * both + q[i] * p[j];
                to[i][j] = to[i][j] + self.eta * shear + self.zeta * p[i] * q[j];
            }
        }
    }
}

/// Adds the stress of that viscosity, Pa, to another: `F (2 eta E' + zeta tr(E') I)`, with `E'` the rate of Green's strain.
#[inline(always)]
pub(crate) fn add_viscous<T: Real>(f: &M3<T>, rate: &M3<T>, (eta, zeta): (f64, f64), stress: &mut M3<T>) {
    let (columns, rates) = (transposed(f), transposed(rate));
    let mut strain = *f;
    for i in 0..3 {
        for j in 0..3 {
            strain[i][j] = (dot(columns[i], rates[j]) + dot(rates[i], columns[j])) * 0.5;
        }
    }
    let pressure = (strain[0][0] + strain[1][1] + strain[2][2]) * zeta;
    for i in 0..3 {
        for j in 0..3 {
            strain[i][j] = strain[i][j] * (2.0 * eta);
        }
        strain[i][i] = strain[i][i] + pressure;
    }
    let viscous = product(f, &strain);
    for i in 0..3 {
        for j in 0..3 {
            stress[i][j] = stress[i][j] + viscous[i][j];
        }
    }
}

/// Values of the corners of an element.
#[inline(always)]
pub(crate) fn corners(nodes: [u32; 4], of: &[[f64; 3]]) -> [[f64; 3]; 4] {
    nodes.map(|n| of[n as usize])
}

/// Planes of rest data of a call.
pub(crate) fn planes<'a>(at: &Elements<'a>) -> [&'a [f64]; STRIDE] {
    std::array::from_fn(|s| at.rest_data(s))
}
