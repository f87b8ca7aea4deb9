//! A triangle of constant strain in plane stress.

use pliant_plugin_api::TangentScale;

/// A vector in material coordinates.
pub type Vec2 = [f64; 2];
/// A vector in space.
pub type Vec3 = [f64; 3];

/// An isotropic elastic law in plane stress.
#[derive(Clone, Copy, Debug)]
pub struct PlaneStress {
    /// `Y / (1 - nu^2)`, Pa.
    axial: f64,
    /// Poisson's ratio.
    poisson: f64,
    /// Shear modulus, Pa.
    shear: f64,
}

impl PlaneStress {
    /// The law with this Young's modulus (Pa) and Poisson's ratio.
    pub fn new(young: f64, poisson: f64) -> Self {
        Self { axial: young / (1.0 - poisson * poisson), poisson, shear: 0.5 * young / (1.0 + poisson) }
    }

    /// The stress of a strain `[E11, E22, 2 E12]`, Pa.
    fn stress(self, [e, f, g]: Vec3) -> Vec3 {
        [self.axial * (e + self.poisson * f), self.axial * (f + self.poisson * e), self.shear * g]
    }
}

/// A triangle in its present state.
pub struct Triangle {
    law: PlaneStress,
    /// Volume times the undamaged fraction of it, m^3.
    intact: f64,
    /// Ratio of viscosity to stiffness, s.
    damping_time: f64,
    /// Gradients of the corners' shape functions by material coordinates, 1/m.
    gradients: [Vec2; 3],
    /// Columns of the deformation gradient.
    columns: [Vec3; 2],
    /// Green's strain `[E11, E22, 2 E12]`.
    strain: Vec3,
    /// Rate of the strain, 1/s.
    rate: Vec3,
}

fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The eigenvalues of a symmetric matrix `[[a, c], [c, b]]`, the larger first.
fn eigenvalues(a: f64, b: f64, c: f64) -> Vec2 {
    let (mean, half) = (0.5 * (a + b), 0.5 * (a - b));
    let radius = (half * half + c * c).sqrt();
    [mean + radius, mean - radius]
}

impl Triangle {
    /// A triangle with its corners at `x` (m) and `v` (m/s); `inverse` of its sides at rest (1/m), volume that is `intact` (m^3).
    pub fn new(
        x: [Vec3; 3],
        v: [Vec3; 3],
        inverse: [Vec2; 2],
        law: PlaneStress,
        intact: f64,
        damping_time: f64,
    ) -> Self {
        let [[a, b], [c, d]] = inverse;
        let gradients = [[-a - c, -b - d], [a, b], [c, d]];
        let column = |of: &[Vec3; 3], axis: usize| {
            [0, 1, 2].map(|i| (0..3).map(|corner| of[corner][i] * gradients[corner][axis]).sum::<f64>())
        };
        let columns = [column(&x, 0), column(&x, 1)];
        let rates = [column(&v, 0), column(&v, 1)];
        let [f, g] = columns;
        let strain = [0.5 * (dot(f, f) - 1.0), 0.5 * (dot(g, g) - 1.0), dot(f, g)];
        let rate = [dot(f, rates[0]), dot(g, rates[1]), dot(f, rates[1]) + dot(g, rates[0])];
        Self { law, intact, damping_time, gradients, columns, strain, rate }
    }

    /// The largest principal stretch minus 1.
    pub fn principal_strain(&self) -> f64 {
        let [green, _] = eigenvalues(self.strain[0], self.strain[1], 0.5 * self.strain[2]);
        (1.0 + 2.0 * green).max(0.0).sqrt() - 1.0
    }

    /// Elastic energy, J.
    pub fn energy(&self) -> f64 {
        0.5 * self.intact * dot(self.law.stress(self.strain), self.strain)
    }

    /// Derivatives of the strain by the position of a corner, 1/m: a row for each component.
    fn strain_gradient(&self, corner: usize) -> [Vec3; 3] {
        let ([f, g], [p, q]) = (self.columns, self.gradients[corner]);
        [f.map(|c| p * c), g.map(|c| q * c), [0, 1, 2].map(|i| p * g[i] + q * f[i])]
    }

    /// Forces on the corners, N.
    pub fn forces(&self) -> [Vec3; 3] {
        let strain = [0, 1, 2].map(|i| self.strain[i] + self.damping_time * self.rate[i]);
        let stress = self.law.stress(strain);
        [0, 1, 2].map(|corner| {
            let rows = self.strain_gradient(corner);
            [0, 1, 2].map(|i| -self.intact * (0..3).map(|k| stress[k] * rows[k][i]).sum::<f64>())
        })
    }

    /// The block of two corners, N/m. Compressive stress is left out of its geometric part, so that the matrix is positive semi-definite.
    pub fn block(&self, a: usize, b: usize, scale: TangentScale) -> [Vec3; 3] {
        let (left, right) = (self.strain_gradient(a), self.strain_gradient(b));
        let stressed = [0, 1, 2].map(|j| self.law.stress([0, 1, 2].map(|k| right[k][j])));
        let elastic = self.intact * (scale.stiffness + scale.damping * self.damping_time);
        let geometric = scale.stiffness * self.intact * self.tension(self.gradients[a], self.gradients[b]);
        [0, 1, 2].map(|i| {
            [0, 1, 2].map(|j| {
                let material: f64 = (0..3).map(|k| left[k][i] * stressed[j][k]).sum();
                elastic * material + if i == j { geometric } else { 0.0 }
            })
        })
    }

    /// `p . S q` with the tensile part of the stress S, Pa/m^2.
    fn tension(&self, p: Vec2, q: Vec2) -> f64 {
        let [a, b, c] = self.law.stress(self.strain);
        let [first, second] = eigenvalues(a, b, c);
        // S = first I - (first - second) n n^T along the second axis n.
        let apart = first - second;
        if apart <= 0.0 {
            return first.max(0.0) * (p[0] * q[0] + p[1] * q[1]);
        }
        let product = |m: [f64; 3]| p[0] * (m[0] * q[0] + m[2] * q[1]) + p[1] * (m[2] * q[0] + m[1] * q[1]);
        let of_first = [(a - second) / apart, (b - second) / apart, c / apart];
        let of_second = [(first - a) / apart, (first - b) / apart, -c / apart];
        first.max(0.0) * product(of_first) + second.max(0.0) * product(of_second)
    }
}
