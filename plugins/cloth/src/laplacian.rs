//! Bending as Tripicchio, D'Avella and Ruffaldi (2022) have it, mended: the slopes of a triangle against the sheet's normals at its
//! corners.
//!
//! `E = area / 6 sum_i sum_k B_k (n_i . F_k)^2`, F_k what becomes of a step along warp or weft, n_i the unit normals. As printed every
//! term has another factor that vanishes on a flat sheet, so that its stiffness is 0 there and its energy goes with the fourth
//! power of curvature. B (N/m) depends on the mesh: for a rigidity D (N m) it is what gives a triangle with exact normals the
//! energy of a plate in a cylinder along warp and one along weft, `4 D / h^2` on a grid of edge h and `16/3 D / h^2` on equilateral
//! triangles. The normals are of the triangles around each node, so directions across a grid's diagonals come out too stiff.

use crate::bending::Rigidity;
use crate::dihedral;
use crate::small::{V2, V3, dot, mixed, scaled};
use crate::triangle::{self, Triangle};
use pliant_plugin_api::{Elements, Fault, NormalForces};

/// Values of rest data of a triangle: its own, then B along warp and weft, N/m.
pub(crate) const STRIDE: usize = triangle::STRIDE + 2;

/// rad, a fold at rest that counts as flat: what is left of flat sheets in files with few digits.
const FLAT: f64 = 1e-3;

/// Of the share of rigidity that a B would have alone, the least it may come to where warp and weft are found together.
const LEAST: f64 = 0.5;

/// N/m, B along warp and weft of a triangle at `u` (m).
pub(crate) fn stiffness(shape: &Triangle, u: [V2; 3], rigidity: &Rigidity) -> V2 {
    // m^2, `spread[j][k]`: squares of slopes along k, over the curvature's, of a cylinder along j.
    let spread = [0, 1].map(|j| {
        let slope = |k: usize| (0..3).map(|i| 0.5 * shape.gradient[i][k] * u[i][j] * u[i][j]).sum::<f64>();
        [0, 1].map(|k| {
            let (slope, square) = (slope(k), |d: f64| d * d);
            (0..3).map(|i| square(if k == j { u[i][j] } else { 0.0 } - slope)).sum::<f64>() / 3.0
        })
    });
    let d = [rigidity.warp, rigidity.weft];
    let alone = [0, 1].map(|k| d[k] / (spread[k][0] + spread[k][1]));
    let [[a, b], [c, e]] = spread;
    let det = a * e - b * c;
    let both = [(d[0] * e - d[1] * b) / det, (d[1] * a - d[0] * c) / det];
    // On slender triangles askew it may ask for a negative one.
    let sound = [0, 1].iter().all(|&k| both[k].is_finite() && both[k] >= LEAST * alone[k]);
    if sound { both } else { alone }
}

/// What bends of the triangles of a call.
pub(crate) struct Sheet<'a> {
    planes: [&'a [f64]; triangle::STRIDE],
    stiffness: [&'a [f64]; 2],
    nodes: &'a [[u32; 3]],
    x: &'a [V3],
    normals: &'a [V3],
}

impl<'a> Sheet<'a> {
    pub(crate) fn new(at: &Elements<'a>, normals: &'a [V3]) -> Self {
        let stiffness = [0, 1].map(|k| at.rest_data(triangle::STRIDE + k));
        let planes = core::array::from_fn(|s| at.rest_data(s));
        Self { planes, stiffness, nodes: at.corners::<3>(), x: at.x(), normals }
    }

    /// A triangle, its F by columns, B over 3 times its area, and its slopes against its corners' normals (3 x 2).
    fn look(&self, e: usize) -> (Triangle, [V3; 2], V2, [V2; 3]) {
        let shape = Triangle::read(&self.planes, e);
        let f = shape.derivative(self.nodes[e].map(|n| self.x[n as usize]));
        let third = shape.area / 3.0;
        let slopes = self.nodes[e].map(|n| f.map(|f| dot(self.normals[n as usize], f)));
        (shape, f, self.stiffness.map(|b| third * b[e]), slopes)
    }

    /// J
    pub(crate) fn energy(&self) -> f64 {
        let of = |e| {
            let (_, _, b, slopes) = self.look(e);
            slopes.iter().map(|s| 0.5 * (b[0] * s[0] * s[0] + b[1] * s[1] * s[1])).sum::<f64>()
        };
        (0..self.nodes.len()).map(of).sum()
    }

    /// Gives the sum of what it adds, to see whether all is finite.
    pub(crate) fn forces(&self, out: &mut NormalForces<'_>) -> f64 {
        let mut seen = 0.0;
        for (e, nodes) in self.nodes.iter().enumerate() {
            let (shape, f, b, slopes) = self.look(e);
            // N/m, over the area: dE/dF by columns.
            let pull = [0, 1].map(|k| {
                let sum =
                    (0..3).fold([0.0; 3], |sum, i| mixed(1.0, sum, slopes[i][k], self.normals[nodes[i] as usize]));
                scaled(sum, b[k] / shape.area)
            });
            for (i, force) in shape.forces(pull).into_iter().enumerate() {
                let slope = mixed(b[0] * slopes[i][0], f[0], b[1] * slopes[i][1], f[1]);
                out.add(nodes[i], force, slope);
                seen += force[0] + force[1] + force[2];
            }
        }
        seen
    }
}

/// N m, how stiffly normals tilt across the sides 01, 12, 20 of a triangle at `u` (m).
pub(crate) fn tilt(shape: &Triangle, u: [V2; 3], b: V2) -> [f64; 3] {
    [0, 1, 2].map(|side| {
        let (from, to) = (u[side], u[(side + 1) % 3]);
        let (along, aside) = (to[0] - from[0], to[1] - from[1]);
        shape.area / 3.0 * (b[0] * aside * aside + b[1] * along * along) / (along * along + aside * aside)
    })
}

/// Writes angles of hinges at rest, and refuses those that are folded.
pub(crate) fn flat(at: &Elements<'_>, [angles]: [&mut [f64]; 1]) -> Result<(), Fault> {
    for (e, &nodes) in at.corners::<4>().iter().enumerate() {
        angles[e] = dihedral::angle(nodes.map(|n| at.rest()[n as usize]));
        if angles[e].is_nan() || angles[e].abs() > FLAT {
            let (number, angle) = (at.first_index() + e, angles[e]);
            return Err(Fault::bad_argument(format!(
                "hinge {number} is folded by {angle:.3} rad at rest, nodes {nodes:?}; \
                 bending = projected-laplacian wants a sheet that is flat"
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(u: [V2; 3], d: V2) -> V2 {
        stiffness(&Triangle::new(u).unwrap(), u, &Rigidity { warp: d[0], weft: d[1], twist: 1.0 })
    }

    #[test]
    fn of_the_usual_triangles() {
        let near = |b: V2, wanted: V2| (0..2).all(|k| (b[k] / wanted[k] - 1.0).abs() < 1e-12);
        assert!(near(found([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]], [1.0, 2.0]), [400.0, 800.0]));
        // D_k / m_k, with 8/9: the same on these.
        let (h, top) = (0.1, 0.75_f64.sqrt() * 0.1);
        let b = found([[0.0, 0.0], [h, 0.0], [0.5 * h, top]], [1.0, 1.0]);
        assert!(near(b, [16.0 / 3.0 / (h * h); 2]), "{b:?}");
        let slender = found([[0.0, 0.0], [1.0, 1.0], [0.9, 1.0]], [1.0, 1e-3]);
        assert!(slender.iter().all(|b| b.is_finite() && *b > 0.0), "{slender:?}");
    }
}
