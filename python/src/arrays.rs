//! Vectors of the engine as numpy arrays.

use numpy::ndarray::ArrayView2;
use numpy::{Element, PyArray2, PyArrayMethods};
use pliant_solver::Vec3;
use pyo3::prelude::*;

/// A copy of vectors as an array (n x 3).
pub fn copy_vectors<'py>(py: Python<'py>, vectors: &[Vec3]) -> Bound<'py, PyArray2<f64>> {
    copy_rows(py, vectors.iter().map(|v| [v.x, v.y, v.z]), vectors.len())
}

/// A copy of `count` rows of three as an array (n x 3).
pub fn copy_rows<'py, T: Element + Copy>(
    py: Python<'py>,
    rows: impl Iterator<Item = [T; 3]>,
    count: usize,
) -> Bound<'py, PyArray2<T>> {
    let mut flat = Vec::with_capacity(3 * count);
    rows.for_each(|row| flat.extend(row));
    let rows = flat.len() / 3;
    let array = numpy::PyArray1::from_vec(py, flat);
    array.reshape([rows, 3]).expect("three columns of as many rows as there are")
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
