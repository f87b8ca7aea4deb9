//! Mean deformation of a cell.

use super::Lattice;
use nalgebra::Matrix3;
use pliant_solver::{Nodes, Vec3};

impl Lattice {
    /// Cofactor matrix of the mean deformation gradient of an active cell, from the undeformed grid: it maps normals of the rest shape to the present shape.
    pub fn normal_turn(&self, cell: u32, nodes: &Nodes) -> Matrix3<f64> {
        let moved = self.displacements(cell, nodes);
        let f = if self.source.plugin().is_some() {
            gradient_of_cube(&moved, self.edge())
        } else {
            let [a, b, c, d] =
                [0, 1, 2, 3].map(|corner| self.grid_rest(self.region.cell_corners[cell as usize][corner]));
            gradient_of_tetrahedron([a, b, c, d], [moved[0], moved[1], moved[2], moved[3]])
        };
        let column = |i: usize| f.column(i).into_owned();
        let [a, b, c] = [column(0), column(1), column(2)];
        Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
    }
}

/// Mean deformation gradient of a cube with this `edge`, whose corners have `moved` (both in m).
fn gradient_of_cube(moved: &[Vec3; 8], edge: f64) -> Matrix3<f64> {
    let mut f = Matrix3::identity();
    for (corner, u) in moved.iter().enumerate() {
        for axis in 0..3 {
            let sign = if corner >> axis & 1 == 1 { 0.25 } else { -0.25 };
            for i in 0..3 {
                f[(i, axis)] += sign * u[i] / edge;
            }
        }
    }
    f
}

/// Deformation gradient of a tetrahedron with these corners at rest, which have `moved` (both in m).
pub(super) fn gradient_of_tetrahedron([a, b, c, d]: [Vec3; 4], moved: [Vec3; 4]) -> Matrix3<f64> {
    let (u, v, w) = (b - a, c - a, d - a);
    let six_volumes = u.dot(&v.cross(&w));
    // Gradients of the last three barycentric coordinates.
    let slopes = [v.cross(&w), w.cross(&u), u.cross(&v)].map(|normal| normal / six_volumes);
    let moved = [1, 2, 3].map(|corner| moved[corner] - moved[0]);
    slopes.iter().zip(&moved).fold(Matrix3::identity(), |f, (slope, moved)| f + moved * slope.transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use pliant_mesh::testing::Random;

    #[test]
    fn a_linear_displacement_has_its_own_gradient() {
        let mut random = Random(4);
        for _ in 0..100 {
            let (g, edge) = (Matrix3::from_fn(|_, _| random.signed()), 0.1 + random.unit());
            let corners = [0; 4].map(|_| random.vector());
            let f = gradient_of_tetrahedron(corners, corners.map(|x| g * x + Vec3::x()));
            assert!((f - g - Matrix3::identity()).amax() < 1e-9, "{f}");
            let cube = std::array::from_fn(|c| g * Vec3::from_fn(|axis, _| (c >> axis & 1) as f64 * edge));
            assert!((gradient_of_cube(&cube, edge) - g - Matrix3::identity()).amax() < 1e-12);
        }
    }
}
