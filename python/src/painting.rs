//! Vertices of a body that strokes have pinned, and factors that they have painted.

use super::failure::{Failure, Kind};
use numpy::PyArray1;
use pliant_engine::body::Body;
use pyo3::prelude::*;

/// Vertices of a body that strokes have pinned, and factors that they have painted.
#[derive(Clone, Default)]
pub struct Painting {
    /// Pinned vertices, ascending.
    pinned: Vec<u32>,
    /// Parameters that a stroke may paint, with the factor at each vertex where it is not 1, ascending.
    factors: Vec<(String, Vec<(u32, f64)>)>,
}

impl Painting {
    /// The pinned and painted vertices of a body in its present state.
    pub fn of(body: &Body) -> Result<Self, Failure> {
        let factors = |param: &String| Ok((param.clone(), body.painted_vertices_of(param)?));
        let factors: Result<_, pliant_engine::body::LatticeError> = body.params.iter().map(factors).collect();
        let factors = factors.map_err(|error| Failure::new(Kind::Plugin, error))?;
        Ok(Self { pinned: body.pinned_vertices().collect(), factors })
    }

    /// Pinned vertices of the model, ascending (k).
    pub fn pinned_array<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_slice(py, &self.pinned)
    }

    /// Vertices whose parameter strokes have painted, and the factor of each.
    #[allow(clippy::type_complexity, reason = "two arrays")]
    pub fn painted_arrays<'py>(
        &self,
        py: Python<'py>,
        param: &str,
    ) -> Result<(Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>), Failure> {
        let Some((_, factors)) = self.factors.iter().find(|(known, _)| known == param) else {
            let known: Vec<String> = self.factors.iter().map(|(known, _)| format!("`{known}`")).collect();
            let known = if known.is_empty() { "none of the material's".into() } else { known.join(", ") };
            return Err(Failure::argument(format!("no parameter `{param}` can be painted; allowed is {known}")));
        };
        let (vertices, factors): (Vec<u32>, Vec<f64>) = factors.iter().copied().unzip();
        Ok((PyArray1::from_vec(py, vertices), PyArray1::from_vec(py, factors)))
    }
}
