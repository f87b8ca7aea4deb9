//! Points and vectors.

/// A point or vector in space, with the unit given by its owner. Its memory layout is three consecutive numbers.
pub type Vec3 = nalgebra::Vector3<f64>;

/// Bits of the coordinates of a point; the same for two points if they are at exactly one place, whatever the signs of their zeros.
pub fn place_bits(point: Vec3) -> [u64; 3] {
    point.map(|c| (c + 0.0).to_bits()).into()
}
