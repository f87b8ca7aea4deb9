//! A tetrahedron with linear shape functions: one constant deformation gradient.

use super::matrix::{Mat3, apply, cofactors, determinant, transposed};
use crate::lanes::{Real, Vec3};
use crate::{Elements, Fault, Planes};

/// Doubles of rest data per element: the shape function gradients of the last three corners (1/m), then the volume (m^3).
pub const STRIDE: usize = 10;

/// The rest shape of a tetrahedron.
pub struct Tetrahedron<T = f64> {
    /// Gradient of each corner's shape function, 1/m.
    pub gradient: [Vec3<T>; 4],
    /// Volume at rest that belongs to the body, m^3, times the factor of the modulus if that varies per element.
    pub volume: T,
}

impl Tetrahedron {
    /// From the rest positions of its corners, m, and the share of it that belongs to the body; `None` where the volume is not
    /// positive.
    pub fn new(x: [Vec3; 4], share: f64) -> Option<Self> {
        let edges = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
        let six_volumes = determinant(&edges);
        if !(six_volumes.is_finite() && six_volumes > 0.0 && share > 0.0) {
            return None;
        }
        // With edges as rows, the columns of the inverse are the gradients: rows of the cofactors over the determinant.
        let gradients = cofactors(&edges).map(|row| Vec3(row.0.map(|c| c / six_volumes)));
        Some(Self::from_gradients(gradients, share * six_volumes / 6.0))
    }

    /// Rest data of the tetrahedron: gradients of three shape functions, 1/m, and volume, m^3.
    pub fn rest_data(&self) -> [f64; STRIDE] {
        let g = &self.gradient;
        std::array::from_fn(|s| if s < 9 { g[1 + s / 3][s % 3] } else { self.volume })
    }

    /// Element `e` from the planes of rest data.
    #[inline(always)]
    pub fn from_rest_data(planes: &[&[f64]; STRIDE], e: usize) -> Self {
        let value = |s: usize| planes[s][e];
        let gradients = [0, 3, 6].map(|s| Vec3([value(s), value(s + 1), value(s + 2)]));
        Self::from_gradients(gradients, value(9))
    }
}

impl<T: Real> Tetrahedron<T> {
    /// From the shape function gradients of the last three corners, 1/m, and the volume, m^3.
    #[inline(always)]
    pub fn from_gradients([b, c, d]: [Vec3<T>; 3], volume: T) -> Self {
        Self { gradient: [-(b + c + d), b, c, d], volume }
    }

    /// The shape with the gradients by which positions give the elastic deformation gradient `Fe = F Fp^-1`, for the inverse of Fp. Its
    /// volume is the same, for flow keeps it.
    #[inline(always)]
    pub fn after_flow(&self, inverse: &Mat3<T>) -> Self {
        let (columns, g) = (transposed(inverse), &self.gradient);
        Self::from_gradients([apply(&columns, g[1]), apply(&columns, g[2]), apply(&columns, g[3])], self.volume)
    }

    /// `sum_a p_a gradient_a^T`: the deformation gradient F from positions, or its rate from velocities.
    #[inline(always)]
    pub fn deformation_gradient(&self, p: [Vec3<T>; 4]) -> Mat3<T> {
        let mut out = [p[0]; 3];
        for i in 0..3 {
            let (a, b, c) = (p[1][i] - p[0][i], p[2][i] - p[0][i], p[3][i] - p[0][i]);
            for j in 0..3 {
                out[i][j] = a * self.gradient[1][j] + b * self.gradient[2][j] + c * self.gradient[3][j];
            }
        }
        out
    }

    /// Extent of the element across a crack with the unit normal `n`, m: `2 / sum_a |gradient_a . n|` (Oliver 1989). The greatest of all directions is that
    /// along the longest edge.
    pub fn crack_band_width(&self, n: Vec3<T>) -> T {
        let g = &self.gradient;
        let sum = g[0].dot(n).abs() + g[1].dot(n).abs() + g[2].dot(n).abs() + g[3].dot(n).abs();
        sum.splat(2.0) / sum
    }

    /// Force on each corner, N, of a first Piola-Kirchhoff stress, Pa.
    #[inline(always)]
    pub fn forces(&self, stress: &Mat3<T>) -> [Vec3<T>; 4] {
        let mut forces = self.gradient;
        for corner in 0..4 {
            forces[corner] = apply(stress, self.gradient[corner]) * -self.volume;
        }
        forces
    }
}

/// Vectors at the corners of an element.
#[inline(always)]
pub fn at_corners(nodes: [u32; 4], vectors: &[[f64; 3]]) -> [Vec3; 4] {
    nodes.map(|n| Vec3(vectors[n as usize]))
}

/// Planes of rest data of a call.
pub fn rest_planes<'a>(elements: &Elements<'a>) -> [&'a [f64]; STRIDE] {
    std::array::from_fn(|s| elements.rest_data(s))
}

/// Writes the rest data of a call, [`STRIDE`] planes. `factor` gives the factor of an element's modulus: energy and stress are proportional to the
/// modulus times the volume, so the stored volume includes it.
///
/// # Errors
/// A tetrahedron that has no volume at rest, or is inverted.
pub fn write_rest_data(
    elements: &Elements<'_>,
    factor: impl Fn(usize) -> f64,
    out: &mut Planes<'_>,
) -> Result<(), Fault> {
    let planes = out.first_planes::<STRIDE>();
    for (e, (&nodes, &share)) in elements.corners::<4>().iter().zip(elements.measure()).enumerate() {
        let Some(shape) = Tetrahedron::new(at_corners(nodes, elements.rest()), share * factor(e)) else {
            return Err(Fault::bad_argument("a tetrahedron has no volume at rest, or is inverted"));
        };
        shape.rest_data().into_iter().enumerate().for_each(|(s, value)| planes[s][e] = value);
    }
    Ok(())
}
