//! What a test body makes of an energy of vertex normals.

use super::body::Body;
use super::subject::Subject;
use crate::abi;
use crate::fault::Fault;

impl Body {
    /// Unit normals of nodes, of the area vectors of the `triangles` around each (n x 3).
    pub fn normals(&self, triangles: &[[u32; 3]]) -> Vec<[f64; 3]> {
        let mut sum = vec![[0.0; 3]; self.x.len()];
        for corners in triangles {
            let [a, b, c] = corners.map(|n| self.x[n as usize]);
            let [p, q] = [b, c].map(|x| [x[0] - a[0], x[1] - a[1], x[2] - a[2]]);
            let area = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
            corners.iter().for_each(|n| (0..3).for_each(|i| sum[*n as usize][i] += area[i]));
        }
        let unit = |n: [f64; 3]| n.map(|c| c / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt());
        sum.into_iter().map(unit).collect()
    }

    /// Energy with these unit normals (n x 3), J.
    ///
    /// # Errors
    /// What the material says.
    pub fn normals_energy<S: Subject + ?Sized>(&self, material: &S, normals: &[[f64; 3]]) -> Result<f64, Fault> {
        let mut energy = 0.0;
        self.each_triangle(usize::MAX, |call| {
            energy += material.normals_energy_of(call, normals)?;
            Ok(())
        })?;
        Ok(energy)
    }

    /// Forces at fixed normals, N, and slopes in them, J (n x 6).
    ///
    /// # Errors
    /// What the material says.
    pub fn normals_forces<S: Subject + ?Sized>(
        &self,
        material: &S,
        normals: &[[f64; 3]],
    ) -> Result<Vec<[f64; 6]>, Fault> {
        let mut out = vec![[0.0; 6]; self.x.len()];
        self.add_normals_forces_in(material, usize::MAX, normals, &mut out)?;
        Ok(out)
    }

    /// Adds the same to `out`, in ranges of at most `most` triangles.
    ///
    /// # Errors
    /// What the material says.
    pub fn add_normals_forces_in<S: Subject + ?Sized>(
        &self,
        material: &S,
        most: usize,
        normals: &[[f64; 3]],
        out: &mut [[f64; 6]],
    ) -> Result<(), Fault> {
        self.each_triangle(most, |call| material.normals_forces_of(call, normals, out))
    }

    /// How stiffly normals tilt across the sides of triangles, N m (3 x m, plane-major), and their corners (m).
    ///
    /// # Errors
    /// What the material says.
    pub fn tilts<S: Subject + ?Sized>(&self, material: &S) -> Result<(Vec<f64>, Vec<[u32; 3]>), Fault> {
        self.planes((abi::TRIANGLE, abi::WANTS_NORMALS), 3, |call, out| material.tilt_of(call, out))
    }

    fn each_triangle(
        &self,
        most: usize,
        mut run: impl FnMut(&super::Call<'_>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        self.each(
            abi::WANTS_NORMALS,
            most,
            |_, call| {
                if call.elements().kind() == abi::TRIANGLE { run(call) } else { Ok(()) }
            },
        )
    }
}
