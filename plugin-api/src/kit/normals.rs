//! A test body's results for an energy of vertex normals.

use super::body::{Body, ElementPlanes};
use super::tested_material::MaterialUnderTest;
use crate::abi;
use crate::fault::Fault;

impl Body {
    /// Unit normals of nodes (n x 3): the normalised sum of the area vectors of the `triangles` around each.
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

    /// Energy for unit `normals` (n x 3), J.
    ///
    /// # Errors
    /// The material's fault.
    pub fn normals_energy<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        normals: &[[f64; 3]],
    ) -> Result<f64, Fault> {
        let mut energy = 0.0;
        self.for_each_triangle_call(usize::MAX, |call| {
            energy += material.call_normals_energy(call, normals)?;
            Ok(())
        })?;
        Ok(energy)
    }

    /// Forces at fixed normals, N, and derivatives by the normals, J (n x 6).
    ///
    /// # Errors
    /// The material's fault.
    pub fn normals_forces<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        normals: &[[f64; 3]],
    ) -> Result<Vec<[f64; 6]>, Fault> {
        let mut out = vec![[0.0; 6]; self.x.len()];
        self.add_normals_forces_in_calls(material, usize::MAX, normals, &mut out)?;
        Ok(out)
    }

    /// Adds [`Body::normals_forces`] to `out`, in calls of at most `max_elements` triangles.
    ///
    /// # Errors
    /// The material's fault.
    pub fn add_normals_forces_in_calls<S: MaterialUnderTest + ?Sized>(
        &self,
        material: &S,
        max_elements: usize,
        normals: &[[f64; 3]],
        out: &mut [[f64; 6]],
    ) -> Result<(), Fault> {
        self.for_each_triangle_call(max_elements, |call| material.call_normals_forces(call, normals, out))
    }

    /// Stiffness of normals against tilting across the sides 01, 12, 20 of triangles, N m (3 planes). Values not written are NaN.
    ///
    /// # Errors
    /// The material's fault.
    pub fn tilts<S: MaterialUnderTest + ?Sized>(&self, material: &S) -> Result<ElementPlanes<3>, Fault> {
        self.element_planes(abi::TRIANGLE, abi::WANTS_NORMALS, 3, |call, out| material.call_tilt(call, out))
    }

    /// Runs `run` on calls of at most `max_elements` triangles with [`abi::WANTS_NORMALS`].
    fn for_each_triangle_call(
        &self,
        max_elements: usize,
        mut run: impl FnMut(&super::Call<'_>) -> Result<(), Fault>,
    ) -> Result<(), Fault> {
        self.for_each_call(abi::WANTS_NORMALS, max_elements, |_, call| {
            if call.elements().kind() == abi::TRIANGLE { run(call) } else { Ok(()) }
        })
    }
}
