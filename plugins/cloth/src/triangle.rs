//! A triangle of linear weights at rest: one deformation gradient.

use crate::real::Real;
use crate::small::{M3, V2, V3, minus, mixed};
use pliant_plugin_api::{Elements, Fault};

/// Values of rest data: the gradients of the last two corners' weights, 1/m, and the area, m^2.
pub(crate) const STRIDE: usize = 5;

/// Least area over the square of the longest side.
const FLAT: f64 = 1e-9;

#[derive(Clone, Copy)]
pub(crate) struct Triangle<T = f64> {
    /// 1/m, gradient of each corner's weight, along warp and weft
    pub(crate) gradient: [V2<T>; 3],
    /// m^2
    pub(crate) area: T,
}

impl Triangle {
    /// From material coordinates, m; `None` where they have no area or go clockwise.
    pub(crate) fn new(u: [V2; 3]) -> Option<Self> {
        let side = |a: usize, b: usize| [u[b][0] - u[a][0], u[b][1] - u[a][1]];
        let (p, q, r) = (side(0, 1), side(0, 2), side(1, 2));
        let twice = p[0] * q[1] - p[1] * q[0];
        let longest = [p, q, r].iter().fold(0.0, |m: f64, s| m.max(s[0] * s[0] + s[1] * s[1]));
        if !(twice.is_finite() && longest > 0.0 && 0.5 * twice > FLAT * longest) {
            return None;
        }
        Some(Self::whole([[q[1] / twice, -q[0] / twice], [-p[1] / twice, p[0] / twice]], 0.5 * twice))
    }

    /// Of a call's element `e`, or a fault that names it.
    pub(crate) fn of(at: &Elements<'_>, e: usize) -> Result<Self, Fault> {
        let Some(u) = at.material::<3>().get(e) else {
            return Err(Fault::bad_argument("triangles of cloth need material coordinates"));
        };
        Self::new(*u).ok_or_else(|| {
            let number = at.first() + e;
            Fault::bad_argument(format!(
                "triangle {number} has no area in the sheet, or its corners go clockwise: {u:?}"
            ))
        })
    }

    pub(crate) fn values(&self) -> [f64; STRIDE] {
        let [_, b, c] = self.gradient;
        [b[0], b[1], c[0], c[1], self.area]
    }

    pub(crate) fn read(planes: &[&[f64]; STRIDE], e: usize) -> Self {
        Self::whole([[planes[0][e], planes[1][e]], [planes[2][e], planes[3][e]]], planes[4][e])
    }
}

impl<T: Real> Triangle<T> {
    #[inline(always)]
    pub(crate) fn whole([b, c]: [V2<T>; 2], area: T) -> Self {
        Self { gradient: [[-(b[0] + c[0]), -(b[1] + c[1])], b, c], area }
    }

    /// `sum_a p_a gradient_a^T` by columns: of positions the deformation gradient, of velocities its rate.
    #[inline(always)]
    pub(crate) fn derivative(&self, p: [V3<T>; 3]) -> [V3<T>; 2] {
        let [_, b, c] = self.gradient;
        let (along, aside) = (minus(p[1], p[0]), minus(p[2], p[0]));
        [mixed(b[0], along, c[0], aside), mixed(b[1], along, c[1], aside)]
    }

    /// N, on each corner, of a stress (first Piola-Kirchhoff, by columns, N/m)
    #[inline(always)]
    pub(crate) fn forces(&self, [p, q]: [V3<T>; 2]) -> [V3<T>; 3] {
        let (size, [a, b, c]) = (-self.area, self.gradient);
        [
            mixed(size * a[0], p, size * a[1], q),
            mixed(size * b[0], p, size * b[1], q),
            mixed(size * c[0], p, size * c[1], q),
        ]
    }
}

/// How the strain of a triangle changes with its corners, and what its energy makes of that.
pub(crate) struct Linear<T = f64> {
    /// 1/m, by corner: change of (11, 22, gamma) and of the frame's turn w for a step of the corner (3 x 4 x 3)
    pub(crate) rows: [[V3<T>; 4]; 3],
    /// N/m, second derivative of the energy in those four
    pub(crate) inner: [[T; 4]; 4],
    /// N/m, stress (11, 22, 12) that resists turning, and the directions in which it does
    pub(crate) tension: [T; 3],
    pub(crate) turning: M3<T>,
}

impl<T: Real> Linear<T> {
    /// Blocks (a, b), a <= b, times the area.
    #[inline(always)]
    pub(crate) fn blocks(&self, shape: &Triangle<T>) -> [M3<T>; 6] {
        let (g, s, h) = (&shape.gradient, self.tension, &self.inner);
        let zero = shape.area.of(0.0);
        let mut blocks = [[[zero; 3]; 3]; 6];
        let mut pair = 0;
        for a in 0..3 {
            // inner^T rows, N/m^2
            let (r, mut left) = (&self.rows[a], [[zero; 3]; 4]);
            for q in 0..4 {
                for i in 0..3 {
                    left[q][i] = h[0][q] * r[0][i] + h[1][q] * r[1][i] + h[2][q] * r[2][i] + h[3][q] * r[3][i];
                }
            }
            let pull = [s[0] * g[a][0] + s[2] * g[a][1], s[2] * g[a][0] + s[1] * g[a][1]];
            for b in a..3 {
                let r = &self.rows[b];
                let turn = pull[0] * g[b][0] + pull[1] * g[b][1];
                for i in 0..3 {
                    for j in 0..3 {
                        let inner =
                            left[0][i] * r[0][j] + left[1][i] * r[1][j] + left[2][i] * r[2][j] + left[3][i] * r[3][j];
                        blocks[pair][i][j] = shape.area * (inner + turn * self.turning[i][j]);
                    }
                }
                pair += 1;
            }
        }
        blocks
    }
}

/// The positive part of a symmetric 2 x 2 matrix (11, 22, 12).
#[inline(always)]
pub(crate) fn positive<T: Real>(s: [T; 3]) -> [T; 3] {
    let zero = s[0].of(0.0);
    let (mean, half) = ((s[0] + s[1]) * 0.5, (s[0] - s[1]) * 0.5);
    let radius = (half * half + s[2] * s[2]).sqrt();
    let (most, least) = (mean + radius, mean - radius);
    let share = (most.max(zero) - least.max(zero)) / (radius * 2.0).max(zero.of(f64::MIN_POSITIVE));
    let base = least.max(zero) - share * least;
    [base + share * s[0], base + share * s[1], share * s[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradients_of_a_right_triangle() {
        let t = Triangle::new([[1.0, 1.0], [3.0, 1.0], [1.0, 5.0]]).unwrap();
        assert_eq!((t.area, t.gradient), (4.0, [[-0.5, -0.25], [0.5, 0.0], [-0.0, 0.25]]));
        assert!(Triangle::new([[1.0, 1.0], [1.0, 5.0], [3.0, 1.0]]).is_none());
        assert!(Triangle::new([[0.0, 0.0], [1.0, 0.0], [2.0, 1e-10]]).is_none());
        assert!(Triangle::new([[0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0]]).is_none());
    }

    #[test]
    fn positive_parts() {
        let whole = positive([2.0, 1.0, 0.5]);
        assert!((0..3).all(|i| (whole[i] - [2.0, 1.0, 0.5][i]).abs() < 1e-15), "{whole:?}");
        assert_eq!(positive([-2.0, -1.0, 0.5]), [0.0; 3]);
        assert_eq!(positive([0.0; 3]), [0.0; 3]);
        // Eigenvalues 1 and -1 along the diagonals.
        let p = positive([0.0, 0.0, 1.0]);
        assert!(p.iter().all(|c| (c - 0.5).abs() < 1e-15), "{p:?}");
    }
}
