//! Points and vectors.

/// A point or vector in space, with the unit given by its owner. Its memory layout is three consecutive numbers.
pub type Vec3 = nalgebra::Vector3<f64>;
