//! Points and vectors.

/// A point or vector in space: m, m/s, N or no unit, as its owner says. It is laid out as three numbers in a row.
pub type Vec3 = nalgebra::Vector3<f64>;
