//! Bending stiffness along the edges of the mesh.
//!
//! `coupled` is the mixed method of Hellan (1967), Herrmann (1967) and Johnson (1973): each edge has one bending moment, and the moments of
//! a triangle's sides are coupled by the triangle's compliance, which the host assembles and solves. It converges on any mesh.
//! `hinge` takes each edge by itself, with the stiffness `D l^2 / (A1 + A2)` (Grinspun et al. 2003, with the factor that is exact for a
//! cylinder). It is cheaper and exact for equilateral triangles, but its error elsewhere depends on the mesh: up to three times too
//! stiff across the diagonals of a grid.

use crate::dihedral;
use crate::triangle::Triangle;
use crate::vector::{Vec2, Vec3};
use pliant_plugin_api::Fault;

/// Bending rigidity against curvature along warp and weft, and against twist, N m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rigidity {
    pub(crate) warp: f64,
    pub(crate) weft: f64,
    pub(crate) twist: f64,
}

impl Rigidity {
    /// From the rigidities of strips cut along warp, weft and, if known, at 45 degrees, N m. Refused unless the rigidity is positive in
    /// every direction.
    pub(crate) fn new(warp: f64, weft: f64, bias: Option<f64>) -> Result<Self, Fault> {
        let twist = bias.map_or((warp * weft).sqrt(), |bias| 0.5 * (4.0 * bias - warp - weft));
        if [warp, weft, twist].iter().all(|d| d.is_finite() && *d > 0.0) {
            return Ok(Self { warp, weft, twist });
        }
        let bias = bias.map_or("none".into(), |b| b.to_string());
        Err(Fault::bad_argument(format!(
            "bending rigidities: warp {warp}, weft {weft}, bias {bias} N m, twist {twist} N m from these; allowed is above zero, \
             and a bias above a quarter of warp and weft together"
        )))
    }

    /// `factor` times as stiff.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { warp: factor * self.warp, weft: factor * self.weft, twist: factor * self.twist }
    }

    /// Rigidity against curvature along a unit direction of the sheet, N m.
    pub(crate) fn in_direction(&self, [c, s]: Vec2) -> f64 {
        let (c, s) = (c * c, s * s);
        self.warp * c * c + self.weft * s * s + 2.0 * self.twist * c * s
    }

    /// Compliance between the sides 01, 12, 20 of a triangle at material coordinates `u` (m), m/N, as (0,0) (0,1) (0,2) (1,1) (1,2) (2,2):
    /// moments across the sides are those of a constant moment tensor. `None` for a triangle without area.
    pub(crate) fn compliance(&self, u: [Vec2; 3]) -> Option<[f64; 6]> {
        let shape = Triangle::new(u)?;
        let side_normal = |side: usize| {
            let (a, b) = (u[side], u[(side + 1) % 3]);
            let (x, y) = (b[1] - a[1], a[0] - b[0]);
            let norm = (x * x + y * y).sqrt();
            [x / norm, y / norm]
        };
        // The moment across each side from the tensor (11, 22, 12), and the inverse of that.
        let moments = [0, 1, 2].map(side_normal).map(|n| Vec3([n[0] * n[0], n[1] * n[1], 2.0 * n[0] * n[1]]));
        let tensor = inverse(&moments)?;
        let compliance = [1.0 / self.warp, 1.0 / self.weft, 2.0 / self.twist];
        let g =
            |p: usize, q: usize| shape.area * (0..3).map(|k| tensor[k][p] * compliance[k] * tensor[k][q]).sum::<f64>();
        Some([g(0, 0), g(0, 1), g(0, 2), g(1, 1), g(1, 2), g(2, 2)])
    }
}

/// The rest shape of an edge between two triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hinge {
    /// Length of the edge, m.
    pub(crate) length: f64,
    /// Dihedral angle at rest, rad.
    pub(crate) angle: f64,
    /// Area of both triangles together, m^2.
    pub(crate) area: f64,
    /// Second derivative of the energy by the angle, N m, where each hinge bends by itself.
    pub(crate) stiffness: f64,
}

/// Doubles of rest data per hinge: rest angle (rad), then length (m) if coupled, else stiffness (N m).
pub(crate) const STRIDE: usize = 2;
/// Doubles of rest data per hinge with yarn friction: also stiffness and limit of the friction element (N m).
pub(crate) const STRIDE_WITH_FRICTION: usize = 4;

impl Hinge {
    /// From the rest positions of its corners, m; `warp` is the direction of the warp in space. `None` where a triangle has no area.
    pub(crate) fn new(x: [Vec3; 4], rigidity: &Rigidity, warp: Vec3) -> Option<Self> {
        let [a, b, o, p] = x;
        let edge = b - a;
        let (left, right) = (edge.cross(o - a), (p - a).cross(edge));
        let (length, twice_area) = (edge.norm(), left.norm() + right.norm());
        let normal = left + right;
        let is_valid =
            length.is_finite() && length > 0.0 && twice_area.is_finite() && left.norm() > 0.0 && right.norm() > 0.0;
        if !is_valid {
            return None;
        }
        // The sheet bends about the edge, so the curvature is along the direction perpendicular to it: components along warp and weft.
        let warp_along_edge = warp.dot(edge) / length;
        let warp_across_edge = warp.dot(normal.cross(edge)) / (length * normal.norm()).max(1e-300);
        let norm = (warp_along_edge * warp_along_edge + warp_across_edge * warp_across_edge).sqrt();
        let direction = if norm > 1e-9 { [warp_across_edge / norm, warp_along_edge / norm] } else { [1.0, 0.0] };
        let d = rigidity.in_direction(direction);
        let stiffness = 2.0 * d * length * length / twice_area;
        Some(Self { length, angle: dihedral::angle(x), area: 0.5 * twice_area, stiffness })
    }
}

/// Inverse of the matrix with these rows, `inverse[row][column]`; `None` if it is singular.
fn inverse(rows: &[Vec3; 3]) -> Option<[[f64; 3]; 3]> {
    let columns = [rows[1].cross(rows[2]), rows[2].cross(rows[0]), rows[0].cross(rows[1])];
    let det = rows[0].dot(columns[0]);
    if !(det.is_finite() && det != 0.0) {
        return None;
    }
    Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| columns[j][i] / det)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bias_is_the_rigidity_at_45_degrees() {
        let d = Rigidity::new(20e-6, 8e-6, Some(11e-6)).unwrap();
        assert!((d.in_direction([0.5_f64.sqrt(), 0.5_f64.sqrt()]) - 11e-6).abs() < 1e-18);
        assert!(
            (d.in_direction([1.0, 0.0]) - 20e-6).abs() < 1e-18 && (d.in_direction([0.0, 1.0]) - 8e-6).abs() < 1e-18
        );
        assert!((Rigidity::new(4.0, 9.0, None).unwrap().twist - 6.0).abs() < 1e-12);
        let fault = Rigidity::new(20e-6, 8e-6, Some(7e-6)).unwrap_err();
        assert!(fault.reason.contains("0.000007"), "{fault}");
        assert!(Rigidity::new(0.0, 1.0, None).is_err() && Rigidity::new(1.0, f64::NAN, None).is_err());
    }

    #[test]
    fn compliance_of_a_constant_moment() {
        // Moments n . M n across the sides must have the energy area / 2 (M11^2 / D1 + M22^2 / D2 + 2 M12^2 / D12).
        let d = Rigidity { warp: 2.0, weft: 3.0, twist: 5.0 };
        let u = [[0.1, 0.2], [1.3, 0.1], [0.6, 0.9]];
        let g = d.compliance(u).unwrap();
        let moment = [0.7, -0.4, 0.3];
        let m = [0, 1, 2].map(|s| {
            let (a, b): (Vec2, Vec2) = (u[s], u[(s + 1) % 3]);
            let (x, y) = (b[1] - a[1], a[0] - b[0]);
            (x * x * moment[0] + y * y * moment[1] + 2.0 * x * y * moment[2]) / (x * x + y * y)
        });
        let full = [[g[0], g[1], g[2]], [g[1], g[3], g[4]], [g[2], g[4], g[5]]];
        let found: f64 = (0..9).map(|i| m[i / 3] * full[i / 3][i % 3] * m[i % 3]).sum();
        let area = Triangle::new(u).unwrap().area;
        let expected = area * (0.49 / 2.0 + 0.16 / 3.0 + 2.0 * 0.09 / 5.0);
        assert!((found - expected).abs() < 1e-12 * expected, "{found} {expected}");
    }
}
