//! Vectors of the engine as numpy arrays.

use super::failure::Failure;
use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pliant_mesh::geometry::cast;
use pliant_solver::Vec3;
use pyo3::prelude::*;

/// A copy of vectors as an array (n x 3).
pub fn copy_vectors<'py>(py: Python<'py>, vectors: &[Vec3]) -> Bound<'py, PyArray2<f64>> {
    copy_rows(py, vectors.iter().map(|v| [v.x, v.y, v.z]), vectors.len())
}

/// A copy of `count` rows of `N` numbers as an array (n x N).
pub fn copy_rows<'py, T: Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: impl Iterator<Item = [T; N]>,
    count: usize,
) -> Bound<'py, PyArray2<T>> {
    let mut flat = Vec::with_capacity(N * count);
    rows.for_each(|row| flat.extend(row));
    let rows = flat.len() / N;
    let array = numpy::PyArray1::from_vec(py, flat);
    array.reshape([rows, N]).expect("as many columns and rows as there are")
}

/// Vectors seen as rows of an array (n x 3), where they are.
pub fn rows_of(vectors: &[Vec3]) -> ArrayView2<'_, f64> {
    let flat: &[f64] = vectors.as_flattened_components();
    ArrayView2::from_shape((vectors.len(), 3), flat).expect("three columns of as many rows as there are")
}

/// Vectors as one slice of their components.
trait Components {
    fn as_flattened_components(&self) -> &[f64];
}

impl Components for [Vec3] {
    fn as_flattened_components(&self) -> &[f64] {
        bytemuck::cast_slice(self)
    }
}

/// The first triangle (m x 3) of `vertices` (n x 3) that a ray meets, from either side: lengths of `direction` along the ray, and the
/// number of the triangle.
#[pyfunction]
pub fn ray_cast(
    vertices: PyReadonlyArray2<'_, f64>,
    triangles: PyReadonlyArray2<'_, u32>,
    origin: [f64; 3],
    direction: [f64; 3],
) -> PyResult<Option<(f64, u32)>> {
    let wrong =
        |what: &str| Failure::argument(format!("{what} are not a contiguous array (n x 3); allowed is one that is"));
    let points: &[Vec3] = match vertices.as_slice() {
        Ok(flat) if vertices.shape()[1] == 3 => bytemuck::cast_slice(flat),
        _ => return Err(wrong("vertices").into()),
    };
    let corners = match triangles.as_slice() {
        Ok(flat) if triangles.shape()[1] == 3 => flat.as_chunks::<3>().0,
        _ => return Err(wrong("triangles").into()),
    };
    if let Some(vertex) = corners.iter().flatten().find(|v| **v as usize >= points.len()) {
        return Err(
            Failure::argument(format!("a triangle of vertex {vertex}; allowed is below {}", points.len())).into()
        );
    }
    let hit = cast(points, corners, origin.into(), direction.into());
    Ok(hit.map(|hit| (hit.time, hit.triangle)))
}
