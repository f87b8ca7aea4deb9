//! A triangle of linear weights at rest: one deformation gradient.

use crate::small::{M2, M3, V2, V3, minus, mixed};
use pliant_plugin_api::lanes::Real;
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
        let Some(u) = at.material_coordinates::<3>().get(e) else {
            return Err(Fault::bad_argument("triangles of cloth need material coordinates"));
        };
        Self::new(*u).ok_or_else(|| {
            let number = at.first_index() + e;
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
    /// Directions in the plane, in which the rest is.
    pub(crate) axes: [V3<T>; 2],
    /// 1/m, of the last two corners: change of (11, 22, gamma) and of the frame's turn w for a step of the corner (2 x 4 x 2)
    pub(crate) rows: [[V2<T>; 4]; 2],
    /// N/m, second derivative of the energy in the strains alone: of (11, 22) as (11, 22, 12), and of gamma
    pub(crate) inner: [T; 4],
    /// N/m, the rest of it: of each strain with the turn, and of the turn
    pub(crate) turn: [T; 4],
    /// N/m, stress (11, 22, 12) that resists turning, and the directions in which it does, as (11, 22, 33, 12, 13, 23)
    pub(crate) tension: [T; 3],
    pub(crate) turning: [T; 6],
}

impl<T: Real> Linear<T> {
    /// Blocks (a, b), a <= b, times the area. Those of the first corner are what the others leave: moving all of the triangle
    /// changes nothing.
    #[inline(always)]
    pub(crate) fn blocks(&self, shape: &Triangle<T>) -> [M3<T>; 6] {
        let [bb, bc, cc] = self.last(shape);
        let ([ab, ac], mut aa) = (first([bb, bc, cc]), bb);
        for i in 0..3 {
            for j in 0..3 {
                aa[i][j] = (bb[i][j] + cc[i][j]) + (bc[i][j] + bc[j][i]);
            }
        }
        [aa, ab, ac, bb, bc, cc]
    }

    /// Those of two corners, a < b.
    #[inline(always)]
    pub(crate) fn between(&self, shape: &Triangle<T>) -> [M3<T>; 3] {
        let all = self.last(shape);
        let [ab, ac] = first(all);
        [ab, ac, all[1]]
    }

    /// Those of the last two corners.
    #[inline(always)]
    fn last(&self, shape: &Triangle<T>) -> [M3<T>; 3] {
        let ([_, b, c], [at_b, at_c]) = (shape.gradient, &self.rows);
        let (of_b, of_c) = (self.stress(at_b, shape.area), self.stress(at_c, shape.area));
        let (pull_b, pull_c) = (self.pull(b, shape.area), self.pull(c, shape.area));
        let bb = self.in_space(product(at_b, &of_b), pull_b[0] * b[0] + pull_b[1] * b[1]);
        let bc = self.in_space(product(at_b, &of_c), pull_b[0] * c[0] + pull_b[1] * c[1]);
        let cc = self.in_space(product(at_c, &of_c), pull_c[0] * c[0] + pull_c[1] * c[1]);
        [bb, bc, cc]
    }

    /// Change of stresses for a step of a corner, N/m, times the area (4 x 2)
    #[inline(always)]
    fn stress(&self, rows: &[V2<T>; 4], area: T) -> [V2<T>; 4] {
        let (h, m, r) = (self.inner, self.turn, rows);
        let mut out = *rows;
        for i in 0..2 {
            out[0][i] = area * (h[0] * r[0][i] + h[2] * r[1][i] + m[0] * r[3][i]);
            out[1][i] = area * (h[2] * r[0][i] + h[1] * r[1][i] + m[1] * r[3][i]);
            out[2][i] = area * (h[3] * r[2][i] + m[2] * r[3][i]);
            out[3][i] = area * (m[0] * r[0][i] + m[1] * r[1][i] + m[2] * r[2][i] + m[3] * r[3][i]);
        }
        out
    }

    /// What resists a corner's turn, N, times the area.
    #[inline(always)]
    fn pull(&self, g: V2<T>, area: T) -> V2<T> {
        let s = self.tension;
        [area * (s[0] * g[0] + s[2] * g[1]), area * (s[2] * g[0] + s[1] * g[1])]
    }

    /// `axes m axes^T`, and `turn` in the directions of turning.
    #[inline(always)]
    fn in_space(&self, m: M2<T>, turn: T) -> M3<T> {
        let ([t, u], n) = (self.axes, self.turning);
        let (p, q) = (mixed(m[0][0], t, m[0][1], u), mixed(m[1][0], t, m[1][1], u));
        let (n12, n13, n23) = (turn * n[3], turn * n[4], turn * n[5]);
        let n = [[turn * n[0], n12, n13], [n12, turn * n[1], n23], [n13, n23, turn * n[2]]];
        let mut out = n;
        for i in 0..3 {
            for j in 0..3 {
                out[i][j] = t[i] * p[j] + u[i] * q[j] + n[i][j];
            }
        }
        out
    }
}

/// What the blocks of the last two corners leave of those of the first with them.
#[inline(always)]
fn first<T: Real>([bb, bc, cc]: [M3<T>; 3]) -> [M3<T>; 2] {
    let (mut ab, mut ac) = (bb, bb);
    for i in 0..3 {
        for j in 0..3 {
            ab[i][j] = -(bb[i][j] + bc[j][i]);
            ac[i][j] = -(bc[i][j] + cc[i][j]);
        }
    }
    [ab, ac]
}

/// `left^T right`
#[inline(always)]
fn product<T: Real>(l: &[V2<T>; 4], r: &[V2<T>; 4]) -> M2<T> {
    let mut out = [r[0], r[0]];
    for i in 0..2 {
        for j in 0..2 {
            out[i][j] = l[0][i] * r[0][j] + l[1][i] * r[1][j] + l[2][i] * r[2][j] + l[3][i] * r[3][j];
        }
    }
    out
}

/// The positive part of a symmetric 2 x 2 matrix (11, 22, 12).
#[inline(always)]
pub(crate) fn positive<T: Real>(s: [T; 3]) -> [T; 3] {
    let zero = s[0].splat(0.0);
    let (mean, half) = ((s[0] + s[1]) * 0.5, (s[0] - s[1]) * 0.5);
    let radius = (half * half + s[2] * s[2]).sqrt();
    let (most, least) = (mean + radius, mean - radius);
    let share = (most.max(zero) - least.max(zero)) / (radius * 2.0).max(radius.min_positive());
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
