//! Resistance to folding, along the edges.
//!
//! `coupled` is the mixed method of Hellan (1967), Herrmann (1967) and Johnson (1973): one bending moment an edge, and moments
//! of a triangle's sides act on each other through its compliance, which the host sums and solves. It converges on any mesh.
//! `hinge` takes each edge alone, `D l^2 / (A1 + A2)` (Grinspun et al. 2003, with the factor of a cylinder): cheaper, right for
//! equilateral triangles, and off by the mesh elsewhere (up to three times too stiff across a grid's diagonals).

use crate::dihedral;
use crate::small::{V2, V3, cross, dot, length, minus};
use crate::triangle::Triangle;
use pliant_plugin_api::Fault;

/// N m, against curvature along warp, weft and their product.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rigidity {
    pub(crate) warp: f64,
    pub(crate) weft: f64,
    pub(crate) twist: f64,
}

impl Rigidity {
    /// From the rigidities of warp, weft and, if known, of a strip cut at 45 degrees; all above zero, and so that every
    /// direction has one.
    pub(crate) fn new(warp: f64, weft: f64, bias: Option<f64>) -> Result<Self, Fault> {
        let twist = bias.map_or((warp * weft).sqrt(), |bias| 0.5 * (4.0 * bias - warp - weft));
        if [warp, weft, twist].iter().all(|d| d.is_finite() && *d > 0.0) {
            return Ok(Self { warp, weft, twist });
        }
        let bias = bias.map_or("none".into(), |b| b.to_string());
        Err(Fault::bad_argument(format!(
            "bending rigidities must be above zero, the bias above a quarter of the others' sum: warp {warp}, weft {weft}, \
             bias {bias} N m, which leaves {twist} for twist"
        )))
    }

    /// N m, against curvature along a unit direction of the sheet.
    pub(crate) fn along(&self, [c, s]: V2) -> f64 {
        let (c, s) = (c * c, s * s);
        self.warp * c * c + self.weft * s * s + 2.0 * self.twist * c * s
    }

    /// m/N, between the sides 01, 12, 20 of a triangle: of moments across them, the constant moment tensor they make.
    pub(crate) fn compliance(&self, u: [V2; 3]) -> Option<[f64; 6]> {
        let shape = Triangle::new(u)?;
        let normal = |side: usize| {
            let (a, b) = (u[side], u[(side + 1) % 3]);
            let (x, y) = (b[1] - a[1], a[0] - b[0]);
            let size = (x * x + y * y).sqrt();
            [x / size, y / size]
        };
        // Moment across each side from the tensor (11, 22, 12), and back.
        let across = [0, 1, 2].map(normal).map(|n| [n[0] * n[0], n[1] * n[1], 2.0 * n[0] * n[1]]);
        let tensor = inverse(&across)?;
        let soft = [1.0 / self.warp, 1.0 / self.weft, 2.0 / self.twist];
        let g = |p: usize, q: usize| shape.area * (0..3).map(|k| tensor[k][p] * soft[k] * tensor[k][q]).sum::<f64>();
        Some([g(0, 0), g(0, 1), g(0, 2), g(1, 1), g(1, 2), g(2, 2)])
    }
}

/// An edge between two triangles at rest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hinge {
    /// m
    pub(crate) length: f64,
    /// rad
    pub(crate) angle: f64,
    /// m^2, of both sides
    pub(crate) area: f64,
    /// N m, energy over angle squared, twice
    pub(crate) stiffness: f64,
}

/// Values of rest data of a hinge: angle, then length if coupled, else stiffness.
pub(crate) const STRIDE: usize = 2;
/// With friction, also the stiffness and limit of its catch.
pub(crate) const STRIDE_WITH_SLIP: usize = 4;

impl Hinge {
    /// From the rest places of its corners; `warp` is where the warp points in space.
    pub(crate) fn new(x: [V3; 4], rigidity: &Rigidity, warp: V3) -> Option<Self> {
        let [a, b, o, p] = x;
        let edge = minus(b, a);
        let (left, right) = (cross(edge, minus(o, a)), cross(minus(p, a), edge));
        let (l, twice) = (length(edge), length(left) + length(right));
        let normal = [0, 1, 2].map(|i| left[i] + right[i]);
        if !(l.is_finite() && l > 0.0 && twice.is_finite() && length(left) > 0.0 && length(right) > 0.0) {
            return None;
        }
        // The sheet bends about the edge, so along what is across it.
        let (along, aside) = (dot(warp, edge) / l, dot(warp, cross(normal, edge)) / (l * length(normal)).max(1e-300));
        let size = (along * along + aside * aside).sqrt();
        let direction = if size > 1e-9 { [aside / size, along / size] } else { [1.0, 0.0] };
        let d = rigidity.along(direction);
        Some(Self { length: l, angle: dihedral::angle(x), area: 0.5 * twice, stiffness: 2.0 * d * l * l / twice })
    }
}

fn inverse(m: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let columns = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let det = dot(m[0], columns[0]);
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
        assert!((d.along([0.5_f64.sqrt(), 0.5_f64.sqrt()]) - 11e-6).abs() < 1e-18);
        assert!((d.along([1.0, 0.0]) - 20e-6).abs() < 1e-18 && (d.along([0.0, 1.0]) - 8e-6).abs() < 1e-18);
        assert!((Rigidity::new(4.0, 9.0, None).unwrap().twist - 6.0).abs() < 1e-12);
        let fault = Rigidity::new(20e-6, 8e-6, Some(7e-6)).unwrap_err();
        assert!(fault.reason.contains("0.000007"), "{fault}");
        assert!(Rigidity::new(0.0, 1.0, None).is_err() && Rigidity::new(1.0, f64::NAN, None).is_err());
    }

    #[test]
    fn compliance_of_a_constant_moment() {
        // m_p = n_p . M n_p must cost area / 2 (M11^2 / D1 + M22^2 / D2 + 2 M12^2 / D12).
        let d = Rigidity { warp: 2.0, weft: 3.0, twist: 5.0 };
        let u = [[0.1, 0.2], [1.3, 0.1], [0.6, 0.9]];
        let g = d.compliance(u).unwrap();
        let moment = [0.7, -0.4, 0.3];
        let m = [0, 1, 2].map(|s| {
            let (a, b): (V2, V2) = (u[s], u[(s + 1) % 3]);
            let (x, y) = (b[1] - a[1], a[0] - b[0]);
            (x * x * moment[0] + y * y * moment[1] + 2.0 * x * y * moment[2]) / (x * x + y * y)
        });
        let full = [[g[0], g[1], g[2]], [g[1], g[3], g[4]], [g[2], g[4], g[5]]];
        let got: f64 = (0..9).map(|i| m[i / 3] * full[i / 3][i % 3] * m[i % 3]).sum();
        let area = Triangle::new(u).unwrap().area;
        let want = area * (0.49 / 2.0 + 0.16 / 3.0 + 2.0 * 0.09 / 5.0);
        assert!((got - want).abs() < 1e-12 * want, "{got} {want}");
    }
}
