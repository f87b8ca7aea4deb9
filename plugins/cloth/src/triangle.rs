//! A triangle with linear shape functions: one constant deformation gradient.

use crate::vector::{Vec2, Vec3};
use pliant_plugin_api::lanes::Real;
use pliant_plugin_api::{Elements, Fault};

/// Doubles of rest data per triangle: the shape function gradients of the last two corners (1/m) and the area (m^2).
pub(crate) const STRIDE: usize = 5;

/// Least area over the square of the longest side.
const MIN_ASPECT: f64 = 1e-9;

/// The rest shape of a triangle in the sheet.
#[derive(Clone, Copy)]
pub(crate) struct Triangle<T = f64> {
    /// Gradient of each corner's shape function along warp and weft, 1/m.
    pub(crate) gradient: [Vec2<T>; 3],
    /// Area at rest, m^2.
    pub(crate) area: T,
}

impl Triangle {
    /// From material coordinates, m; `None` where they are collinear or clockwise.
    pub(crate) fn new(u: [Vec2; 3]) -> Option<Self> {
        let side = |a: usize, b: usize| [u[b][0] - u[a][0], u[b][1] - u[a][1]];
        let (p, q, r) = (side(0, 1), side(0, 2), side(1, 2));
        let twice_area = p[0] * q[1] - p[1] * q[0];
        let longest = [p, q, r].iter().fold(0.0, |max: f64, s| max.max(s[0] * s[0] + s[1] * s[1]));
        if !(twice_area.is_finite() && longest > 0.0 && 0.5 * twice_area > MIN_ASPECT * longest) {
            return None;
        }
        let gradients = [[q[1] / twice_area, -q[0] / twice_area], [-p[1] / twice_area, p[0] / twice_area]];
        Some(Self::from_gradients(gradients, 0.5 * twice_area))
    }

    /// Element `e` of a call; the fault names it.
    pub(crate) fn of_element(elements: &Elements<'_>, e: usize) -> Result<Self, Fault> {
        let Some(u) = elements.material_coordinates::<3>().get(e) else {
            return Err(Fault::bad_argument("triangles of cloth need material coordinates"));
        };
        Self::new(*u).ok_or_else(|| {
            let number = elements.first_index() + e;
            Fault::bad_argument(format!(
                "triangle {number} has no area in the sheet, or its corners go clockwise: {u:?}"
            ))
        })
    }

    /// Rest data of the triangle: gradients of two shape functions, 1/m, and area, m^2.
    pub(crate) fn rest_data(&self) -> [f64; STRIDE] {
        let [_, b, c] = self.gradient;
        [b[0], b[1], c[0], c[1], self.area]
    }

    /// Element `e` from the planes of rest data.
    pub(crate) fn from_rest_data(planes: &[&[f64]; STRIDE], e: usize) -> Self {
        Self::from_gradients([[planes[0][e], planes[1][e]], [planes[2][e], planes[3][e]]], planes[4][e])
    }
}

impl<T: Real> Triangle<T> {
    /// From the shape function gradients of the last two corners, 1/m, and the area, m^2.
    #[inline(always)]
    pub(crate) fn from_gradients([b, c]: [Vec2<T>; 2], area: T) -> Self {
        Self { gradient: [[-(b[0] + c[0]), -(b[1] + c[1])], b, c], area }
    }

    /// `sum_a p_a gradient_a^T`, by columns: the deformation gradient F from positions, or its rate from velocities.
    #[inline(always)]
    pub(crate) fn deformation_gradient(&self, p: [Vec3<T>; 3]) -> [Vec3<T>; 2] {
        let [_, b, c] = self.gradient;
        let (first, second) = (p[1] - p[0], p[2] - p[0]);
        [first * b[0] + second * c[0], first * b[1] + second * c[1]]
    }

    /// Force on each corner, N, of a first Piola-Kirchhoff stress, by columns, N/m.
    #[inline(always)]
    pub(crate) fn forces(&self, [p, q]: [Vec3<T>; 2]) -> [Vec3<T>; 3] {
        let (minus_area, [a, b, c]) = (-self.area, self.gradient);
        [
            p * (minus_area * a[0]) + q * (minus_area * a[1]),
            p * (minus_area * b[0]) + q * (minus_area * b[1]),
            p * (minus_area * c[0]) + q * (minus_area * c[1]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_function_gradients_of_a_right_triangle() {
        let t = Triangle::new([[1.0, 1.0], [3.0, 1.0], [1.0, 5.0]]).unwrap();
        assert_eq!((t.area, t.gradient), (4.0, [[-0.5, -0.25], [0.5, 0.0], [-0.0, 0.25]]));
        let clockwise = Triangle::new([[1.0, 1.0], [1.0, 5.0], [3.0, 1.0]]);
        let collinear = Triangle::new([[0.0, 0.0], [1.0, 0.0], [2.0, 1e-10]]);
        let not_finite = Triangle::new([[0.0, 0.0], [1.0, 0.0], [f64::NAN, 1.0]]);
        assert!(clockwise.is_none() && collinear.is_none() && not_finite.is_none());
    }
}
