//! Bending by the projected Laplacian of Tripicchio, D'Avella and Ruffaldi (2022), corrected: the slopes of a triangle against the sheet's
//! normals at its corners.
//!
//! `E = area / 6 sum_i sum_k B_k (n_i . F_k)^2`, with F_k the column of the deformation gradient along warp or weft and n_i the unit
//! normals. As printed, every term has a further factor that vanishes on a flat sheet, so that the stiffness there is 0 and the energy
//! grows with the fourth power of the curvature. B (N/m) depends on the mesh. For a rigidity D (N m), B is chosen so that a triangle with
//! exact normals has the energy of a plate in a cylinder along warp and in one along weft: `4 D / h^2` on a grid of edge h, and
//! `16/3 D / h^2` on equilateral triangles. The normals are means over the triangles around a node, so directions across the
//! diagonals of a grid come out too stiff.

use crate::bending::Rigidity;
use crate::dihedral;
use crate::triangle::{self, Triangle};
use crate::vector::{Vec2, Vec3};
use pliant_plugin_api::{Elements, Fault, NormalForces};

/// Doubles of rest data per triangle: those of [`Triangle`], then B along warp and weft, N/m.
pub(crate) const STRIDE: usize = triangle::STRIDE + 2;

/// Largest dihedral angle at rest that counts as flat, rad: the rounding of flat sheets in files with few digits.
const FLAT: f64 = 1e-3;

/// Least share of the B a direction has by itself that the joint solution may give it.
const MIN_SHARE: f64 = 0.5;

/// B along warp and weft, N/m, of a triangle at material coordinates `u` (m).
pub(crate) fn stiffness(shape: &Triangle, u: [Vec2; 3], rigidity: &Rigidity) -> Vec2 {
    // `spread[j][k]`, m^2: mean square of the slopes along k over the squared curvature, in a cylinder along j.
    let spread = [0, 1].map(|j| {
        let slope = |k: usize| (0..3).map(|i| 0.5 * shape.gradient[i][k] * u[i][j] * u[i][j]).sum::<f64>();
        [0, 1].map(|k| {
            let (slope, square) = (slope(k), |d: f64| d * d);
            (0..3).map(|i| square(if k == j { u[i][j] } else { 0.0 } - slope)).sum::<f64>() / 3.0
        })
    });
    let d = [rigidity.warp, rigidity.weft];
    let separate = [0, 1].map(|k| d[k] / (spread[k][0] + spread[k][1]));
    let [[a, b], [c, e]] = spread;
    let det = a * e - b * c;
    let joint = [(d[0] * e - d[1] * b) / det, (d[1] * a - d[0] * c) / det];
    // The joint solution may be negative for slender triangles at an angle to the warp.
    let is_usable = [0, 1].iter().all(|&k| joint[k].is_finite() && joint[k] >= MIN_SHARE * separate[k]);
    if is_usable { joint } else { separate }
}

/// The triangles of a call in their current state.
pub(crate) struct BendingTriangles<'a> {
    planes: [&'a [f64]; triangle::STRIDE],
    stiffness: [&'a [f64]; 2],
    nodes: &'a [[u32; 3]],
    x: &'a [[f64; 3]],
    normals: &'a [[f64; 3]],
}

/// One triangle in its current state.
struct BendingTriangle {
    shape: Triangle,
    /// Columns of the deformation gradient.
    f: [Vec3; 2],
    /// A third of the area times B along warp and weft, N m.
    stiffness: Vec2,
    /// Component of each column of F along each corner's normal (3 x 2).
    slopes: [Vec2; 3],
}

impl<'a> BendingTriangles<'a> {
    /// `normals` are the unit normals of all nodes.
    pub(crate) fn new(elements: &Elements<'a>, normals: &'a [[f64; 3]]) -> Self {
        let stiffness = [0, 1].map(|k| elements.rest_data(triangle::STRIDE + k));
        let planes = core::array::from_fn(|s| elements.rest_data(s));
        Self { planes, stiffness, nodes: elements.corners::<3>(), x: elements.x(), normals }
    }

    fn triangle(&self, e: usize) -> BendingTriangle {
        let shape = Triangle::from_rest_data(&self.planes, e);
        let f = shape.deformation_gradient(self.nodes[e].map(|n| Vec3(self.x[n as usize])));
        let third = shape.area / 3.0;
        let slopes = self.nodes[e].map(|n| f.map(|column| Vec3(self.normals[n as usize]).dot(column)));
        BendingTriangle { shape, f, stiffness: self.stiffness.map(|b| third * b[e]), slopes }
    }

    /// Bending energy of all triangles, J.
    pub(crate) fn energy(&self) -> f64 {
        let energy = |e| {
            let BendingTriangle { stiffness: b, slopes, .. } = self.triangle(e);
            slopes.iter().map(|s| 0.5 * (b[0] * s[0] * s[0] + b[1] * s[1] * s[1])).sum::<f64>()
        };
        (0..self.nodes.len()).map(energy).sum()
    }

    /// Adds forces and derivatives by the normals. Returns the sum of the forces' components, which is finite only if each is.
    pub(crate) fn add_forces(&self, out: &mut NormalForces<'_>) -> f64 {
        let mut sum = 0.0;
        for (e, nodes) in self.nodes.iter().enumerate() {
            let BendingTriangle { shape, f, stiffness: b, slopes } = self.triangle(e);
            // dE/dF per area, by columns, N/m.
            let stress = [0, 1].map(|k| {
                let weighted =
                    (0..3).fold(Vec3([0.0; 3]), |sum, i| sum + Vec3(self.normals[nodes[i] as usize]) * slopes[i][k]);
                weighted * (b[k] / shape.area)
            });
            for (i, Vec3(force)) in shape.forces(stress).into_iter().enumerate() {
                let Vec3(derivative) = f[0] * (b[0] * slopes[i][0]) + f[1] * (b[1] * slopes[i][1]);
                out.add(nodes[i], force, derivative);
                sum += force[0] + force[1] + force[2];
            }
        }
        sum
    }
}

/// Stiffness of the normals against tilting across the sides 01, 12, 20 of a triangle at `u` (m) with B `b` (N/m), N m.
pub(crate) fn tilt(shape: &Triangle, u: [Vec2; 3], b: Vec2) -> [f64; 3] {
    [0, 1, 2].map(|side| {
        let (from, to) = (u[side], u[(side + 1) % 3]);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        shape.area / 3.0 * (b[0] * dy * dy + b[1] * dx * dx) / (dx * dx + dy * dy)
    })
}

/// Writes the rest angles of hinges, rad; refuses a hinge that is not flat.
pub(crate) fn write_flat_angles(elements: &Elements<'_>, angles: &mut [f64]) -> Result<(), Fault> {
    for (e, &nodes) in elements.corners::<4>().iter().enumerate() {
        angles[e] = dihedral::angle(nodes.map(|n| Vec3(elements.rest()[n as usize])));
        if angles[e].is_nan() || angles[e].abs() > FLAT {
            let (number, angle) = (elements.first_index() + e, angles[e]);
            return Err(Fault::bad_argument(format!(
                "hinge {number} (nodes {nodes:?}) is folded by {angle:.3} rad at rest; \
                 bending = projected-laplacian needs a flat sheet: use coupled or hinge"
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stiffness_of(u: [Vec2; 3], d: Vec2) -> Vec2 {
        stiffness(&Triangle::new(u).unwrap(), u, &Rigidity { warp: d[0], weft: d[1], twist: 1.0 })
    }

    #[test]
    fn grid_and_equilateral_triangles_have_their_closed_forms() {
        let is_near = |b: Vec2, expected: Vec2| (0..2).all(|k| (b[k] / expected[k] - 1.0).abs() < 1e-12);
        assert!(is_near(stiffness_of([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1]], [1.0, 2.0]), [400.0, 800.0]));
        let (h, height) = (0.1, 0.75_f64.sqrt() * 0.1);
        let b = stiffness_of([[0.0, 0.0], [h, 0.0], [0.5 * h, height]], [1.0, 1.0]);
        assert!(is_near(b, [16.0 / 3.0 / (h * h); 2]), "{b:?}");
        let slender = stiffness_of([[0.0, 0.0], [1.0, 1.0], [0.9, 1.0]], [1.0, 1e-3]);
        assert!(slender.iter().all(|b| b.is_finite() && *b > 0.0), "{slender:?}");
    }
}
