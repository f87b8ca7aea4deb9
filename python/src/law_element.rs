//! A tetrahedron with one deformation gradient, for laws written in Python.

use super::law::ENTRIES;
use nalgebra::{Matrix3, SMatrix, Vector3};
use pliant_plugin_api::Elements;

/// Second derivatives by the entries of the deformation gradient, row-major.
pub type Stiffness = SMatrix<f64, ENTRIES, ENTRIES>;

/// Doubles of rest data per element: the shape function gradients of the last three corners (1/m), then the volume (m^3).
pub const STRIDE: usize = 10;

/// The rest shape of a tetrahedron.
pub struct Tetrahedron {
    /// Gradient of each corner's shape function, 1/m.
    gradients: [Vector3<f64>; 4],
    /// Volume at rest that belongs to the body, m^3.
    pub volume: f64,
}

impl Tetrahedron {
    /// From the rest positions of its corners (m) and the share of it that belongs to the body; `None` where the volume is not positive.
    pub fn new(x: [[f64; 3]; 4], share: f64) -> Option<Self> {
        let edges = edges(x);
        let six_volumes = edges.determinant();
        if !(six_volumes.is_finite() && six_volumes > 0.0 && share > 0.0) {
            return None;
        }
        let inverse = edges.try_inverse()?;
        let [b, c, d] = [0, 1, 2].map(|row| inverse.row(row).transpose());
        Some(Self { gradients: [-(b + c + d), b, c, d], volume: share * six_volumes / 6.0 })
    }

    /// Its rest data.
    pub fn rest_data(&self) -> [f64; STRIDE] {
        std::array::from_fn(|s| if s < 9 { self.gradients[1 + s / 3][s % 3] } else { self.volume })
    }

    /// Element `e` of a call.
    pub fn of(elements: &Elements<'_>, e: usize) -> Self {
        let value = |s: usize| elements.rest_data(s)[e];
        let [b, c, d] = [0, 3, 6].map(|s| Vector3::new(value(s), value(s + 1), value(s + 2)));
        Self { gradients: [-(b + c + d), b, c, d], volume: value(9) }
    }

    /// The deformation gradient of positions, or its rate of velocities.
    pub fn gradient(&self, x: [[f64; 3]; 4]) -> Matrix3<f64> {
        let [_, b, c, d] = &self.gradients;
        edges(x) * Matrix3::from_rows(&[b.transpose(), c.transpose(), d.transpose()])
    }

    /// Force on each corner of a first Piola-Kirchhoff stress (Pa), N.
    pub fn forces(&self, stress: &Matrix3<f64>) -> [[f64; 3]; 4] {
        self.gradients.map(|gradient| (stress * gradient * -self.volume).into())
    }

    /// Stiffness between corners a and b of second derivatives of an energy density (Pa), N/m.
    pub fn block(&self, a: usize, b: usize, stiffness: &Stiffness) -> [[f64; 3]; 3] {
        let (p, q) = (&self.gradients[a], &self.gradients[b]);
        let entry = |i: usize, j: usize| {
            let mut sum = 0.0;
            for k in 0..3 {
                for l in 0..3 {
                    sum += p[k] * stiffness[(3 * i + k, 3 * j + l)] * q[l];
                }
            }
            self.volume * sum
        };
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }
}

/// Edges from the first corner as columns, m.
fn edges(x: [[f64; 3]; 4]) -> Matrix3<f64> {
    let [a, b, c, d] = x.map(Vector3::from);
    Matrix3::from_columns(&[b - a, c - a, d - a])
}

/// Vectors at the corners of an element.
pub fn at_corners(nodes: [u32; 4], vectors: &[[f64; 3]]) -> [[f64; 3]; 4] {
    nodes.map(|node| vectors[node as usize])
}

/// The derivative of the rate of Green's strain, (F^T F' + F'^T F) / 2, by F'.
pub fn strain_rate(f: &Matrix3<f64>) -> Stiffness {
    let mut map = Stiffness::zeros();
    for i in 0..3 {
        for j in 0..3 {
            for k in 0..3 {
                map[(3 * i + j, 3 * k + j)] += 0.5 * f[(k, i)];
                map[(3 * i + j, 3 * k + i)] += 0.5 * f[(k, j)];
            }
        }
    }
    map
}
