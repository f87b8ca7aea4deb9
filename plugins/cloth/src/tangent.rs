//! The stiffness blocks of a triangle from the derivatives of its strain.

use crate::triangle::Triangle;
use crate::vector::{Mat2, Mat3, Vec2, Vec3, Voigt};
use pliant_plugin_api::lanes::Real;

/// The second derivative of a triangle's energy, per area, in factors: strain derivatives ("B"), and stiffness in the strains ("D").
///
/// The strains are (11, 22, gamma) and the spin w of the frame. Only the last two corners are stored: a translation of the triangle
/// changes nothing, so the blocks of the first corner follow from theirs.
pub(crate) struct ElementTangent<T = f64> {
    /// Directions in the plane that rows refer to.
    pub(crate) axes: [Vec3<T>; 2],
    /// Derivative of (11, 22, gamma, w) by a displacement of the second and of the third corner along the axes, 1/m (2 x 4 x 2).
    pub(crate) strain_rows: [[Vec2<T>; 4]; 2],
    /// Second derivative of the energy by the strains, N/m: by (11, 22) as (11, 22, 12), and by gamma.
    pub(crate) strain_stiffness: [T; 4],
    /// Second derivative of the energy by each strain and the spin, and by the spin, N/m.
    pub(crate) spin_stiffness: [T; 4],
    /// Stress whose tension resists rotation (geometric stiffness), N/m.
    pub(crate) tension: Voigt<T>,
    /// Symmetric matrix that projects on the directions in which tension resists, as (11, 22, 33, 12, 13, 23).
    pub(crate) tension_projection: [T; 6],
}

impl<T: Real> ElementTangent<T> {
    /// Blocks (0,0) (0,1) (0,2) (1,1) (1,2) (2,2), N/m.
    #[inline(always)]
    pub(crate) fn blocks(&self, shape: &Triangle<T>) -> [Mat3<T>; 6] {
        let [bb, bc, cc] = self.blocks_of_last_corners(shape);
        let ([ab, ac], mut aa) = (blocks_with_first_corner([bb, bc, cc]), bb);
        for i in 0..3 {
            for j in 0..3 {
                aa[i][j] = (bb[i][j] + cc[i][j]) + (bc[i][j] + bc[j][i]);
            }
        }
        [aa, ab, ac, bb, bc, cc]
    }

    /// Off-diagonal blocks (0,1) (0,2) (1,2), N/m.
    #[inline(always)]
    pub(crate) fn off_diagonal_blocks(&self, shape: &Triangle<T>) -> [Mat3<T>; 3] {
        let all = self.blocks_of_last_corners(shape);
        let [ab, ac] = blocks_with_first_corner(all);
        [ab, ac, all[1]]
    }

    /// Blocks (1,1) (1,2) (2,2), N/m.
    #[inline(always)]
    fn blocks_of_last_corners(&self, shape: &Triangle<T>) -> [Mat3<T>; 3] {
        let ([_, b, c], [rows_b, rows_c]) = (shape.gradient, &self.strain_rows);
        let (stress_b, stress_c) = (self.stress_rows(rows_b, shape.area), self.stress_rows(rows_c, shape.area));
        let (pull_b, pull_c) = (self.geometric(b, shape.area), self.geometric(c, shape.area));
        let bb = self.to_space(transpose_product(rows_b, &stress_b), pull_b[0] * b[0] + pull_b[1] * b[1]);
        let bc = self.to_space(transpose_product(rows_b, &stress_c), pull_b[0] * c[0] + pull_b[1] * c[1]);
        let cc = self.to_space(transpose_product(rows_c, &stress_c), pull_c[0] * c[0] + pull_c[1] * c[1]);
        [bb, bc, cc]
    }

    /// D times the strain rows of a corner, times the area, N (4 x 2).
    #[inline(always)]
    fn stress_rows(&self, rows: &[Vec2<T>; 4], area: T) -> [Vec2<T>; 4] {
        let (d, m, r) = (self.strain_stiffness, self.spin_stiffness, rows);
        let mut out = *rows;
        for i in 0..2 {
            out[0][i] = area * (d[0] * r[0][i] + d[2] * r[1][i] + m[0] * r[3][i]);
            out[1][i] = area * (d[2] * r[0][i] + d[1] * r[1][i] + m[1] * r[3][i]);
            out[2][i] = area * (d[3] * r[2][i] + m[2] * r[3][i]);
            out[3][i] = area * (m[0] * r[0][i] + m[1] * r[1][i] + m[2] * r[2][i] + m[3] * r[3][i]);
        }
        out
    }

    /// Tension times a shape function gradient, times the area, N.
    #[inline(always)]
    fn geometric(&self, g: Vec2<T>, area: T) -> Vec2<T> {
        let s = self.tension;
        [area * (s[0] * g[0] + s[2] * g[1]), area * (s[2] * g[0] + s[1] * g[1])]
    }

    /// `axes m axes^T + geometric tension_projection`.
    #[inline(always)]
    fn to_space(&self, m: Mat2<T>, geometric: T) -> Mat3<T> {
        let ([t, u], n) = (self.axes, self.tension_projection);
        let (p, q) = (t * m[0][0] + u * m[0][1], t * m[1][0] + u * m[1][1]);
        let (n12, n13, n23) = (geometric * n[3], geometric * n[4], geometric * n[5]);
        let n = [[geometric * n[0], n12, n13], [n12, geometric * n[1], n23], [n13, n23, geometric * n[2]]];
        let mut out = n;
        for i in 0..3 {
            for j in 0..3 {
                out[i][j] = t[i] * p[j] + u[i] * q[j] + n[i][j];
            }
        }
        out
    }
}

/// Blocks (0,1) and (0,2): minus the sum of the other blocks of their columns.
#[inline(always)]
fn blocks_with_first_corner<T: Real>([bb, bc, cc]: [Mat3<T>; 3]) -> [Mat3<T>; 2] {
    let (mut ab, mut ac) = (bb, bb);
    for i in 0..3 {
        for j in 0..3 {
            ab[i][j] = -(bb[i][j] + bc[j][i]);
            ac[i][j] = -(bc[i][j] + cc[i][j]);
        }
    }
    [ab, ac]
}

/// The product `l^T r` of two 4 x 2 matrices.
#[inline(always)]
fn transpose_product<T: Real>(l: &[Vec2<T>; 4], r: &[Vec2<T>; 4]) -> Mat2<T> {
    let mut out = [r[0], r[0]];
    for i in 0..2 {
        for j in 0..2 {
            out[i][j] = l[0][i] * r[0][j] + l[1][i] * r[1][j] + l[2][i] * r[2][j] + l[3][i] * r[3][j];
        }
    }
    out
}

/// The positive semi-definite part of a symmetric 2 x 2 tensor (11, 22, 12): negative eigenvalues become zero.
#[inline(always)]
pub(crate) fn positive_part<T: Real>(s: Voigt<T>) -> Voigt<T> {
    let zero = s[0].splat(0.0);
    let (mean, half) = ((s[0] + s[1]) * 0.5, (s[0] - s[1]) * 0.5);
    let radius = (half * half + s[2] * s[2]).sqrt();
    let (larger, smaller) = (mean + radius, mean - radius);
    let share = (larger.max(zero) - smaller.max(zero)) / (radius * 2.0).max(radius.min_positive());
    let base = smaller.max(zero) - share * smaller;
    [base + share * s[0], base + share * s[1], share * s[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positive_part_by_the_signs_of_the_eigenvalues() {
        let definite = positive_part([2.0, 1.0, 0.5]);
        assert!((0..3).all(|i| (definite[i] - [2.0, 1.0, 0.5][i]).abs() < 1e-15), "{definite:?}");
        assert_eq!(positive_part([-2.0, -1.0, 0.5]), [0.0; 3]);
        assert_eq!(positive_part([0.0; 3]), [0.0; 3]);
        // Eigenvalues 1 and -1, along the diagonals.
        let p = positive_part([0.0, 0.0, 1.0]);
        assert!(p.iter().all(|c| (c - 0.5).abs() < 1e-15), "{p:?}");
    }
}
